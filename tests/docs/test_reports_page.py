"""docs/reports.md keeps its promises: its commands run, and what it shows is what they print."""

import re
import shutil

import pytest
from paths import ROOT
from typer.testing import CliRunner

from bubblemesh.cli import app

ROOT = ROOT
PAGE = (ROOT / "docs/reports.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```sh\n(.*?)```", PAGE, flags=re.DOTALL)
COMMANDS = re.findall(r"^bubblemesh (.*?)(?:\s+#.*)?$", "\n".join(BLOCKS), flags=re.M)
PICTURES = ("quality.png", "material.png", "spacing.svg", "rim.png", "labels.png", "paper.pdf")


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """What each command of the page prints, on coarser meshes, in a folder with its cases."""
    folder = tmp_path_factory.mktemp("reports")
    shutil.copy(ROOT / "configs/gallery/composite.yaml", folder)
    shutil.copy(ROOT / "configs/quickstart.yaml", folder / "plate.yaml")
    printed = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for command in COMMANDS:
            words = [word.strip('"') for word in command.split()]
            coarse = ["--set", "parameters.h=0.1"] if words[0] == "run" else []
            done = CliRunner().invoke(app, [*words, *coarse])
            assert done.exit_code == 0, (command, done.stderr)
            printed[command] = done.stderr
    return folder, printed


@pytest.mark.long
def test_every_command_writes_what_it_names(outputs):
    folder, printed = outputs
    assert len(printed) >= 9
    assert {path.name for path in folder.iterdir()} >= {*PICTURES, "plate.msh"}
    assert (folder / "out/composite.html").read_text(encoding="utf-8").startswith("<!doctype html>")


def test_the_comparison_shown_has_the_rows_that_are_printed(outputs):
    (shown,) = re.findall(r"```text\n(.*?)```", PAGE, flags=re.DOTALL)
    (printed,) = [text for command, text in outputs[1].items() if command == "quality out/composite.vtu plate.msh"]
    figures = re.compile(r"^(?:A|B|[a-z1][a-z1 %/]*?)(?= {2,})", flags=re.M)
    assert figures.findall(shown) == figures.findall(printed)[: len(figures.findall(shown))]
    assert "mean l/d" in figures.findall(shown)


def test_links_and_pictures_lead_to_small_files():
    targets = re.findall(r"\]\(([^)#]+)\)", PAGE) + re.findall(r'src="([^"]+)"', PAGE)
    assert len(targets) >= 7
    for target in targets:
        path = ROOT / "docs" / target
        assert path.exists(), target
        assert path.stat().st_size < 300_000, target
