"""The README keeps its promises: what it shows is what is there."""

import re
import subprocess
import sys

import pytest
import yaml
from paths import ROOT

from bubblemesh.case import load_case

README = (ROOT / "README.md").read_text(encoding="utf-8")
MOST_WORDS = 900


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_it_is_short():
    assert len(README.split()) < MOST_WORDS


def test_the_case_shown_is_the_quickstart():
    (shown,) = blocks("yaml")
    assert yaml.safe_load(shown) == yaml.safe_load((ROOT / "configs/quickstart.yaml").read_text(encoding="utf-8"))


def test_there_are_exactly_two_set_up_lines():
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("python3 -m venv")]
    run, test = lines
    assert run.endswith(".venv/bin/bubblemesh run configs/quickstart.yaml -o out")
    assert test.endswith(".venv/bin/pytest -n auto")
    assert README.index("<!-- setup:run -->") < README.index(run)
    assert README.index("<!-- setup:test -->") < README.index(test)


def test_links_and_pictures_lead_to_files():
    targets = re.findall(r"\]\(([^)#]+)\)", README)
    assert len(targets) > 30
    for target in targets:
        assert (ROOT / target).exists(), target


def test_six_pictures_of_the_gallery_follow_the_first_one():
    assert len(re.findall(r"!\[[^\]]+\]\(sample_outputs/[\w-]+\.png\)", README)) == 7


@pytest.mark.long
def test_the_python_block_runs_in_an_empty_folder(tmp_path):
    (block,) = blocks("python")
    printed = subprocess.run([sys.executable, "-c", block], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert re.search(r"\(\d+, 2\) \(\d+, 3\) 0\.9\d\d", printed.stdout)
    assert {path.name for path in tmp_path.iterdir()} >= {"plate.png", "plate.vtu"}


def test_the_paper_is_named_wherever_pages_speak_of_it():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    (paper,) = citation["references"]
    assert "Identified by its abstract" in paper["notes"]
    for page in ("README.md", "docs/methods.md", "docs/multilevel.md", "docs/reproduction.md"):
        text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
        assert paper["title"] in text, page
        assert all(author["family-names"] in text for author in paper["authors"]), page
        assert "identified by its abstract" in text, page


def test_every_shipped_case_is_valid():
    for path in sorted((ROOT / "configs").rglob("*.yaml")):
        assert load_case(path).name
