"""Who imports whom: data flows one way, and each library has one place."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "bubblemesh"
FOUNDATION = {"arrays", "errors", "labels", "wording"}
MAY_IMPORT = {
    "arrays": set(),
    "errors": set(),
    "labels": set(),
    "wording": {"arrays"},
    "histograms": FOUNDATION,
    "solvers": set(),
    "meshes": FOUNDATION,
    "readers": FOUNDATION | {"geometry", "readers"},
    "quality": FOUNDATION,
    "triangulation": FOUNDATION,
    "geometry": FOUNDATION | {"geometry"},
    "adaptivity": FOUNDATION | {"adaptivity", "geometry", "quality"},
    "spacing": FOUNDATION | {"geometry", "spacing", "triangulation"},
    "packing": FOUNDATION | {"geometry", "packing", "spacing", "triangulation"},
    "case": FOUNDATION | {"case", "geometry", "packing", "readers", "solvers", "spacing"},
    "sampled": FOUNDATION | {"case", "output", "readers", "spacing"},
    "domains": FOUNDATION | {"case", "geometry"},
    "wanted": FOUNDATION | {"case", "geometry", "sampled", "spacing"},
    "output": FOUNDATION | {"histograms", "meshes", "output", "quality", "solvers"},
    "batch": FOUNDATION
    | {"__version__", "batch", "case", "delivery", "meshes", "output", "pipeline", "problem", "readers", "resources"},
}
LIBRARIES = {
    "yaml": {"case"},
    "pydantic": {"case", "packing"},
    "meshio": {"output"},
    "h5py": {"output"},
    "matplotlib": {"output"},
    "rich": {"console"},
    "typer": {"cli"},
    "pythoncdt": {"triangulation"},
    "PIL": {"output", "readers"},
    "ezdxf": {"readers"},
    "pyogrio": {"readers"},
    "svgelements": {"readers"},
    "distributed": {"batch"},
}
MODULES = sorted(path for path in PACKAGE.rglob("*.py"))


def room(path):
    """Part of the package that a module belongs to."""
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imported(path):
    """Dotted names of all that a module imports."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            if node.module == "bubblemesh":
                yield from (f"bubblemesh.{alias.name}" for alias in node.names)
            else:
                yield node.module


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_what_lies_below_it(path):
    names = list(imported(path))
    mine = room(path)
    if mine in MAY_IMPORT:
        rooms = {name.split(".")[1] for name in names if name.startswith("bubblemesh.")}
        assert rooms <= MAY_IMPORT[mine]
    for library, homes in LIBRARIES.items():
        if mine not in homes:
            assert library not in {name.split(".")[0] for name in names}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_only_the_console_and_the_command_line_write_to_the_terminal(path):
    calls = {
        getattr(node.func, "id", "") for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)
    }
    assert not calls & {"print", "eval", "exec", "input"}


def test_every_room_of_the_package_is_known():
    rooms = {room(path) for path in MODULES}
    top = {
        "__init__",
        "__main__",
        "adaptation",
        "adapting",
        "api",
        "arguments",
        "cli",
        "clock",
        "comparison",
        "compromises",
        "conformity",
        "console",
        "delivery",
        "pipeline",
        "preview",
        "problem",
    }
    assert rooms == set(MAY_IMPORT) | top | {"resources", "streams", "summary"}


def test_a_plain_case_does_not_wait_for_libraries_that_it_does_not_need(tmp_path):
    code = (
        "import sys\n"
        "from bubblemesh.cli import app\n"
        "app(['run', sys.argv[1], '-q', '-o', 'out'], standalone_mode=False)\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules}))\n"
    )
    case = tmp_path / "case.yaml"
    case.write_text("domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: {value: 0.2, growth: 0.2}\n")
    run = subprocess.run(
        [sys.executable, "-c", code, str(case)], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    loaded = set(run.stdout.split())
    assert "meshio" in loaded
    assert not loaded & {"scipy", "matplotlib", "PIL", "distributed", "ezdxf", "pyogrio", "svgelements"}
