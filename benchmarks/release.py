"""Whether a release can be built, installed and used: ``python -m benchmarks.release``.

From the tracked files of the checkout it builds the sdist, of that a wheel with compiled kernels and one without, and
checks what is in them. Then it installs the wheels into new environments, for each Python and for the newest and the
lowest versions of all dependencies, and uses them in an empty folder. ``--sizes`` prints what each package takes on the
disk; ``--tests`` runs the quick tests too, with the dependencies of each environment. It needs
``pip install -e ".[release]"``.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from time import perf_counter
from zipfile import ZipFile

ROOT = Path(__file__).parent.parent
RESOLUTIONS = {"newest": "highest", "lowest": "lowest-direct"}
MADE = re.compile(r"PKG-INFO|setup\.cfg|bubblemesh\.egg-info/.*")  # what setuptools adds to an sdist
LIBRARY = re.compile(r"bubblemesh/kernels/_compiled\.(abi3\.so|pyd)")
DETAILS = re.compile(r"bubblemesh-[^/]+\.dist-info/.*")
SIZES = """
import json
from importlib.metadata import distributions
size = lambda file: file.locate().stat().st_size if file.locate().is_file() else 0
print(json.dumps({f"{found.name} {found.version}": sum(map(size, found.files or [])) for found in distributions()}))
"""
VERSIONS = """
import platform, numpy, scipy
print(f"Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}")
"""
KERNELS = "from importlib.util import find_spec; print(find_spec('bubblemesh.kernels._compiled').origin)"
ALL_MODULES = """
from importlib import import_module
from pkgutil import walk_packages
import bubblemesh
for module in walk_packages(bubblemesh.__path__, "bubblemesh."):
    import_module(module.name)
"""


class ReleaseError(Exception):
    """What keeps a release from being made."""


def run(command: Sequence[str | Path], folder: Path, **variables: str) -> str:
    """What a command prints, in a folder and with further environment variables; ReleaseError where it fails."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | variables
    done = subprocess.run([*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise ReleaseError(f"{' '.join(map(str, command))}\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


def tracked() -> set[str]:
    """Names of the files under version control."""
    return set(run(["git", "ls-files"], ROOT).split("\n")) - {""}


def copy_tracked(to: Path) -> None:
    """Copy the tracked files as they are in the checkout, so that no leftovers of other builds get into this one."""
    for name in tracked():
        target = to / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes((ROOT / name).read_bytes())


def build(source: Path, to: Path) -> tuple[Path, Path, Path]:
    """The sdist, a wheel with kernels and one without, both made of the sdist."""
    run([sys.executable, "-m", "build", "--outdir", to, source], to.parent)
    (sdist,), (wheel,) = to.glob("*.tar.gz"), to.glob("*.whl")
    plain = to / "without-compiler"
    with tarfile.open(sdist) as archive:
        archive.extractall(to, filter="data")
    folder = to / sdist.name.removesuffix(".tar.gz")
    run([sys.executable, "-m", "build", "--wheel", "--outdir", plain, folder], to.parent, CC="false")
    return sdist, wheel, next(plain.glob("*.whl"))


def faults_of_sdist(names: set[str], files: set[str]) -> list[str]:
    """What is wrong with the contents of an sdist, given the tracked files."""
    missing, stray = files - names, {name for name in names - files if not MADE.fullmatch(name)}
    return [f"the sdist lacks {name}" for name in sorted(missing)] + [f"stray: {name}" for name in sorted(stray)]


def faults_of_wheel(names: set[str], files: set[str], kernels: bool) -> list[str]:
    """What is wrong with the contents of a wheel, given the tracked files and whether it has compiled kernels."""
    package = {name for name in files if name.startswith("bubblemesh/") and "/source/" not in name}
    compiled = {name for name in names if LIBRARY.fullmatch(name)}
    stray = {name for name in names - package - compiled if not DETAILS.fullmatch(name)}
    faults = [f"the wheel lacks {name}" for name in sorted(package - names)]
    faults += [f"stray: {name}" for name in sorted(stray)]
    if bool(compiled) != kernels:
        faults += [f"the wheel has {'no' if kernels else 'unwanted'} compiled kernels"]
    if not any(name.endswith("/licenses/LICENSE") for name in names):
        faults += ["the wheel has no licence"]
    return faults


def check_contents(sdist: Path, wheel: Path, plain: Path) -> None:
    """ReleaseError, unless the archives hold what they must and nothing else."""
    files = tracked()
    with tarfile.open(sdist) as archive:
        names = {member.name.partition("/")[2] for member in archive.getmembers() if member.isfile()}
    faults = faults_of_sdist(names, files)
    for path, kernels in ((wheel, True), (plain, False)):
        with ZipFile(path) as contents:
            faults += faults_of_wheel(set(contents.namelist()), files, kernels)
    if faults:
        raise ReleaseError("\n".join(faults))


def install(wheel: Path, extra: str, python: str, resolution: str, folder: Path) -> Path:
    """The interpreter of a new environment with a wheel and, by a rule of uv, what it and an extra of it depend on."""
    uv = [sys.executable, "-m", "uv"]
    run([*uv, "venv", "--quiet", "--python", python, folder], folder.parent)
    inside = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    into = [*uv, "pip", "install", "--quiet", "--python", inside]
    # No library is compiled: the lowest version is the first of which there is a wheel for this Python. To uv only
    # what pyproject.toml names is direct, not what a wheel names.
    rules = ["--resolution", RESOLUTIONS[resolution], "--only-binary", ":all:"]
    extras = ["--extra", extra] if extra else []
    run([*into, *rules, "--requirements", ROOT / "pyproject.toml", *extras], folder.parent)
    run([*into, "--no-deps", wheel], folder.parent)
    run([*uv, "pip", "check", "--python", inside], folder.parent)
    return inside


def use(python: Path, number: str, kernels: str, folder: Path) -> None:
    """Use what is installed as a newcomer does, in an empty folder; ReleaseError where something is amiss."""
    folder.mkdir()
    command = [python, "-W", "error::SyntaxWarning", "-m", "bubblemesh"]
    told = run([*command, "--version"], folder).strip()
    if told != f"{number} (kernels: {kernels})":
        raise ReleaseError(f"bubblemesh --version tells {told!r}, not version {number} with kernels {kernels}")
    (folder / "plate.yaml").write_bytes((ROOT / "configs/quickstart.yaml").read_bytes())
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    example = readme.partition("```python\n")[2].partition("```")[0]
    run([*command, "init", "new.yaml"], folder)
    run([*command, "check", "new.yaml"], folder)
    run([*command, "run", "plate.yaml", "--report", "-o", "out"], folder)
    run([*command, "run", "plate.yaml", "-o", "plate.xdmf"], folder)
    run([*command, "quality", "plate.xdmf"], folder)
    run([*command, "plot", "plate.xdmf", "-o", "picture.png"], folder)
    run([python, "-c", example], folder)
    if kernels == "compiled":  # and all extras
        run([python, "-c", ALL_MODULES], folder)
    for name in ("new.yaml", "out/plate.msh", "out/plate.html", "picture.png", "plate.vtu", "plate.png"):
        if not (folder / name).exists():
            raise ReleaseError(f"{name} was not written")


def print_sizes(python: Path, folder: Path) -> None:
    """Print what each package takes on the disk, in MB without compiled bytecode."""
    sizes: dict[str, int] = json.loads(run([python, "-c", SIZES], folder))
    for name, size in sorted(sizes.items(), key=lambda item: -item[1]):
        print(f"    {size / 1e6:7.1f} MB  {name}")
    print(f"    {sum(sizes.values()) / 1e6:7.1f} MB  together")


def run_tests(python: Path, resolution: str, source: Path) -> None:
    """Run the quick tests of a source tree with the libraries of an environment, and print the last line.

    Tests import the source tree and start what is installed: the tree gets the kernels of the latter.
    """
    (library,) = run([python, "-c", KERNELS], python.parent).split()
    (source / "bubblemesh" / "kernels" / Path(library).name).write_bytes(Path(library).read_bytes())
    # What libraries that old warn of is not ours.
    lenient = ["-W", "ignore::DeprecationWarning"] if resolution == "lowest" else []
    print(run([python, "-m", "pytest", "-n", "auto", *lenient], source).splitlines()[-1], flush=True)


def try_out(wheel: Path, kernels: str, python: str, resolution: str, asked: argparse.Namespace, folder: Path) -> None:
    """Install a wheel into a new environment in a folder, use it there, and print what was asked for."""
    begun = perf_counter()
    folder.mkdir()
    # Where there is no compiler only what everybody needs is installed: imports of extras would show.
    extra = "" if kernels == "numpy" else "dev" if asked.tests else "all"
    inside = install(wheel, extra, python, resolution, folder / "environment")
    use(inside, version(), kernels, folder / "use")
    told = run([inside, "-c", VERSIONS], folder).strip()
    print(f"{perf_counter() - begun:6.1f} s  {resolution} dependencies ({told}), kernels: {kernels}", flush=True)
    if asked.sizes:
        print_sizes(inside, folder)
    if asked.tests and extra:
        run_tests(inside, resolution, folder.parent / "source")


def version() -> str:
    """The version of the checkout, as its one place has it."""
    (found,) = re.findall(r'^__version__ = "(.+)"$', (ROOT / "bubblemesh/__init__.py").read_text(), re.MULTILINE)
    return found


def keep(archives: Sequence[Path], to: Path) -> None:
    """Copy archives into a folder."""
    to.mkdir(parents=True, exist_ok=True)
    for path in archives:
        (to / path.name).write_bytes(path.read_bytes())


def options() -> argparse.Namespace:
    """What the command line asks for."""
    parser = argparse.ArgumentParser("python -m benchmarks.release", description=__doc__)
    parser.add_argument(
        "--python", action="append", metavar="P", help="a version or an interpreter; may be repeated [the present one]"
    )
    parser.add_argument("--only", choices=RESOLUTIONS, help="which versions of dependencies [both]")
    parser.add_argument("--output", type=Path, metavar="DIR", help="keep the sdist and the wheel in this folder")
    parser.add_argument("--sizes", action="store_true", help="print what each package takes on the disk")
    parser.add_argument("--tests", action="store_true", help="run the quick tests with each set of dependencies")
    return parser.parse_args()


def main() -> None:
    """Build, check, install and use."""
    asked = options()
    pythons = asked.python or [sys.executable]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copy_tracked(folder / "source")
        (folder / "dist").mkdir()
        sdist, wheel, plain = build(folder / "source", folder / "dist")
        check_contents(sdist, wheel, plain)
        for path in (sdist, wheel):
            print(f"{path.stat().st_size / 1e3:6.0f} kB  {path.name}", flush=True)
        for number, (python, rule) in enumerate(product(pythons, [asked.only] if asked.only else RESOLUTIONS)):
            try_out(wheel, "compiled", python, rule, asked, folder / str(number))
        try_out(plain, "numpy", pythons[0], asked.only or "newest", asked, folder / "without-compiler")
        if asked.output:
            keep([sdist, wheel], asked.output)


if __name__ == "__main__":
    try:
        main()
    except ReleaseError as error:
        sys.exit(str(error))
