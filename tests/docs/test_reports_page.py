"""docs/reports.md keeps its promises: its commands write what they name, and what it shows is small."""

import re

import pytest
from paths import ROOT
from site_pages import followed

PATH = ROOT / "docs/reports.md"
PAGE = PATH.read_text(encoding="utf-8")
PICTURES = ("quality.png", "material.png", "spacing.svg", "rim.png", "labels.png", "paper.pdf")


@pytest.mark.long
def test_every_command_writes_what_it_names(tmp_path):
    _, (shown, printed) = followed(PATH, tmp_path)  # the first one is a table of areas
    assert {path.name for path in tmp_path.iterdir()} >= {*PICTURES, "other.msh"}
    assert (tmp_path / "out/composite.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    figures = re.compile(r"^(?:A|B|[a-z1][a-z1 %/]*?)(?= {2,})", flags=re.M)
    assert figures.findall(shown) == figures.findall(printed)[: len(figures.findall(shown))]
    assert "mean l/d" in figures.findall(shown)
    for name in ("nodes", "boundary nodes", "triangles", "area", "mean q"):
        (told,), (there,) = (re.findall(rf"^{name} +([\d.]+) +([\d.]+)", text, flags=re.M) for text in (shown, printed))
        assert [*map(float, there)] == pytest.approx([*map(float, told)], rel=0.01), name


def test_links_and_pictures_lead_to_small_files():
    targets = re.findall(r"\]\(([^)#]+)\)", PAGE) + re.findall(r'src="([^"]+)"', PAGE)
    assert len(targets) >= 6
    for target in targets:
        path = ROOT / "docs" / target
        assert path.exists(), target
        assert path.stat().st_size < 300_000, target
