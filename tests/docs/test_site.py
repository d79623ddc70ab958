"""The site: its pages run as they stand in an empty folder, the reference is made of the program, no warnings."""

import re
import subprocess
import sys
from importlib.util import find_spec

import pytest
from paths import ROOT
from site_pages import blocks, followed

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.case.models import case_schema
from bubblemesh.cli import app
from bubblemesh.problem.prepare import prepare
from docs.make_case_keys import case_keys
from docs.make_command_options import command_options
from docs.make_gallery import gallery

DOCS = ROOT / "docs"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
FOLLOWED = [DOCS / "start.md", DOCS / "commands.md", *TUTORIALS]
NUMBER = re.compile(r"\d+(?:\.\d+)?")


@pytest.mark.long
@pytest.mark.parametrize("page", FOLLOWED, ids=lambda page: page.stem)
def test_a_page_runs_as_it_stands_from_an_empty_folder(page, tmp_path):
    pytest.importorskip("skfem", reason="scikit-fem is not installed")
    for shown, printed in followed(page, tmp_path):
        printed = "\n".join(line for line in printed.splitlines() if line.strip())
        assert NUMBER.sub("#", printed) == NUMBER.sub("#", shown).strip()
        # Other versions of NumPy round otherwise, so that a few nodes and the last digits may differ.
        assert numbers(printed) == pytest.approx(numbers(shown), rel=0.05, abs=0.1)


def numbers(text):
    return [float(number) for number in NUMBER.findall(text)]


def test_every_tutorial_shows_what_it_prints_and_is_in_the_index():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    assert len(TUTORIALS) == 7
    for page in TUTORIALS:
        assert index.count(f"tutorials/{page.stem}") == 2
        assert {"yaml", "sh", "python", "text"} - {language for language, _ in blocks(page)} <= {"yaml"}


def test_the_case_of_the_reference_is_the_quickstart_and_takes_the_terms_shown():
    case, terms = [text for language, text in blocks(DOCS / "case.md") if language == "yaml"]
    quickstart = load_case(ROOT / "configs/quickstart.yaml")
    assert load_case("plate.yaml", text=case).model_dump() == quickstart.model_dump()
    problem = prepare(load_case("plate.yaml", text=case.partition("spacing:")[0] + terms))
    assert problem.survey.extremes.minimum == pytest.approx(0.02, rel=0.01)
    assert problem.survey.extremes.maximum < 0.2


def test_every_key_of_the_case_is_on_its_page():
    text, schema = case_keys(), case_schema()
    parts = [schema, *schema["$defs"].values()]
    for key in {key for part in parts for key in part.get("properties", {})}:
        assert f"`{key}`" in text, key
    assert set(re.findall(r"\(#(case-\w+)\)", text)) == set(re.findall(r"^\((case-\w+)\)=$", text, re.MULTILINE))


def test_every_command_is_on_its_page_with_its_options():
    text, page = command_options(), (DOCS / "commands.md").read_text(encoding="utf-8")
    for name in (command.callback.__name__ for command in app.registered_commands):
        assert f"Usage: bubblemesh {name}" in text
        assert f"`bubblemesh {name}" in page
    assert {"--output", "--for", "--set", "--solution", "--jobs"} <= set(re.findall(r"--\w+", text))


def test_every_name_of_the_package_is_on_the_page_on_python():
    page = (DOCS / "python.md").read_text(encoding="utf-8")
    named = set(re.findall(r"auto(?:function|class|exception):: (\w+)", page))
    assert named == set(bubblemesh.__all__) - {"Case", "__version__"}  # a case is its file: case.md


def test_the_gallery_has_every_sample():
    text = gallery()
    pictures = {path.name for path in (ROOT / "sample_outputs").glob("*.png")}
    assert set(re.findall(r":img-top: \.\./sample_outputs/(\S+)", text)) == pictures
    cases = re.findall(r"literalinclude\} \.\./(\S+)", text)
    assert len(cases) == len(pictures)
    assert all((ROOT / case).exists() for case in cases)


@pytest.mark.long
def test_the_site_is_built_without_warnings(tmp_path):
    if not all(map(find_spec, ("sphinx", "myst_parser", "furo", "sphinx_design"))):
        pytest.skip('the site needs pip install -e ".[docs]"')
    command = [sys.executable, "-m", "sphinx", "-W", "-q", "-d", tmp_path / "trees", DOCS, tmp_path / "site"]
    built = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert built.returncode == 0, built.stderr
    assert "configs/gallery/bracket.yaml" in (tmp_path / "site/gallery.html").read_text(encoding="utf-8")
