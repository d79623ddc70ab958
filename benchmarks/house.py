"""How walkable the code is, in numbers: ``python -m benchmarks.house``; with ``--tests`` also how long the tests take.

Modules and lines of the package, places that name one thing (an option, a data term, a format, a scheme), modules and
records of the batch, bytes of generated files under version control.
"""

import argparse
import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "bubblemesh"
GENERATED = ("sample_outputs", "docs/figures")
# For each kind of thing one example, by the words that stand for it in code.
EXAMPLES = {
    "option of the command line that sets a key (--time-limit)": {"time_limit", "--time-limit"},
    "data term of the spacing (scattered)": {"scattered", "ScatteredTerm"},
    "output format (su2)": {"su2"},
    "input format (.wkt)": {".wkt", "wkt"},
    "scheme (semi-implicit)": {"semi-implicit", "SemiImplicitEuler"},
}


def sources() -> Iterator[tuple[Path, ast.Module]]:
    """Every module of the package with its syntax tree."""
    for path in sorted(PACKAGE.rglob("*.py")):
        yield path, ast.parse(path.read_text(encoding="utf-8"))


def words(tree: ast.Module) -> set[str]:
    """Names that a module defines or uses, and its short texts."""
    found = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, ast.ClassDef | ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.arg):
            found.add(node.arg)
    return found


def is_record(node: ast.AST) -> bool:
    """Whether a class is a record, another dataclass or a named tuple."""
    if not isinstance(node, ast.ClassDef):
        return False
    decorators = {ast.unparse(each).partition("(")[0] for each in node.decorator_list}
    return bool(decorators & {"record", "dataclass"}) or any("NamedTuple" in ast.unparse(base) for base in node.bases)


def tracked(*folders: str) -> list[Path]:
    """Files under version control."""
    listed = subprocess.run(["git", "ls-files", *folders], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / line for line in listed.stdout.splitlines() if (ROOT / line).exists()]


def timed_tests(*options: str) -> str:
    """Seconds that the tests take, and how they end."""
    begun = perf_counter()
    run = subprocess.run([sys.executable, "-m", "pytest", *options], cwd=ROOT, capture_output=True, text=True)
    return f"{perf_counter() - begun:.0f} s: {run.stdout.strip().splitlines()[-1]}"


def main() -> None:
    """Print the numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tests", action="store_true", help="run the tests of the README's line, and time them")
    options = parser.parse_args()
    modules = dict(sources())
    lines = {path: path.read_text(encoding="utf-8").count("\n") for path in modules}
    loose = [path.stem for path in PACKAGE.glob("*.py") if not path.stem.startswith("__")]
    print(f"loose modules at the package's root: {len(loose)} ({', '.join(sorted(loose))})")
    print(f"modules: {len(modules)}, lines: {sum(lines.values())}")
    longest = max(lines, key=lambda path: lines[path])
    print(f"longest module: {longest.relative_to(PACKAGE)}, {lines[longest]} lines")
    for thing, names in EXAMPLES.items():
        places = [str(path.relative_to(PACKAGE)) for path, tree in modules.items() if words(tree) & names]
        print(f"places that name one {thing}: {len(places)} ({', '.join(places)})")
    batch = {path: tree for path, tree in modules.items() if path.is_relative_to(PACKAGE / "batch")}
    records = [node.name for tree in batch.values() for node in ast.walk(tree) if is_record(node)]
    print(f"batch: {len(batch)} modules, {len(records)} records ({', '.join(records)})")
    sizes = {path: path.stat().st_size for path in tracked(*GENERATED)}
    pictures = {path: size for path, size in sizes.items() if path.suffix in (".png", ".svg")}
    print(f"generated files: {sum(sizes.values()) / 1e6:.2f} MB, largest picture {max(pictures.values()) / 1e3:.0f} kB")
    if options.tests:
        print(f"tests of the README's line: {timed_tests('-n', 'auto')}")


if __name__ == "__main__":
    main()
