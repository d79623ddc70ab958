"""Who imports whom: data flows one way, and each library has one place."""

import json
import re
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter

import pytest
from paths import ROOT
from sources import MODULES, PACKAGE, found_in
from sweeps import sweep

FOUNDATION = {"arrays", "errors", "files", "messages", "process", "records"}
MAY_IMPORT = {
    "arrays": set(),
    "errors": set(),
    "files": {"errors", "messages"},
    "messages": {"arrays"},
    "process": {"errors"},
    "records": set(),
    "kernels": {"arrays", "errors"},
    "meshes": FOUNDATION | {"kernels"},
    "geometry": FOUNDATION | {"kernels"},
    "readers": FOUNDATION | {"geometry"},
    "spacing": FOUNDATION | {"geometry", "kernels", "meshes"},
    "packing": FOUNDATION | {"geometry", "kernels", "meshes", "spacing"},
    "layers": FOUNDATION | {"geometry", "meshes", "packing", "spacing"},
    "parts": FOUNDATION | {"geometry", "kernels", "meshes", "packing", "spacing"},
    "meshfiles": FOUNDATION | {"geometry", "meshes", "readers"},
    "pictures": FOUNDATION | {"meshes", "meshfiles"},
    "pages": FOUNDATION | {"meshes", "meshfiles", "pictures"},
    "case": FOUNDATION | {"meshfiles", "packing", "readers", "spacing"},
    "problem": FOUNDATION
    | {"case", "geometry", "kernels", "layers", "meshes", "meshfiles", "packing", "readers", "spacing"},
    "run": FOUNDATION
    | {
        *{"__version__", "case", "geometry", "kernels", "layers", "meshes", "meshfiles", "packing", "pages", "parts"},
        *{"pictures", "problem", "spacing"},
    },
    "adaptivity": FOUNDATION
    | {"case", "geometry", "kernels", "meshes", "meshfiles", "packing", "problem", "run", "spacing"},
    "workers": FOUNDATION | {"__version__", "parts"},
    "batch": FOUNDATION
    | {
        *{"__version__", "case", "geometry", "meshes", "meshfiles", "pages", "parts", "pictures", "problem", "readers"},
        *{"run", "workers"},
    },
    "api": FOUNDATION
    | {
        "adaptivity",
        "case",
        "geometry",
        "meshes",
        "packing",
        "parts",
        "pictures",
        "problem",
        "run",
        "spacing",
    },
    "console": FOUNDATION | {"batch", "meshes", "problem", "run"},
    "cli": FOUNDATION
    | {
        *{"__version__", "adaptivity", "batch", "case", "console", "kernels", "meshes", "meshfiles", "packing"},
        *{"parts", "pictures", "problem", "run", "spacing", "workers"},
    },
    "__init__": {"api"},
    "__main__": {"cli", "errors", "process"},
}
# What each inner room imports of the room that it is in: modules and other inner rooms. The rest of that room may
# import the inner one.
INNER = {
    "geometry/arrangement": {"boundary", "curves", "nesting", "paths", "polygonal_copy", "similarity", "validity"},
    "geometry/distance": {"boundary", "curves"},
    "meshfiles/sources": {"containment", "groups"},
    "meshfiles/write": {"formats", "groups", "text"},
    "packing/ellipses": {
        *{"annealing", "bubbles", "confinement", "mending", "method", "motion", "neighbours", "net", "newton"},
        *{
            "placement",
            "population",
            "progress",
            "relaxation",
            "setting",
            "smoothing",
            "splicing",
            "termination",
            "viscosity",
        },
    },
    "packing/placement": {"boundary_edges", "bubbles"},
    "problem/python": {"layers", "problem", "spacing"},
    "problem/shoreline": set(),
    "readers/grids": {"selection", "tables"},
    "readers/rings": {"features", "slips"},
    "readers/svg": {"features", "sampling"},
    "spacing/grid": {"spacing"},
    "spacing/metric": {"spacing", "terms"},
    "spacing/rules": {"bounds", "grid", "spacing"},
    "spacing/terms": {"bounds", "grid", "spacing"},
}
# A module may import another one that is made of it, in a function: rings are outlined by the boundary that they make.
LATER = {"bubblemesh.geometry.paths": {"bubblemesh.geometry.polygonal_copy"}}
DOORS = {"meshes/mesh.py": {"meshfiles", "pictures"}}  # a mesh writes and draws itself, when it is asked to
LIBRARIES = {
    "yaml": {"case"},
    "pydantic": {"case", "packing"},
    "meshio": {"meshfiles"},
    "h5py": {"meshfiles", "readers"},
    "matplotlib": {"pictures"},
    "rich": {"console"},
    "typer": {"cli"},
    "pythoncdt": {"meshes"},
    "pymetis": {"meshes"},
    "pyproj": {"geometry"},
    "rasterio": {"readers"},
    "PIL": {"pictures", "readers"},
    "ezdxf": {"readers"},
    "pyogrio": {"readers"},
    "svgelements": {"readers"},
    "distributed": {"workers"},
    "filelock": {"batch"},
}
MOST_LOOSE_MODULES = 7


def room(path):
    """Part of the package that a module belongs to."""
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def test_imports_go_downwards_in_the_table_of_the_page():
    table = (ROOT / "docs/layout.md").read_text().split("| room | holds |")[1].split("\n\n")[0]
    rooms = [line.split("`")[1] for line in table.splitlines() if line.startswith("| `")]
    folders = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert set(rooms) == folders
    for above, below in MAY_IMPORT.items():
        for other in below & folders if above in folders else ():
            assert rooms.index(other) > rooms.index(above), f"{above} imports {other}"


def test_a_module_imports_only_what_lies_below_it():
    for path in MODULES:
        names = found_in(path).imports
        mine = room(path)
        rooms = {name.split(".")[1] for name in names if name.startswith("bubblemesh.")}
        allowed = MAY_IMPORT[mine] | {mine} | DOORS.get(path.relative_to(PACKAGE).as_posix(), set())
        assert rooms <= allowed, path
        elsewhere = {library for library, homes in LIBRARIES.items() if mine not in homes}
        assert not elsewhere & {name.split(".")[0] for name in names}, path


@cache
def modules_below():
    """For each module by its dotted name, those that it imports, but for types alone."""
    names = {".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in MODULES}
    below = {}
    for name, path in names.items():
        # Lines are enough, as modules are imported by whole names; what is for types alone is in a block of its own.
        text = re.sub(r"^if TYPE_CHECKING.*?^(?=\S)", "", path.read_text(), flags=re.DOTALL | re.MULTILINE)
        lines = re.findall(r"^ *from (bubblemesh[\w.]*) import ([\w, ]+|\([^)]*\))", text, flags=re.MULTILINE)
        found = {
            module if module in names else f"{module}.{one}"
            for module, of_it in lines
            for one in re.findall(r"\w+", of_it)
        }
        doors = DOORS.get(path.relative_to(PACKAGE).as_posix(), set())
        below[name] = {one for one in found - LATER.get(name, set()) if one.split(".")[1] not in doors}
    return below


def test_no_modules_import_each_other():
    list(TopologicalSorter(modules_below()).static_order())


def in_room(name):
    """Module of a room, or one of its inner rooms, that a dotted name belongs to."""
    return "/".join(name.split(".")[1:3])


def test_inner_rooms_and_what_is_around_them_do_not_import_each_other():
    assert {path.parent.relative_to(PACKAGE).as_posix() for path in PACKAGE.glob("*/*/__init__.py")} == INNER.keys()
    below = {}
    for name, others in modules_below().items():
        beside = {in_room(other) for other in others if other.split(".")[1] == name.split(".")[1]}
        below.setdefault(in_room(name), set()).update(beside - {in_room(name)})
    for inner, modules in INNER.items():
        assert below[inner] == {f"{inner.split('/')[0]}/{module}" for module in modules}, inner
    list(TopologicalSorter(below).static_order())


def test_only_the_console_and_the_command_line_write_to_the_terminal():
    for path in MODULES:
        assert not found_in(path).calls & {"print", "eval", "exec", "input"}, path


def test_the_root_holds_the_doors_and_few_modules():
    rooms = {room(path) for path in MODULES}
    assert rooms == set(MAY_IMPORT)
    loose = {path.name for path in PACKAGE.glob("*.py")} - {"__init__.py", "__main__.py"}
    assert len(loose) <= MOST_LOOSE_MODULES


def test_no_two_classes_have_the_same_name():
    """A reader who meets a name, and an editor that is asked for it, finds one class."""
    homes = {}
    for path in MODULES:
        for name in found_in(path).classes:
            homes.setdefault(name, []).append(path.relative_to(PACKAGE).as_posix())
    assert {name: places for name, places in homes.items() if len(places) > 1} == {}


def test_two_constants_of_one_name_in_one_room_have_one_value():
    """A reader who knows one of them would take the other for it."""
    homes = {}
    for path in MODULES:
        for name, number in found_in(path).numbers.items():
            homes.setdefault((path.parent.relative_to(PACKAGE).as_posix(), name), {})[path.name] = number
    assert {key: values for key, values in homes.items() if len({*values.values()}) > 1} == {}


def test_no_test_imports_another_one():
    """What several of them need has a module of its own beside them; scripts within texts count, too."""
    for path in (ROOT / "tests").rglob("*.py"):
        assert not re.findall(r"^ *(?:from|import) test_\w+", path.read_text(), flags=re.MULTILINE), path


STRAIGHT = "{rectangle: [0, 0, 1, 1]}"
SPLINE = "{path: [[0, 0], [1, 0], {spline: {through: [[1, 1], [0.5, 0.8], [0, 0]]}}]}"


@pytest.mark.parametrize("outer", sweep([SPLINE, STRAIGHT], quick=1), ids=["spline", "straight"])
def test_a_plain_case_does_not_wait_for_libraries_that_it_does_not_need(tmp_path, outer):
    code = (
        "import sys\n"
        "from bubblemesh.cli import app\n"
        "app(['run', sys.argv[1], '-q', '-o', 'out'], standalone_mode=False)\n"
        "print(*sorted(sys.modules))\n"
    )
    case = tmp_path / "case.yaml"
    case.write_text(f"domain: {{outer: {outer}}}\nspacing: {{value: 0.2, growth: 0.2}}\n")
    run = subprocess.run(
        [sys.executable, "-c", code, str(case)], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    loaded = set(run.stdout.split())
    assert "meshio" in loaded
    assert not loaded & {"scipy", "matplotlib", "PIL", "distributed", "ezdxf", "pyogrio", "svgelements"}
    assert not loaded & {"numpy.ma", "bubblemesh.parts.pipeline"}


CHECKED = """
import json, os, sys
from bubblemesh.__main__ import main
sys.argv = ["bubblemesh", "check", "case.yaml", "-q"]
try:
    main()
except SystemExit as end:
    assert not end.code
told = {"modules": list(sys.modules)}
if os.path.exists("/proc/self/task"):
    told["threads"] = len(os.listdir("/proc/self/task"))
from bubblemesh.case.fields import Strict
kinds = [Strict]
for kind in kinds:
    kinds += kind.__subclasses__()
told["validators"] = [kind.__name__ for kind in kinds if kind.__pydantic_complete__]
print(json.dumps(told))
"""


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """What a process has after a check of a small case: modules, threads, and kinds of keys with validators."""
    folder = tmp_path_factory.mktemp("check")
    hole = "{circle: {center: [0.5, 0.5], radius: 0.2}}"
    (folder / "case.yaml").write_text(f"domain: {{outer: {{rectangle: [0, 0, 1, 1]}}, holes: [{hole}]}}\nspacing: 0.1")
    command = [sys.executable, "-c", CHECKED]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def test_a_check_does_not_wait_for_what_it_does_not_need(checked):
    loaded = set(checked["modules"])
    assert "numpy" in loaded
    assert not loaded & {"scipy", "numpy.ma", "numpy.polynomial", "xml.etree.ElementTree"}
    assert not loaded & {"bubblemesh.packing.methods", "bubblemesh.run.report", "bubblemesh.problem.data_terms"}


def test_the_parts_of_a_case_build_no_validators_of_their_own(checked):
    built = set(checked["validators"])
    assert "Case" in built
    assert not built & {"RingDomain", "RectangleRing", "CircleRing", "UnionRing"}


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts threads as Linux tells them")
def test_a_check_starts_no_threads(checked):
    assert checked["threads"] == 1
