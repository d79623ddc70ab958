"""What a release is made of agrees: metadata, extras, recipe, workflow, changelog, and the contents of archives."""

import re
import sys
import tomllib

import pytest
import yaml
from paths import ROOT
from sources import MODULES, found_in

import bubblemesh
from benchmarks import release

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
METADATA = PROJECT["project"]
EXTRAS = METADATA["optional-dependencies"]
FOR_DEVELOPERS = {"benchmarks", "dev", "docs", "long", "release"}
FOR_USERS = set(EXTRAS) - FOR_DEVELOPERS - {"all"}
RECIPE = yaml.safe_load((ROOT / ".conda/recipe.yaml").read_text(encoding="utf-8"))
WORKFLOW = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8"))
CONDA_NAMES = {"matplotlib": "matplotlib-base"}
PACKAGES = {
    "PIL": "pillow",
    "annotated_types": "annotated-types",
    "typing_extensions": "typing-extensions",
    "yaml": "pyyaml",
}
BROUGHT = {"pydantic_core": "pydantic"}  # a part of another package that has a name of its own
REQUIREMENT = re.compile(r"([\w-]+)(?:\[([\w,-]+)\])?(?:>=([\w.]+))?")


def parts(requirement):
    """Name, extras and lowest version of a requirement."""
    name, extras, lowest = REQUIREMENT.fullmatch(requirement.partition(";")[0].strip()).groups()
    return name, set(extras.split(",")) if extras else set(), lowest


def bounds(requirements):
    """Lowest version by name."""
    return {name: lowest for name, _, lowest in map(parts, requirements)}


def steps(job):
    """Commands of a job of the workflow."""
    return [step["run"] for step in WORKFLOW["jobs"][job]["steps"] if "run" in step]


def test_all_holds_each_extra_of_users():
    assert [parts(requirement)[:2] for requirement in EXTRAS["all"]] == [("bubblemesh", FOR_USERS)]
    assert parts(EXTRAS["dev"][0])[:2] == ("bubblemesh", {"all"})


def test_each_requirement_has_a_lowest_version():
    for requirement in [*METADATA["dependencies"], *(one for extra in EXTRAS.values() for one in extra)]:
        _, extras, lowest = parts(requirement)
        assert lowest or extras, requirement


def test_dependencies_are_what_the_package_imports():
    imported = {name.partition(".")[0] for path in MODULES for name in found_in(path).imports}
    imported = {PACKAGES.get(name, BROUGHT.get(name, name)) for name in imported - sys.stdlib_module_names}
    optional = {parts(requirement)[0] for extra in FOR_USERS for requirement in EXTRAS[extra]}
    assert imported - optional - {"bubblemesh"} == set(bounds(METADATA["dependencies"]))


def test_every_version_of_python_is_said_in_the_same_way():
    versions = re.findall(r"Python :: (3\.\d+)", " ".join(METADATA["classifiers"]))
    oldest, digits = versions[0], versions[0].replace(".", "")
    assert METADATA["requires-python"] == f">={oldest}"
    assert PROJECT["tool"]["distutils"]["bdist_wheel"]["py_limited_api"] == f"cp{digits}"
    assert PROJECT["tool"]["ruff"]["target-version"] == f"py{digits}"
    assert PROJECT["tool"]["cibuildwheel"]["build"][0] == f"cp{digits}-*"
    library = (ROOT / "bubblemesh/kernels/source/library.c").read_text(encoding="utf-8")
    assert f"#define Py_LIMITED_API 0x03{int(oldest[2:]):02x}0000" in library
    assert f"python >={oldest}" in RECIPE["requirements"]["run"]
    assert f"You need Python {oldest} or newer" in (ROOT / "README.md").read_text(encoding="utf-8")
    tested = WORKFLOW["jobs"]["tests"]["strategy"]["matrix"]
    assert tested["python"] == [*versions, "3.x"]
    assert [name.partition("-")[0] for name in tested["os"]] == ["ubuntu", "macos", "windows"]
    assert WORKFLOW["jobs"]["release"]["strategy"]["matrix"]["python"] == versions


def test_the_version_has_one_place_and_all_others_agree():
    assert METADATA["dynamic"] == ["version"]
    assert release.version() == bubblemesh.__version__
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"] == bubblemesh.__version__
    assert RECIPE["context"]["version"] == bubblemesh.__version__
    headings = re.findall(r"^## (.+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    for heading in headings:
        assert re.fullmatch(r"\d+\.\d+\.\d+ \((unreleased|\d{4}-\d\d-\d\d)\)", heading), heading
    assert headings[0].split()[0] == bubblemesh.__version__
    assert not any("unreleased" in heading for heading in headings[1:])


def test_the_recipe_asks_for_the_same_libraries():
    required = {**bounds(METADATA["dependencies"]), "python": METADATA["requires-python"].removeprefix(">=")}
    conda = dict(line.split(" >=") for line in RECIPE["requirements"]["run"])
    assert conda == {CONDA_NAMES.get(name, name): lowest for name, lowest in required.items()}
    optional = bounds(requirement for extra in FOR_USERS for requirement in EXTRAS[extra])
    assert dict(line.split(" >=") for line in RECIPE["requirements"]["run_constraints"]) == optional
    (setuptools,) = PROJECT["build-system"]["requires"]
    assert setuptools.replace(">=", " >=") in RECIPE["requirements"]["host"]
    assert RECIPE["about"]["summary"] == METADATA["description"]
    assert RECIPE["about"]["license"] == METADATA["license"]


def test_the_workflow_runs_the_test_line_of_the_readme():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    line = next(line for line in readme.splitlines() if line.endswith(".venv/bin/pytest -n auto"))
    _, *commands = line.replace(".venv/bin/", "").split(" && ")
    assert steps("tests") == commands
    assert [step for step in steps("without-compiler") if "grep" not in step] == commands
    assert ".ci/run" in steps("everything")
    (setup,) = [step for step in steps("lowest") if "--resolution lowest-direct" in step]
    assert setup.endswith(commands[0].removeprefix("pip install"))
    assert [step for step in steps("lowest") if step.startswith(commands[1])]


def test_the_workflow_may_read_only_and_each_job_has_a_checkout():
    assert WORKFLOW["permissions"] == {"contents": "read"}
    for name, job in WORKFLOW["jobs"].items():
        assert set(job) <= {"runs-on", "strategy", "steps", "env", "permissions"}, name
        assert job["steps"][0]["uses"].startswith("actions/checkout@"), name
        assert all(re.fullmatch(r"actions/[\w-]+@v\d+", step["uses"]) for step in job["steps"] if "uses" in step), name


@pytest.mark.parametrize("name", ["pyproject.toml", ".conda/recipe.yaml", ".github/workflows/tests.yml", ".ci/run"])
def test_no_registry_of_packages_is_addressed(name):
    assert not re.search(r"https?://|index-url|find-links", (ROOT / name).read_text(encoding="utf-8"))


def test_every_c_file_is_compiled_and_every_asset_packed():
    (extension,) = PROJECT["tool"]["setuptools"]["ext-modules"]
    source = ROOT / "bubblemesh/kernels/source"
    assert sorted(extension["sources"]) == sorted(path.relative_to(ROOT).as_posix() for path in source.glob("*.c"))
    assert extension["depends"] == sorted(path.relative_to(ROOT).as_posix() for path in source.glob("*.h"))
    assert extension["optional"]
    data = PROJECT["tool"]["setuptools"]["package-data"]
    packed = {path for package, names in data.items() for name in names for path in _files_of(package, name)}
    others = {
        path for path in (ROOT / "bubblemesh").rglob("*") if path.is_file() and path.suffix not in (".py", ".c", ".h")
    }
    ignored = (".pyc", ".so", ".pyd")
    assert packed == {path for path in others if path.suffix not in ignored}


def _files_of(package, pattern):
    return ROOT.joinpath(*package.split(".")).glob(pattern)


FILES = {"LICENSE", "pyproject.toml", "bubblemesh/py.typed", "bubblemesh/a.py", "bubblemesh/kernels/source/a.c"}
PACKED = {"bubblemesh/py.typed", "bubblemesh/a.py", "bubblemesh-0.1.0.dist-info/licenses/LICENSE"}
COMPILED = "bubblemesh/kernels/_compiled.abi3.so"


def test_an_sdist_holds_what_is_tracked_and_nothing_else():
    assert release.faults_of_sdist(FILES | {"PKG-INFO", "setup.cfg", "bubblemesh.egg-info/SOURCES.txt"}, FILES) == []
    assert release.faults_of_sdist(FILES - {"LICENSE"} | {"out.msh"}, FILES) == [
        "the sdist lacks LICENSE",
        "stray: out.msh",
    ]


def test_a_wheel_holds_the_package_and_nothing_else():
    assert release.faults_of_wheel({*PACKED, COMPILED}, FILES, kernels=True) == []
    assert release.faults_of_wheel(PACKED, FILES, kernels=False) == []
    assert release.faults_of_wheel(PACKED, FILES, kernels=True) == ["the wheel has no compiled kernels"]
    names = {*PACKED, COMPILED, "tests/test_api.py", "bubblemesh/kernels/source/a.c"} - {"bubblemesh/py.typed"}
    assert release.faults_of_wheel(names, FILES, kernels=False) == [
        "the wheel lacks bubblemesh/py.typed",
        "stray: bubblemesh/kernels/source/a.c",
        "stray: tests/test_api.py",
        "the wheel has unwanted compiled kernels",
    ]
