"""What the commands do to a case, done by a program."""

from contextlib import nullcontext

import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, FileError, RequirementError
from bubblemesh.run.output import OutputOptions, place_of
from bubblemesh.run.packing import RunOptions
from bubblemesh.run.pipeline import run_case
from bubblemesh.run.preview import preview
from bubblemesh.run.writing import mesh_and_write

CASE = """\
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: 0.4
schedule: {rounds: 1, iterations: 5}
output: {formats: [msh]}
"""


class Listener:
    """Notes what it is called with."""

    def __init__(self):
        self.rounds, self.shares = [], []
        self.show, self.advance = self.rounds.append, self.shares.append


def test_a_case_is_meshed_watched_and_written(tmp_path):
    case = load_case("one.yaml", text=f"{CASE}require: {{quality_min: 0.9999}}\n")
    place = place_of(case, "one.yaml", OutputOptions(f"{tmp_path}/out/"))
    listener = Listener()
    result, report = mesh_and_write(
        lambda *told: run_case(case, RunOptions(*told)), case, "one.yaml", place, nullcontext(listener)
    )
    assert [row.round for row in listener.rounds] == [1, 2]
    assert listener.shares[-1] == pytest.approx(1)
    assert report["files"] == sorted(path.name for path in (tmp_path / "out").iterdir())
    assert report["triangles"] == len(result.mesh.triangles)
    assert isinstance(result.verdict, RequirementError)


def test_a_result_that_cannot_be_written_is_not_made(tmp_path):
    (tmp_path / "out").write_text("no folder")
    case = load_case("one.yaml", text=CASE)
    place = place_of(case, "one.yaml", OutputOptions(f"{tmp_path}/out/"))
    with pytest.raises(FileError):
        mesh_and_write(pytest.fail, case, "one.yaml", place, nullcontext(Listener()))


def test_a_preview_has_figures_and_places_of_errors():
    figures = preview(load_case("one.yaml", text=CASE), "one.yaml")
    assert figures["area"] == pytest.approx(1)
    assert "parameters" in figures
    with pytest.raises(CaseError, match=r"^one\.yaml:2: spacing: "):
        preview(load_case("one.yaml", text=CASE.replace("0.4", "-x")), "one.yaml")
