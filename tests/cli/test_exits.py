"""Errors that end a command: their messages and exit codes."""

import errno
import json
import os
import sys

import pytest
from commands import command
from typer.testing import CliRunner

from bubblemesh import console
from bubblemesh.batch.row import Row
from bubblemesh.cli import app, exits


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "case.yaml", "--x\x1b]0;title\x07"],
        ["run", "case.yaml", "other\x1b[31m"],
        ["\x1b[31mrun"],
        ["--\x9b31m"],
        ["run", "\x1b[31m\udcff.yaml"],
        ["batch", "\x1b[31m.yaml", "-o", "\x1b[32m"],
        ["init", "\x1b[31m.yaml"],
        ["quality", "\x1b[31m.msh"],
    ],
)
def test_names_and_options_never_steer_the_terminal(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, arguments)
    assert result.output.replace("\n", "").isprintable()
    assert r"\x" in result.output


OUTER = [  # errors of the system, and what is told of each
    (OSError(errno.EMFILE, "Too many open files"), "Too many open files: let this process open more (ulimit -n"),
    (OSError(errno.ENFILE, "Too many open files"), "Too many open files: let this process open more (ulimit -n"),
    (OSError(errno.ENAMETOOLONG, "File name too long", 300 * "x"), f"{57 * 'x'}...: File name too long: shorten it"),
    (
        UnicodeEncodeError("ascii", "B\xe4r", 1, 2, ""),
        "'B\xe4r' cannot be written where names are in ascii: set PYTHONUTF8=1",
    ),
]


@pytest.mark.parametrize(("error", "text"), OUTER)
def test_an_error_of_the_system_tells_what_to_do(error, text, monkeypatch):
    def refuse(*arguments, **options):
        raise error

    monkeypatch.setattr("bubblemesh.case.load_case", refuse)
    result = CliRunner().invoke(app, ["check", "case.yaml"])
    assert result.exit_code == 5
    assert result.stderr.startswith(f"error: {text}")
    row = Row("case", "case.yaml", 0).ended_by(error)
    assert (row.exit_code, row.traceback) == (5, None)
    assert row.error.startswith(f"case.yaml: {text}")


@pytest.mark.parametrize(
    "arguments",
    [
        ["batch", f"{300 * 'x'}.yaml"],
        ["run", "case.yaml", "-o", "deep/" * 2000],
    ],
)
def test_names_that_are_too_long_are_refused(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text("domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.5\n")
    code, out, message = command(*arguments)
    assert (code, out) == (5, "")
    assert "File name too long: shorten it" in message


@pytest.mark.skipif(os.name == "nt", reason="Windows keeps the current folder")
@pytest.mark.parametrize("arguments", [["run", "-"], ["check", "../case.yaml"], ["batch", "../case.yaml"]])
def test_a_current_folder_that_was_removed_is_told(arguments, tmp_path, monkeypatch):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    text = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.5\n"
    (tmp_path / "case.yaml").write_text(text)
    message = "error: the current folder is not there any more: go to another one (cd)\n"
    assert command(*arguments, stdin=text) == (5, "", message)


def test_a_library_that_was_removed_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for module in [name for name in sys.modules if name.startswith("matplotlib.")]:
        monkeypatch.delitem(sys.modules, module)
    (tmp_path / "mesh.node").write_text("")
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["plot", "mesh.node"])
    assert result.exit_code == 5
    assert result.stderr == "error: matplotlib is needed for this and not installed: install bubblemesh anew\n"
    assert "Traceback" not in result.output


def test_a_module_of_our_own_that_is_missing_is_our_error(monkeypatch):
    monkeypatch.setitem(sys.modules, "bubblemesh.pictures.start", None)
    result = CliRunner().invoke(app, ["plot", "mesh.node"])
    assert result.exit_code == 1
    assert "this is an error of bubblemesh" in result.stderr


def test_an_interrupt_lets_a_message_be_told_to_its_end(monkeypatch, capsys):
    monkeypatch.setattr(exits, "received", [])

    class Interrupting:
        def __rich_console__(self, console, options):
            exits.interrupt(2, None)
            yield "told"

    console.terminal.print(Interrupting())
    assert capsys.readouterr().err == "told\n"
    with pytest.raises(exits.Interrupted):
        exits.heed()
    with pytest.raises(exits.Interrupted):
        exits.interrupt(2, None)
    assert exits.received == [2, 2]


def test_only_an_interrupt_that_a_finalizer_drops_is_not_told_of(monkeypatch, capsys):
    told = []
    monkeypatch.setattr(sys, "__unraisablehook__", told.append)
    monkeypatch.setattr(sys, "unraisablehook", exits._tell_of_dropped)
    for error in (exits.Interrupted, ZeroDivisionError):

        class Faulty:
            def __del__(self, error=error):
                raise error

        Faulty()
    assert [what.exc_type for what in told] == [ZeroDivisionError]


@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (["check", "bow.yaml"], 3, "bow.yaml:1: domain: the outer ring crosses or touches itself at (0.5, 0.5): "),
        (["run", "bow.yaml", "-q"], 3, "bow.yaml:1: domain: the outer ring crosses or touches itself at (0.5, 0.5): "),
        (["check", "none.yaml"], 5, "none.yaml: the case file cannot be read: "),
        (["quality", "none.msh"], 5, "none.msh: the file cannot be read: "),
        (["convert", "none.msh", "a.vtu"], 5, "none.msh: the file cannot be read: "),
    ],
)
def test_json_has_the_error_of_what_fails(arguments, code, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bow.yaml").write_text("domain: {outer: {polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]}}\nspacing: 0.1\n")
    result = CliRunner().invoke(app, [*arguments, "--json"])
    data = json.loads(result.stdout)
    assert (result.exit_code, data["exit_code"]) == (code, code)
    assert data["error"].startswith(told)
    assert result.stderr.startswith(f"error: {told}")
    assert CliRunner().invoke(app, arguments).stdout == ""


def test_json_of_a_mesh_that_misses_a_requirement_is_its_report(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.5\nrequire: {quality_mean: 0.9999}\n"
    result = CliRunner().invoke(app, ["run", "-", "--json", "-q", "-o", "out"], input=text)
    assert result.exit_code == 4
    assert json.loads(result.stdout)["quality"]["mean"] < 0.9999
