"""Cases from strangers: what they may read, where they may write, and how much they may take."""

import os
import re
from itertools import product
from pathlib import Path

import meshio
import numpy as np
import pytest
from batches import rows_of
from commands import command, contents
from paths import ROOT
from sweeps import sweep

import bubblemesh
from bubblemesh import readers
from bubblemesh.case.models import UNTRUSTED
from bubblemesh.errors import CaseError, FileError
from bubblemesh.meshfiles.sources.table import SELF_CONTAINED
from bubblemesh.problem.prepare import prepare

SQUARE = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.4\n"
RING = "0,0\n1,0\n1,1\n0,1\n"
SECRET = "password_of_the_house"
KEYS = {
    "domain: {file: FILE}\nspacing: 0.4\n": "ring.csv",
    "domain: {outer: {file: FILE}}\nspacing: 0.4\n": "ring.csv",
    "domain: {outer: {rectangle: [0, 0, 9, 9]}, regions: [{name: a, ring: {file: FILE}}]}\nspacing: 2\n": "ring.csv",
    "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: {field: {file: FILE}}\n": "field.vtu",
    "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: {scattered: {file: FILE}}\n": "points.csv",
    "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: {raster: {file: FILE, bounds: [0, 0, 1, 1]}}\n": "array.npy",
    "domain: {outer: {rectangle: [0, 0, 1, 1]}}\n"
    "spacing: {image: {file: FILE, bounds: [0, 0, 1, 1], finest: 0.2, coarsest: 0.4}}\n": "grey.png",
}
OUTSIDE = ["../mine/NAME", "ABSOLUTE/NAME", "~/NAME", "link-NAME", "folder/NAME", "folder/../mine/NAME"]


@pytest.fixture
def stranger(tmp_path, monkeypatch):
    """The folder of a stranger's case, with good files, links out of it, and a folder of the user's beside it."""
    pillow = pytest.importorskip("PIL.Image")
    theirs, mine = tmp_path / "theirs", tmp_path / "mine"
    for folder in (theirs, theirs / "data", mine):
        folder.mkdir()
    for folder in (theirs / "data", mine):
        (folder / "ring.csv").write_text(RING)
        (folder / "points.csv").write_text("x,y,d\n0,0,0.4\n1,0,0.4\n0,1,0.3\n")
        np.save(folder / "array.npy", np.full((3, 3), 0.4))
        pillow.new("L", (4, 4), 128).save(folder / "grey.png")
        square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
        cells = [("triangle", np.array([[0, 1, 2], [0, 2, 3]]))]
        for name in ("field.vtu", "field.xdmf"):
            meshio.Mesh(square, cells, point_data={"d": np.full(4, 0.4)}).write(folder / name)
    (mine / "base.yaml").write_text(f"spacing: {SECRET}\n")
    for path in mine.iterdir():
        (theirs / f"link-{path.name}").symlink_to(path)
    (theirs / "folder").symlink_to(mine)
    monkeypatch.chdir(tmp_path)
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(mine))
    return theirs


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder that is the present one."""
    monkeypatch.chdir(tmp_path)


def named(text, name, outside="data/NAME"):
    return text.replace("FILE", outside.replace("NAME", name).replace("ABSOLUTE", f"{Path.cwd()}/mine"))


@pytest.mark.parametrize(("text", "name"), KEYS.items(), ids=lambda value: value[-12:-1])
def test_files_below_the_folder_of_the_case_are_read(text, name, stranger):
    (stranger / "case.yaml").write_text(named(text, name))
    assert command("check", "--untrusted", "theirs/case.yaml")[0] == 0


# The quick rows have each key and each place.
@pytest.mark.parametrize(("text", "outside"), sweep(product(KEYS, OUTSIDE), quick=8))
def test_files_elsewhere_are_not_read_however_they_are_named(text, outside, stranger):
    name = KEYS[text]
    (stranger / "case.yaml").write_text(named(text, name, outside))
    code, _, message = command("check", "--untrusted", "theirs/case.yaml")
    assert (code, "an untrusted case reads only from below its folder" in message) == (2, True), message
    assert re.search(rf"{name}: leads out of ", message), message
    assert message.count(name) == 1  # told once
    assert command("check", "theirs/case.yaml")[0] == 0  # one that is trusted


@pytest.mark.parametrize("outside", OUTSIDE)
def test_no_command_reads_files_elsewhere(outside, stranger):
    (stranger / "case.yaml").write_text(named("domain: {file: FILE}\nspacing: 0.4\n", "ring.csv", outside))
    before = contents(Path.cwd())
    refusal = "an untrusted case reads only from below its folder"
    code, _, message = command("run", "theirs/case.yaml", "--untrusted", "-o", "out")
    assert (code, refusal in message) == (2, True)
    solution = "theirs/data/field.vtu"
    code, _, message = command("adapt", "theirs/case.yaml", "--untrusted", "--solution", solution, "-o", "out")
    assert (code, refusal in message) == (2, True)
    with pytest.raises(CaseError, match=refusal):
        bubblemesh.mesh_case(bubblemesh.load_case("theirs/case.yaml", untrusted=True))
    assert contents(Path.cwd()) == before
    (row,) = rows_of("theirs/case.yaml", folder="out", untrusted=True)
    assert (row.exit_code, refusal in row.error) == (2, True)


@pytest.mark.usefixtures("workers_in_threads")
@pytest.mark.parametrize("outside", OUTSIDE)
def test_a_base_elsewhere_is_not_read(outside, stranger):
    (stranger / "case.yaml").write_text(named("name: a\nbase: FILE\n", "base.yaml", outside))
    for arguments in (["check"], ["run", "-o", "out"], ["batch", "-o", "out"]):
        code, _, message = command(*arguments, "--untrusted", "theirs/case.yaml")
        assert code == 2
        assert re.search(r"theirs/case\.yaml:2: base: \S*base\.yaml: leads out of ", message), message
        assert "an untrusted case reads only from below its folder" in message
        assert SECRET not in message
    assert SECRET in command("check", "theirs/case.yaml")[2]  # what the refusal is good for


def test_a_base_below_the_folder_is_read_and_its_files_too(stranger):
    (stranger / "data/base.yaml").write_text("domain: {file: ring.csv}\nspacing: 0.4\n")
    (stranger / "case.yaml").write_text("base: data/base.yaml\n")
    assert command("check", "--untrusted", "theirs/case.yaml")[0] == 0


@pytest.mark.usefixtures("workers_in_threads")
def test_a_case_file_that_is_a_link_to_elsewhere_is_not_read(stranger):
    (stranger / "case.yaml").symlink_to("../mine/base.yaml")
    for arguments in (["check", "theirs/case.yaml"], ["batch", "theirs", "-o", "out"]):
        code, _, message = command(*arguments, "--untrusted")
        assert code == 2
        assert SECRET not in message


def test_a_case_of_the_standard_input_reads_from_below_the_present_folder(stranger):
    case = named("domain: {file: FILE}\nspacing: 0.4\n", "ring.csv")
    assert command("check", "--untrusted", "-", stdin=case.replace("data/", "theirs/data/"))[0] == 0
    assert command("check", "--untrusted", "-", stdin=case.replace("data/", "../"))[0] == 2


@pytest.mark.skipif(os.open not in os.supports_dir_fd, reason="this system cannot open a file in an open folder")
@pytest.mark.parametrize("name", ["folder/ring.csv", "link-ring.csv"])
def test_links_are_refused_when_a_file_is_opened_not_only_before(name, stranger, monkeypatch):
    (stranger / "case.yaml").write_text(f"domain: {{file: {name}}}\nspacing: 0.4\n")
    case = bubblemesh.load_case("theirs/case.yaml", untrusted=True)
    monkeypatch.setattr(os.path, "realpath", lambda path: str(Path(path).absolute()))  # as before they were links
    with pytest.raises(FileError):
        prepare(case)


def test_libraries_are_given_copies_of_the_files_that_were_checked(stranger, monkeypatch):
    (stranger / "case.yaml").write_text("domain: {file: data/ring.csv}\nspacing: 0.4\n")
    read, seen = readers.read_areas, []

    def late(path, *more):
        (stranger / "data/ring.csv").unlink()
        (stranger / "data/ring.csv").symlink_to("../../mine/points.csv")
        seen.append(path)
        return read(path, *more)

    monkeypatch.setattr(readers, "read_areas", late)
    problem = prepare(bubblemesh.load_case("theirs/case.yaml", untrusted=True))
    assert seen
    assert problem.domain.polygon.area == 1


@pytest.mark.parametrize("name", ["field.xdmf", "field.inp", "field.med", "field.h5m"])
def test_a_mesh_that_may_name_other_files_is_not_read(name, stranger):
    (stranger / "data" / name).touch()
    (stranger / "case.yaml").write_text(named(list(KEYS)[3], name))
    code, _, message = command("check", "--untrusted", "theirs/case.yaml")
    assert code == 2
    assert "may name other files: an untrusted case gives data as .msh, .pos, .vtk, .vtu" in message


def test_the_page_on_security_lists_the_meshes_that_are_read():
    (row,) = [line for line in (ROOT / "docs/security.md").read_text().splitlines() if "| Data on a mesh" in line]
    assert tuple(re.findall(r"`(\.\w+)`", row)) == SELF_CONTAINED


@pytest.mark.parametrize("directory", ["../mine", "ABSOLUTE", "folder", "folder/new", "data/../.."])
def test_results_do_not_go_elsewhere_unless_the_command_says_so(directory, stranger):
    directory = directory.replace("ABSOLUTE", f"{Path.cwd()}/mine")
    (stranger / "case.yaml").write_text(SQUARE + f"output: {{directory: {directory}, formats: [msh]}}\n")
    before = contents(Path.cwd())
    code, _, message = command("run", "--untrusted", "theirs/case.yaml")
    assert (code, "output.directory: " in message) == (2, True)
    assert contents(Path.cwd()) == before
    (row,) = rows_of("theirs/case.yaml", untrusted=True)
    assert row.exit_code == 2
    assert command("run", "--untrusted", "theirs/case.yaml", "-q", "-o", "mine/out")[0] == 0
    assert Path("mine/out/case.msh").exists()


def test_results_go_below_the_folder_of_the_case(stranger):
    (stranger / "case.yaml").write_text(SQUARE + "output: {directory: new/results, formats: [msh]}\n")
    assert command("run", "--untrusted", "theirs/case.yaml", "-q")[0] == 0
    assert (stranger / "new/results/case.msh").exists()


def limits_of(text="", **options):
    Path("case.yaml").write_text(SQUARE + text)
    return bubblemesh.load_case("case.yaml", untrusted=True, **options).limits.model_dump()


def test_limits_are_on_by_default_and_may_be_lowered(here):
    assert limits_of() == UNTRUSTED
    assert limits_of("limits: {seconds: null}\n") == UNTRUSTED
    assert limits_of("limits: {seconds: 5, max_nodes: 100}\n") == {**UNTRUSTED, "seconds": 5, "max_nodes": 100}


@pytest.mark.parametrize(("key", "most"), UNTRUSTED.items())
def test_a_limit_is_raised_by_the_user_only(key, most, here):
    with pytest.raises(CaseError, match=f"case.yaml:3: limits.{key}: an untrusted case may ask for {most}"):
        limits_of(f"limits: {{{key}: {10 * most}}}\n")
    assert limits_of(overrides=[f"limits.{key}={10 * most}"]) == {**UNTRUSTED, key: 10 * most}
    assert limits_of(f"limits: {{{key}: 1}}\n", overrides=[f"limits.{key}={10 * most}"])[key] == 10 * most
    Path("case.yaml").write_text(f"{SQUARE}sweep: {{limits.{key}: [{10 * most}]}}\n")
    (row,) = rows_of("case.yaml", folder="out", untrusted=True)
    assert (row.exit_code, "an untrusted case may ask for" in row.error) == (2, True)
    assert limits_of(time_limit=1000)["seconds"] == 1000


def test_a_trusted_case_has_the_limits_that_it_gives(here):
    Path("case.yaml").write_text(SQUARE + "limits: {seconds: 1e6, max_nodes: 1e7}\n")
    assert bubblemesh.load_case("case.yaml").limits.max_nodes == 10_000_000
    assert bubblemesh.load_case("case.yaml").root is None


def test_a_batch_meshes_untrusted_cases_with_their_files(stranger):
    (stranger / "case.yaml").write_text(named("domain: {file: FILE}\nspacing: 0.4\n", "ring.csv"))
    (row,) = rows_of("theirs/case.yaml", folder="out", untrusted=True)
    assert row.exit_code == 0, row.error
    assert command("run", "--untrusted", "theirs/case.yaml", "-q", "-o", "single")[0] == 0
    assert Path("out/case.msh").read_bytes() == Path("single/case.msh").read_bytes()
