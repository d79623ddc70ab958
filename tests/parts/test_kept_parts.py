"""Parts that are kept and stay in slices: the same mesh and figures as at once, files, faults, and going on."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from functools import cache, partial
from io import BytesIO
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest
from commands import command, contents
from part_cases import AREAS, CHECKS, DISC, PERIODIC, REGIONS, case
from sweeps import sweep
from typer.testing import CliRunner

from bubblemesh.cli import app
from bubblemesh.errors import BubblemeshError, FileError
from bubblemesh.files import locked
from bubblemesh.meshes.conformity import require_piece
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import Measures
from bubblemesh.meshes.triangulation import triangulated
from bubblemesh.parts.store import IN_MEMORY, InFolder, InMemory, Keeping
from bubblemesh.parts.work import alone
from bubblemesh.problem.prepare import prepare
from bubblemesh.run import destination
from bubblemesh.run.packing import RunOptions, pack
from bubblemesh.run.part_store import _store
from bubblemesh.run.pipeline import SlicedResult, mesh_case, run_case

LINES = """
domain:
  outer: {rectangle: [0, 0, 2, 1]}
  lines:
    - {path: [[0.1, 0.2], [1.9, 0.8]]}
    - {path: [[0.1, 0.8], [1.2, 0.4], [1.9, 0.2]]}
spacing: 0.022
"""
FINE = {
    "disc": DISC.replace("0.04 + 0.05", "0.018 + 0.022"),
    "regions": f"{REGIONS.partition('spacing:')[0]}spacing: 0.06\n",
    "lines": LINES,
    "periodic": PERIODIC.replace("0.04 + 0.02", "0.02 + 0.011"),
}
COARSE = DISC.replace("0.04 + 0.05", "0.1 + 0.1")
EXACT = "nodes", "triangles", "boundary_nodes", "bounds", "area", "area_error", "force_evaluations"
BINS = 2e-3  # of quantiles from histograms of a few thousand numbers
FIRST = "1.0-HexagonalLattice"  # packing of a case
PLATE = """
domain: {outer: {rectangle: [0, 0, 2, 1]}}
spacing: 0.14
packing: {effort: fast}
output: {formats: [xdmf]}
"""


def sliced(given, store):
    result = run_case(given, RunOptions(keeping=Keeping(lambda name: store, True)))
    assert isinstance(result, SlicedResult)
    return result


class InMemoryToo(InFolder):
    """A store in a folder that keeps the parts as they are given, too."""

    def __init__(self, folder):
        super().__init__(folder)
        self.folder, self.memory = folder, InMemory()

    def keep(self, number, part):
        super().keep(number, part)
        self.memory.keep(number, part)


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """By name, a fine case of three parts, its result in slices, and the store that keeps them: made once."""

    @cache
    def made(name):
        given, store = case(FINE[name], 3), InMemoryToo(tmp_path_factory.mktemp(name))
        return given, sliced(given, store), store

    return made


def gathered(mesh):
    """Points, triangles, regions and fields of a mesh in slices."""
    parts = list(mesh.slices())
    points = np.concatenate([mesh.frame.points, *(part.points for part in parts)])
    fields = {name: np.concatenate([part.fields[name] for part in parts]) for name in mesh.fields}
    triangles, regions = (np.concatenate([getattr(part, name) for part in parts]) for name in ("triangles", "regions"))
    return points, triangles, regions, fields


def by_place(points, triangles, *columns):
    """Centroids of triangles in order of place, with their data."""
    centers = points[triangles].mean(axis=1)
    order = np.lexsort(centers.round(9).T)
    return [column[order] for column in (centers, *columns)]


@pytest.mark.parametrize("name", sweep(["regions", "disc", "periodic", "lines"], quick=2))
def test_a_mesh_in_slices_is_the_one_that_is_made_at_once(name, packed):
    given, result, _ = packed(name)
    whole = mesh_case(given)
    mesh, one = result.mesh, whole.mesh
    assert (mesh.sizes[:, 0] > 100).all()
    points, triangles, regions, fields = gathered(mesh)
    assert (mesh.nodes, mesh.triangles) == (len(points), len(triangles)) == (len(one.points), len(one.triangles))
    assert (mesh.frame.labels, mesh.frame.regions) == (one.labels, one.regions)
    np.testing.assert_array_equal(mesh.frame.points[mesh.frame.facets], one.points[one.facets])
    np.testing.assert_array_equal(mesh.frame.periodic, one.periodic)
    np.testing.assert_array_equal(mesh.outer, one.outer)
    assert mesh.frame.points[mesh.frame.labelled_nodes].tolist() == one.points[one.labelled_nodes].tolist()
    mine = by_place(points, triangles, regions, *fields.values())
    for some, other in zip(
        mine, by_place(one.points, one.triangles, one.triangle_regions, *whole.fields.values()), strict=True
    ):
        np.testing.assert_allclose(some, other, rtol=0, atol=1e-12)
    same = Mesh(points, triangles, one.facets, one.facet_labels, one.labels, one.regions, regions)
    for check in CHECKS[not one.outer.all() :]:  # corners of inner lines come before other boundary nodes
        check(same)
    told, known = result.report.data, whole.report.data
    assert told["parts"] == known["parts"]
    for key in EXACT:
        assert told[key] == pytest.approx(known[key], rel=1e-12, abs=1e-14)
    assert told["labels"] == known["labels"]
    for here, there in zip(told["regions"], known["regions"], strict=True):
        assert here == there | {"area": pytest.approx(there["area"], rel=1e-12)}
    for key in ("quality", "spacing"):
        for figure, value in known[key].items():
            if figure == "worst":
                assert [row["quality"] for row in told[key][figure]] == [row["quality"] for row in value]
            else:
                rough = BINS if figure in ("p01", "p99") else 1e-12
                assert told[key][figure] == pytest.approx(value, rel=rough)


APART = [(left, spacing) for left in (1.5, 4.0, 7.3) for spacing in (0.047, 0.05, 0.06)]


@pytest.mark.parametrize(("left", "spacing"), sweep([*APART[4:], *APART[:4]], quick=2))
def test_areas_that_lie_apart_may_be_parts(left, spacing, tmp_path):
    text = AREAS.replace("1.5, 0, 2.5", f"{left}, 0, {left + 1}").replace("0.05", f"{spacing}")
    given = case(text, 2)
    whole, result = mesh_case(given), sliced(given, InFolder(tmp_path))
    points, triangles, _, _ = gathered(result.mesh)
    one = whole.mesh
    np.testing.assert_allclose(
        *(by_place(*mesh)[0] for mesh in ((points, triangles), (one.points, one.triangles))), rtol=0, atol=1e-12
    )
    assert result.report["quality"]["mean"] == pytest.approx(whole.report["quality"]["mean"], rel=1e-12)


def test_a_kept_part_is_the_one_that_was_given(packed):
    _, _, files = packed("regions")
    for number in range(3):
        for kept, given in ((files.core, files.memory.core), (files.margin, files.memory.margin)):
            assert_same(kept(number), given(number))
    assert files.margin(3) is files.memory.margin(3) is None
    assert sorted(path.name for path in files.folder.iterdir()) == [f"part-{k}.npz" for k in range(3)]


@pytest.fixture
def files(packed, tmp_path):
    """A store of its own with the parts of a case."""
    _, _, store = packed("regions")
    copytree(store.folder, tmp_path, dirs_exist_ok=True)
    return InFolder(tmp_path)


def test_a_part_with_another_number_is_none(files, tmp_path):
    (tmp_path / "part-0.npz").rename(tmp_path / "part-1.npz")
    assert files.margin(1) is None
    with pytest.raises(FileError, match=r"part-1\.npz: this is no part of a mesh: remove it \(it is another one\)"):
        files.core(1)


@pytest.mark.parametrize("place", [b"", b"core.target.npy", b"core.triangles.npy", b"core.quality.npy"])
def test_a_part_that_lacks_a_digit_is_none(place, files, tmp_path):
    """Its arrays may claim to be shorter than they are."""
    path = tmp_path / "part-0.npz"
    assert files.margin(0) is not None
    content = bytearray(path.read_bytes())
    shape = content.index(b"'shape': (", content.index(place))
    content[content.index(b",", shape) - 1] = ord(" ")  # in the place of its last digit, or of a bracket
    path.write_bytes(content)
    assert files.margin(0) is None


def test_a_kept_part_that_may_not_be_read_is_an_error(tmp_path, monkeypatch):
    store = InFolder(tmp_path)
    (tmp_path / "part-0.npz").write_bytes(b"")
    assert store.margin(0) is None
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(FileError, match="part-0"):
        store.margin(0)
    assert store.margin(1) is None


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pipes among files")
def test_a_pipe_among_kept_parts_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "part-0.npz")
    assert InFolder(tmp_path).margin(0) is None
    with pytest.raises(FileError, match=r"part-0\.npz: the part cannot be read: it is no regular file"):
        InFolder(tmp_path).core(0)


def assert_same(some, other):
    if hasattr(some, "_fields"):
        assert type(some) is type(other)
        for mine, yours in zip(some, other, strict=True):
            assert_same(mine, yours)
    else:
        np.testing.assert_array_equal(some, other)
        assert np.asarray(some).dtype == np.asarray(other).dtype


def archived(save, *columns):
    stream = BytesIO()
    save(stream, *columns)
    return stream.getvalue()


@pytest.mark.parametrize(
    "content",
    [
        *(b"", b"no archive", b"PK\x03\x04" + bytes(100)),
        *(archived(save, np.arange(3)) for save in (np.save, np.savez)),
    ],
)
def test_what_is_no_part_is_told_with_its_file(tmp_path, content):
    (tmp_path / "part-0.npz").write_bytes(content)
    assert InFolder(tmp_path).margin(0) is None
    with pytest.raises(FileError, match=r"part-0\.npz: this is no part of a mesh: remove it"):
        InFolder(tmp_path).core(0)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a case whose parts may stay in slices."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plate.yaml").write_text(PLATE)
    return tmp_path


@pytest.fixture
def here(folder, monkeypatch):
    """Such a folder, of a case whose parts are packed in this process, as no workers have to start for that."""
    pack_here(monkeypatch)
    return folder


def pack_here(monkeypatch):
    monkeypatch.setattr("bubblemesh.workers.crew.crew_of", lambda *hired: nullcontext(alone))


def noted_parts(monkeypatch, most=10):
    """Numbers of the parts that are packed and kept from here on, in this process: a list that grows up to so many."""
    numbers, keep = [], InFolder.keep

    def noted(self, number, part):
        if len(numbers) == most:
            raise FileError("no more")
        numbers.append(number)
        keep(self, number, part)

    pack_here(monkeypatch)
    monkeypatch.setattr(InFolder, "keep", noted)
    return numbers


def test_files_are_the_same_whether_a_run_was_ended_on_its_way(folder, monkeypatch):
    options = "--parts", "3", "--jobs", "1", "-q"
    with monkeypatch.context() as patch:
        pack_here(patch)
        assert command("run", "plate.yaml", "-o", "once", *options)[0] == 0
        done = noted_parts(patch, most=2)
        code, _, told = command("run", "plate.yaml", "-o", "again", "--resume", *options)
    assert code == 5
    assert told.endswith(": no more\n")
    (kept,) = (folder / "again").iterdir()
    assert {path.name for path in (kept / FIRST).iterdir()} == {f"part-{number}.npz" for number in done}
    times = {number: InFolder(kept / FIRST).margin(number).record.seconds for number in done}
    (folder / "again" / ".plate.parts-0123456789abcdef").mkdir()  # of another state of the case
    assert command("run", "plate.yaml", "-o", "again", "--resume", *options)[0] == 0
    report = json.loads((folder / "again/plate.report.json").read_text())
    # They were not packed again.
    assert {number: report["rounds"][number]["seconds"] for number in done} == times
    assert contents(folder / "again").keys() == contents(folder / "once").keys()
    for name in ("plate.h5", "plate_facets.h5", "plate.xdmf"):
        assert (folder / "again" / name).read_bytes() == (folder / "once" / name).read_bytes()


def ended_on_its_way(monkeypatch, *words):
    """Run up to where all parts are there."""
    with monkeypatch.context() as patch:
        patch.setattr("bubblemesh.parts.pipeline.join_bands", None)
        with pytest.raises(AssertionError):
            command("run", "plate.yaml", "-o", "out", "--parts", "2", "--resume", "-q", *words)


def test_a_damaged_part_is_packed_again(here, monkeypatch):
    assert command("run", "plate.yaml", "-o", "once", "--parts", "2", "-q")[0] == 0
    ended_on_its_way(monkeypatch)
    (kept,) = here.glob("out/.plate.parts-*/1.0-*/part-1.npz")
    content = bytearray(kept.read_bytes())
    content[content.index(b"core.quality.npy") + 300] ^= 1
    kept.write_bytes(content)
    packed = noted_parts(monkeypatch)
    assert command("run", "plate.yaml", "-o", "out", "--parts", "2", "--resume", "-q")[0] == 0
    assert packed == [1]
    assert (here / "out/plate.h5").read_bytes() == (here / "once/plate.h5").read_bytes()


@pytest.mark.parametrize(("first", "then", "left"), [("2", "null", [0, 1]), ("null", "2", [])])
def test_parts_without_figures_are_packed_again_for_an_output_that_needs_them(here, monkeypatch, first, then, left):
    ended_on_its_way(monkeypatch, "--set", f"output.partition={first}")
    packed = noted_parts(monkeypatch)
    words = "run", "plate.yaml", "--parts", "2", "-q", "--set", f"output.partition={then}"
    assert command(*words, "-o", "out", "--resume")[0] == 0
    assert sorted(packed) == left
    assert command(*words, "-o", "once")[0] == 0
    assert (here / "out/plate.h5").read_bytes() == (here / "once/plate.h5").read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="folders have no locks")
def test_two_runs_do_not_share_kept_parts(here, monkeypatch):
    ended_on_its_way(monkeypatch)
    (kept,) = here.glob("out/.plate.parts-*")
    words = "run", "plate.yaml", "-o", "out", "--parts", "2", "--resume", "-q"
    with locked(kept) as mine:
        assert mine
        code, _, told = command(*words)
        assert code == 2
        assert "--resume: another run is at work with the parts in" in told.replace("\n", " ")
        assert command(*words, "--seed", "5")[0] == 0  # other inputs, which leave those alone
        assert sorted(path.name for path in (kept / FIRST).iterdir()) == ["part-0.npz", "part-1.npz"]
    assert command(*words)[0] == 0
    assert not list(here.glob("out/.*"))


def test_other_inputs_find_no_parts(here, monkeypatch):
    ended_on_its_way(monkeypatch)
    (kept,) = (here / "out").iterdir()
    packed = noted_parts(monkeypatch)
    assert command("run", "plate.yaml", "-o", "out", "--parts", "2", "--resume", "-q", "--seed", "5")[0] == 0
    assert sorted(packed) == [0, 1]
    assert not kept.exists()


def test_parts_of_a_case_whose_name_begins_alike_stay(here):
    (other := here / "out/.plate.parts-b.parts-0123456789abcdef").mkdir(parents=True)
    (left := here / "out/.plate.parts-0123456789abcdef").mkdir()
    assert command("run", "plate.yaml", "-o", "out", "--parts", "2", "-q")[0] == 0
    assert other.exists()
    assert not left.exists()


def test_packings_by_rows_and_one_by_one_do_not_share_their_parts(tmp_path):
    strip = "domain: {outer: {rectangle: [0, 0, 1, 0.07]}}\nspacing: 0.01\n"
    by_rows = prepare(case(f"{strip}packing: {{effort: fast}}\n", 2))
    keeping, numbers = Keeping(partial(_store, tmp_path, True), True), []
    for problem in (by_rows, by_rows.one_by_one()):
        numbers.append([pack(problem, RunOptions(keeping=some)).nodes for some in (keeping, IN_MEMORY)])
    assert all(kept == in_memory for kept, in_memory in numbers)
    assert numbers[0] != numbers[1]


@pytest.mark.parametrize("options", [["--format", "xdmf"], ["--format", "msh"]])
def test_a_run_that_does_not_go_on_removes_what_one_has_left_that_was_ended(here, monkeypatch, options):
    ended_on_its_way(monkeypatch)
    (kept,) = (here / "out").iterdir()
    with locked(kept):  # by a run that is at work
        assert command("run", "plate.yaml", "-o", "out", "--parts", "2", "-q", *options)[0] == 0
        assert kept.exists() or sys.platform == "win32"
    assert command("run", "plate.yaml", "-o", "out", "--parts", "2", "-q", *options)[0] == 0
    assert not list(here.glob("out/.*"))


@pytest.mark.parametrize("options", [[], ["--resume"]])
def test_an_error_that_is_none_of_the_parts_is_told_as_it_is(here, monkeypatch, options):
    def late(*given):
        raise TimeoutError("too late")  # an OSError as well

    monkeypatch.setattr("bubblemesh.cli.run.mesh_and_show", late)
    result = CliRunner().invoke(app, ["run", "plate.yaml", "-o", "out", "--parts", "2", "-q", *options])
    assert "TimeoutError: too late" in result.stderr
    assert "cannot write" not in result.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--resume"], "--resume: a mesh in one piece has no parts to go on with: add --parts auto"),
        (["--resume", "--parts", "2", "-o", "-"], "--resume: there is no place for the parts with -o -"),
    ],
)
def test_where_nothing_can_be_kept_is_told(here, options, message):
    before = contents(here)
    code, _, told = command("run", "plate.yaml", *options)
    assert code == 2
    assert message in told
    assert contents(here) == before


@pytest.mark.parametrize("parts", ["2", "auto"])
def test_the_file_of_a_part_may_not_overwrite_the_case(here, parts):
    (here / "plate_1.vtu").write_text(PLATE)
    code, _, told = command("run", "plate_1.vtu", "-o", "plate.pvtu", "--parts", parts)
    assert (code, told) == (5, "error: plate_1.vtu: the results would overwrite this file: give another name by -o\n")
    code, *_ = command("run", "plate_1.vtu", "-o", "plate.pvtu", "-q")  # without parts there is one piece
    assert code == 0
    assert sorted(path.name for path in here.glob("plate*.vtu")) == ["plate_0.vtu", "plate_1.vtu"]


def test_parts_that_would_be_too_many_files_are_refused_before_the_work(here):
    code, _, told = command("run", "-", "-o", "out", "--parts", "10001", "--format", "pvtu", stdin=PLATE)
    assert (code, told) == (2, "error: .pvtu has a file for each part, 10,000 at most: ask for fewer parts\n")


@pytest.mark.parametrize("options", [[], ["--resume"]])
def test_a_failed_run_leaves_nothing(folder, options):
    resource = pytest.importorskip("resource", reason="Windows has no limit on the size of files")
    before, limits = contents(folder), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8000, limits[1]))  # of workers, which write the parts, too
    try:
        code, _, told = command("run", "plate.yaml", "-o", "new/out", "--parts", "2", *options, "-q")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert code == 5
    assert "File too large" in told
    left = contents(folder)
    assert left.keys() - before.keys() <= {"new", "new/out"} | {name for name in left if ".parts-" in name}
    assert not any(name.endswith(".npz") for name in left)


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_run_that_is_killed_goes_on_with_the_parts_that_are_done(here, number):
    (here / "plate.yaml").write_text(PLATE.replace("0.14", "0.02"))
    assert command("run", "plate.yaml", "-o", "once", "--parts", "6", "--jobs", "1", "-q")[0] == 0
    words = ["run", "plate.yaml", "-o", "out", "--parts", "6", "--jobs", "2", "--resume", "-q"]
    process = subprocess.Popen([sys.executable, "-m", "bubblemesh", *words], cwd=here, stderr=subprocess.PIPE)
    end = time.monotonic() + 60
    while len(list(here.glob("out/.plate.parts-*/*/part-*.npz"))) < 2:
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.005)
    process.send_signal(number)
    process.communicate(timeout=60)
    assert process.returncode == (130 if number == signal.SIGINT else -number)
    assert not list(here.glob("out/plate*"))
    kept = len(list(here.glob("out/.plate.parts-*/*/part-*.npz")))
    assert kept >= 2
    assert subprocess.run([sys.executable, "-m", "bubblemesh", *words], cwd=here, check=False).returncode == 0
    assert (here / "out/plate.h5").read_bytes() == (here / "once/plate.h5").read_bytes()
    assert not list(here.glob("out/.*"))


def test_a_page_of_slices_shows_the_spacing_and_a_sample(here, monkeypatch):
    monkeypatch.setattr(destination, "SAMPLE", 100)
    assert command("run", "plate.yaml", "-o", "out", "--parts", "2", "--report", "-q")[0] == 0
    page = Path("out/plate.html").read_text()
    assert "100 around the worst one" in page
    assert 'alt="The spacing of the whole mesh"' in page


@pytest.mark.parametrize("name", sweep(["regions", "disc", "periodic", "lines"], quick=2))
def test_a_sample_is_a_mesh_around_the_worst_triangle(name, packed):
    _, result, _ = packed(name)
    mesh, fields = result.mesh.sample(700, "quality")
    assert len(mesh.triangles) == 700
    assert fields["quality"].min() == result.report["quality"]["min"]
    np.testing.assert_array_equal(fields["quality"], Measures(mesh.points, mesh.triangles).radius_ratios)
    assert set(np.unique(mesh.triangle_regions)) == set(range(len(mesh.regions)))
    edges = {frozenset(pair) for pair in mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()}
    assert {frozenset(pair) for pair in mesh.facets.tolist()} <= edges


def test_formats_that_need_all_of_a_large_mesh_are_told(here, monkeypatch):
    monkeypatch.setattr(destination, "LARGE", 100)
    code, _, told = command("run", "plate.yaml", "-o", "out", "--parts", "2", "--format", "su2", "--format", "xdmf")
    assert code == 0
    assert "su2: written from the whole mesh in memory: xdmf" in told.replace("\n", " ")


def test_formats_with_pieces_that_have_one_only_are_told(here):
    words = "run", "plate.yaml", "-o", "out", "--parts", "2", "--format", "pvtu"
    code, _, told = command(*words, "--format", "su2")
    assert code == 0
    assert "pvtu: in one piece, since the whole mesh is needed for su2" in told.replace("\n", " ")
    for others in (["--partition", "2", "--format", "su2"], []):
        assert "in one piece" not in command(*words, *others)[2]
    told = command(*words, "--set", "layers=[{on: outer, first: 0.004, count: 3}]")[2].replace("\n", " ")
    assert "pvtu: in one piece, since the whole mesh is needed for layers: leave that" in told


@pytest.mark.parametrize("extra", ["angle_min: 28", "output: {order: 2}", "output: {partition: 3}"])
def test_what_needs_all_triangles_is_made_at_once(extra):
    result = run_case(case(f"{COARSE}\n{extra}", 2), RunOptions(keeping=IN_MEMORY._replace(in_slices=True)))
    assert isinstance(result.mesh, Mesh)


def test_pieces_that_do_not_meet_are_noticed():
    random = np.random.default_rng(3)
    turn = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    points = np.vstack([np.column_stack([np.cos(turn), np.sin(turn)]), random.uniform(-0.5, 0.5, (30, 2))])
    ring = np.column_stack([np.arange(20), (np.arange(20) + 1) % 20])
    triangles = triangulated(points, ring)
    everything, none = np.ones(50, bool), np.zeros((0, 2), int)
    require_piece(Measures(points, triangles), ring, none, everything)
    require_piece(Measures(points, triangles), ring[:12], ring[12:, ::-1], everything)
    for faulty, facets, rim, words in (
        (triangles, ring[:-1], none, "pieces do not meet"),
        (triangles[1:], ring, none, "pieces do not meet"),
        (triangles, ring, np.array([[20, 21]]), "pieces do not meet"),
        (triangles[:, ::-1], ring, none, "flat or inverted"),
        (triangles[~(triangles == 25).any(axis=1)], ring, none, "a node belongs to no triangle"),
    ):
        with pytest.raises(BubblemeshError, match=words):
            require_piece(Measures(points, faulty), facets, rim, everything)


def test_parts_of_a_name_with_brackets_are_removed_in_the_end(here):
    options = "--parts", "2", "--jobs", "1", "-q", "--resume", "--format", "xdmf"
    assert command("run", "plate.yaml", "--set", "name=a[1]", "-o", "out", *options)[0] == 0
    assert not [path for path in (here / "out").iterdir() if path.is_dir()]
