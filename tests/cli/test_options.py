"""Options that set keys of the case: a row in each of two tables, and every command that reads a case has them."""

from importlib import reload
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from bubblemesh import load_case
from bubblemesh.case import overrides
from bubblemesh.case.overrides import Override, overrides_of
from bubblemesh.cli import adapt, batch, check, options, run
from bubblemesh.errors import CaseError

COMMANDS = (run, adapt, check, batch)
CASE = """\
domain: {outer: {rectangle: [0, 0, 1, 1], label: wall}}
spacing: 0.4
schedule: {rounds: 1, iterations: 5}
output: {formats: [msh]}
"""


@pytest.fixture
def with_option_called(tmp_path, monkeypatch):
    """Runs commands that have an option ``--called`` for the case's name, as its two rows are all that is added."""
    (tmp_path / "case.yaml").write_text(CASE)
    monkeypatch.chdir(tmp_path)
    with monkeypatch.context() as tables:
        tables.setitem(overrides.OPTIONS, "called", ("name",))
        tables.setitem(options.CASE_OPTIONS, "called", Annotated[str | None, typer.Option(help="Name of the mesh.")])
        app = typer.Typer()
        for module in COMMANDS:
            reload(module)
            app.command()(getattr(module, module.__name__.split(".")[-1]))
        yield lambda *arguments: CliRunner().invoke(app, arguments)
    for module in COMMANDS:
        reload(module)


@pytest.mark.usefixtures("workers_in_threads")
@pytest.mark.parametrize("command", ["run", "check", "batch"])
def test_an_option_is_a_row_in_each_of_two_tables(command, with_option_called, tmp_path):
    assert with_option_called(command, "case.yaml", "--called", "plate").exit_code == 0
    if command != "check":
        assert (tmp_path / "plate.msh").exists()
    refused = with_option_called(command, "case.yaml", "--called", "a/b")
    assert "--called: name: " in str(refused.exception)


def test_every_command_that_reads_a_case_shows_the_option(with_option_called):
    for command in ("run", "adapt", "check", "batch"):
        assert "Name of the mesh." in with_option_called(command, "--help").output


def test_both_tables_have_the_same_rows():
    assert [*overrides.OPTIONS] == [name for name in options.CASE_OPTIONS if name != "set"]


def test_options_stand_over_settings_in_either_form():
    given = [Override(("method",), "fnpbs", "a table"), "packing.seed=3"]
    found = overrides_of(given, of_command=True, seed=4, method=None)
    assert [(one.path, one.value, one.source) for one in found] == [
        (("method",), "fnpbs", "a table"),
        (("packing", "seed"), 3, "--set packing.seed"),
        (("packing", "seed"), 4, "--seed"),
    ]
    case = load_case("case.yaml", text=CASE, overrides=given, seed=4)
    assert (case.method, case.packing) == ("fnpbs", {"seed": 4})


def test_python_knows_the_same_options_and_no_other():
    assert load_case("case.yaml", text=CASE, time_limit=5).limits.seconds == 5
    with pytest.raises(CaseError, match=r"^time_limit: limits\.seconds: "):
        load_case("case.yaml", text=CASE, time_limit=-5)
    with pytest.raises(CaseError, match=r"overrides: must be a list of texts, as in \['spacing=1'\]"):
        load_case("case.yaml", text=CASE, overrides="spacing=1")
    with pytest.raises(TypeError, match=r"no option of a case: color \(there are: method, seed"):
        load_case("case.yaml", text=CASE, color="red")
