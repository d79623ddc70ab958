"""The README keeps its promises: what it shows is what is there."""

import re
import subprocess
import sys
from shutil import copyfile

import pytest
from paths import ROOT

from bubblemesh.case import load_case
from bubblemesh.meshfiles.writing import write_files
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import mesh_case

ROOT = ROOT
README = (ROOT / "README.md").read_text()
COARSE = ["parameters.h=0.2", "schedule.iterations=30", "schedule.rounds=2"]


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def without_comments(text):
    return [line for line in text.splitlines() if line.strip() and not line.startswith("#")]


def test_the_case_shown_is_the_quickstart():
    shown, _ = blocks("yaml")
    assert without_comments(shown) == without_comments((ROOT / "configs/quickstart.yaml").read_text())


def test_the_mapping_of_terms_shown_is_a_spacing_of_the_quickstart():
    _, shown = blocks("yaml")
    case, _, _ = (ROOT / "configs/quickstart.yaml").read_text().partition("spacing:")
    problem = prepare(load_case("plate.yaml", text=case + shown))
    assert problem.survey.extremes.minimum == pytest.approx(0.02, rel=0.01)
    assert problem.survey.extremes.maximum < 0.2


def test_there_are_exactly_two_set_up_lines():
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("python3 -m venv")]
    run, test = lines
    assert run.endswith(".venv/bin/bubblemesh run configs/quickstart.yaml -o out")
    assert test.endswith(".venv/bin/pytest -n auto")
    assert README.index("<!-- setup:run -->") < README.index(run)
    assert README.index("<!-- setup:test -->") < README.index(test)


def test_links_and_pictures_lead_to_files():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


@pytest.fixture(scope="module")
def mesh_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mesh")
    result = mesh_case(load_case(ROOT / "configs/quickstart.yaml", overrides=COARSE))
    write_files(result.mesh, result.fields, result.report, folder, "plate", ["msh"])
    return folder / "plate.msh"


def test_the_python_block_runs_in_a_folder_with_the_quickstart_mesh(tmp_path):
    case = load_case(ROOT / "configs/quickstart.yaml", overrides=COARSE)
    result = mesh_case(case)
    write_files(result.mesh, result.fields, result.report, tmp_path / "out", str(case.name), ["msh"])
    (block,) = blocks("python")
    printed = subprocess.run([sys.executable, "-c", block], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert re.search(r"\d+", printed.stdout)


@pytest.mark.long
@pytest.mark.parametrize("command", re.findall(r"^bubblemesh (.*?)(?:\s+#.*)?$", "\n".join(blocks("sh")), flags=re.M))
def test_every_command_shown_works(command, mesh_file, tmp_path):
    (tmp_path / "plate.yaml").write_text((ROOT / "configs/quickstart.yaml").read_text())
    copyfile(mesh_file, tmp_path / "plate.msh")
    takes_settings = command.split()[0] in ("run", "batch", "check") and "parameters.h" not in command
    coarse = " ".join(f"--set {setting}" for setting in COARSE) if takes_settings else ""
    options, arrow, target = command.partition(" > ")
    line = f"{sys.executable} -m bubblemesh {options} {coarse} {arrow} {target}"
    subprocess.run(["bash", "-c", line], cwd=tmp_path, check=True, capture_output=True, timeout=120)


def test_every_shipped_case_is_valid():
    for path in sorted((ROOT / "configs").rglob("*.yaml")):
        assert load_case(path).name
