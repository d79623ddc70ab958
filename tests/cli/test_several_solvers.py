"""Several solvers and formats of one run: each gets its files, or the run is refused."""

import json

import meshio
import pytest
from commands import command

from bubblemesh import load_case
from bubblemesh.errors import CaseError

CASE = "domain: {outer: {rectangle: [0, 0, 1, 1], label: wall}}\nspacing: 0.4\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "square.yaml").write_text(CASE)
    return tmp_path


def written(folder):
    return sorted(path.name for path in folder.iterdir() if path.suffix not in (".yaml", ".json"))


FENICSX = ["square.h5", "square.msh", "square.xdmf", "square_facets.h5", "square_facets.xdmf"]


@pytest.mark.parametrize(
    ("options", "files"),
    [
        (["--for", "su2", "--for", "calculix"], ["square.inp", "square.su2"]),
        (["--for", "fenicsx", "--for", "mfem"], FENICSX),
        (["--for", "mfem", "--for", "openfoam"], ["square.msh", "square.openfoam.msh"]),
        (["--for", "ngsolve", "--for", "openfoam"], ["square.msh", "square.ngsolve.msh"]),
        (["--format", "vtu", "--format", "msh", "--format", "vtu"], ["square.msh", "square.vtu"]),
        (["--set", "output.for=[freefem, fenicsx]"], sorted([*FENICSX, "square.mesh"])),
        (["--set", "output.for=[su2]"], ["square.su2"]),
        (["--set", "output.for=[su2]", "--for", "freefem"], ["square.mesh"]),
        (["--for", "mfem", "--for", "scikit-fem", "-o", "a.msh"], ["a.msh"]),
    ],
)
def test_every_solver_that_is_named_gets_its_files(options, files, folder):
    assert command("run", "square.yaml", "-q", *options) == (0, "", "")
    assert written(folder) == files


@pytest.mark.parametrize("solvers", [["mfem", "openfoam"], ["openfoam", "mfem"]])
def test_two_formats_of_one_ending_are_two_files_in_any_order(folder, solvers):
    assert command("run", "square.yaml", "-q", *(word for solver in solvers for word in ("--for", solver)))[0] == 0
    plane, prisms = (meshio.read(folder / name, "gmsh") for name in ("square.msh", "square.openfoam.msh"))
    assert {block.type for block in plane.cells} == {"line", "triangle"}
    assert "wedge" in {block.type for block in prisms.cells}
    files = json.loads((folder / "square.report.json").read_text())["files"]
    assert sorted(files) == ["square.msh", "square.openfoam.msh", "square.report.json"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--for", "su2", "--for", "ansys"], "--for: unknown solver 'ansys'; known: "),
        (["--format", "msh", "--format", "obj"], "--format: unknown format 'obj'; known: "),
        (["--for", "su2", "--format", "msh"], "--format and --for exclude each other"),
        (
            ["--for", "mfem", "--for", "su2", "-o", "a.msh"],
            "-o a.msh: is one file, in the format msh, and --for su2 asks",
        ),
        (
            ["--format", "vtu", "--format", "msh", "-o", "-"],
            "-o -: is one file, in the format vtu, and --format msh asks",
        ),
        (["--set", "output.for=[su2, ansys]"], "output.for.1: must be 'fenicsx', "),
        (["--set", "output.for=ansys"], "output.for: must be 'fenicsx', "),
        (["--set", "output.for=[]"], "output.for: must not be empty"),
        (["--for", "fenicsx", "--for", "su2", "--set", "output.order=2"], "su2 has no form for triangles of order 2"),
    ],
)
def test_what_cannot_be_done_for_all_is_refused(options, message, folder):
    code, out, said = command("run", "square.yaml", *options)
    assert (code, out, written(folder)) == (2, "", [])
    assert message in said


def test_the_case_keeps_the_solvers_as_it_names_them():
    case = load_case("a.yaml", text=CASE + "output: {for: [su2, mfem, su2]}")
    assert (case.output.solver, case.output.formats) == (("su2", "mfem", "su2"), ("msh", "su2")[::-1])
    assert load_case("a.yaml", text=CASE + "output: {for: su2}").output.solver == "su2"
    with pytest.raises(CaseError, match="formats and for exclude each other"):
        load_case("a.yaml", text=CASE + "output: {for: [su2], formats: [msh]}")


@pytest.mark.parametrize("given", ["5", "true"])
def test_formats_of_a_wrong_kind_are_told_beside_a_solver_too(given):
    with pytest.raises(CaseError, match=r"^a\.yaml:.*formats: must be a list"):
        load_case("a.yaml", text=CASE + f"output: {{for: su2, formats: {given}}}")


@pytest.mark.usefixtures("folder")
def test_a_solver_with_a_slip_is_told_what_is_meant():
    code, _, told = command("run", "square.yaml", "--for", "fenics")
    assert code == 2
    assert told.startswith("error: --for: unknown solver 'fenics'; did you mean 'fenicsx'? known: ")
