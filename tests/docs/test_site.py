"""The site: its pages run as they stand in an empty folder, the reference is made of the program, no warnings."""

import re
import subprocess
import sys
from contextlib import chdir
from importlib.util import find_spec

import pytest
from commands import command
from paths import ROOT
from site_pages import all_blocks, blocks, followed

import bubblemesh
from bubblemesh.case import load_case
from bubblemesh.case.models import case_schema
from bubblemesh.cli import app
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.prepare import prepare
from docs.make_case_keys import case_keys
from docs.make_command_options import command_options
from docs.make_gallery import PAGE, gallery, made, on_site

DOCS = ROOT / "docs"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md")), *TUTORIALS]
# Sections on solvers run in their solvers, in tests/meshfiles/test_solvers.py; of the others the files are looked at.
OWN_TESTS = {"solvers", "batch", "reports"}
FOLLOWED = [page for page in PAGES if page.stem not in OWN_TESTS and blocks(page)]
MISSING = {"domain": "{outer: {rectangle: [0, 0, 1, 1]}}", "spacing": "1"}  # for parts of cases
NUMBER = re.compile(r"\d+(?:\.\d+)?")


@pytest.mark.long
@pytest.mark.parametrize("page", FOLLOWED, ids=lambda page: page.stem)
def test_a_page_runs_as_it_stands_from_an_empty_folder(page, tmp_path):
    pytest.importorskip("skfem", reason="scikit-fem is not installed")
    for shown, printed in followed(page, tmp_path):
        told = words(shown.removesuffix("...\n"))
        assert words(printed)[: len(told)] == told
        for number, one in zip(NUMBER.findall(printed), NUMBER.findall(shown), strict=False):
            # Other versions of NumPy round otherwise, so that a few nodes and the last digit may differ.
            assert float(number) == pytest.approx(float(one), rel=0.02, abs=1.5 * last_digit(one)), printed
    for case in [block.name for block in all_blocks(page) if block.name and block.language == "yaml" and block.runs]:
        with chdir(tmp_path):
            code, _, message = command("check", case)
        assert code == 0, message


def words(text):
    return [re.sub(r"[-+]?#%?", "#", NUMBER.sub("#", word)) for word in text.split()]


def last_digit(number):
    """What one more in the last digit of a number's text is."""
    return 10.0 ** -len(number.partition(".")[2])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_says_what_its_programs_and_cases_need_beside_the_package(page):
    shown = [block.text for block in all_blocks(page)]
    needed = {"scikit-fem": r"^from skfem", "[geo]": r"^crs:"}
    text = page.read_text(encoding="utf-8")
    installed = " ".join(re.findall(r"pip install [^`\n]*", text))
    for name, use in needed.items():
        if any(re.search(use, block, re.MULTILINE) for block in shown):
            assert name in installed, name


def test_pages_and_the_case_tell_the_same_holes_of_the_board():
    board = ROOT / "configs/gallery/pcb.yaml"
    holes = case_domain(load_case(board)).hole_count
    for page in ("geometry.md", "tutorials/electronics.md"):
        text = " ".join((DOCS / page).read_text(encoding="utf-8").split())
        drilled, slots = re.search(r"(\d+) drilled holes and (\d+) slots", text).groups()
        assert int(drilled) + int(slots) == holes
        assert f"{drilled} drilled holes" in board.read_text(encoding="utf-8")


PARTS = [
    (page, block.text) for page in PAGES for block in all_blocks(page) if block.language == "yaml" and not block.name
]


@pytest.mark.parametrize(("page", "text"), PARTS, ids=[f"{page.stem}-{k}" for k, (page, _) in enumerate(PARTS)])
def test_parts_of_cases_have_keys_that_cases_have(page, text):
    rest = "".join(f"\n{key}: {value}" for key, value in MISSING.items() if f"{key}:" not in text)
    assert load_case(page.name, text=text + rest).name


def test_blocks_that_are_not_run_say_why():
    marked = [block for page in PAGES for block in all_blocks(page) if not block.runs]
    assert {block.mark for block in marked} <= {"setup", "not run", "needs"}
    assert all(block.detail for block in marked if block.mark != "setup")


@pytest.mark.long
def test_every_command_in_the_text_on_solvers_writes_the_files_that_the_section_reads(tmp_path):
    page = DOCS / "solvers.md"
    for block in all_blocks(page):
        if block.language == "yaml" and block.name:
            (tmp_path / block.name).write_text(block.text, encoding="utf-8")
    commands = re.findall(r"`bubblemesh (run disc\.yaml .*?)`", page.read_text(encoding="utf-8"))
    assert len(commands) > 12
    with chdir(tmp_path):
        for line in commands:
            assert command(*line.split(), "--quiet")[0] == 0, line
    named = re.findall(r"out/disc\.?\w*\.\w+", page.read_text(encoding="utf-8"))
    assert [name for name in named if not (tmp_path / name).exists()] == []


def test_every_tutorial_shows_what_it_prints_and_is_in_the_index():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    assert len(TUTORIALS) == 8
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
    for name in (entry.callback.__name__ for entry in app.registered_commands):
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


def test_the_file_of_the_gallery_lists_every_sample_for_readers_without_the_site():
    text = PAGE.read_text(encoding="utf-8")
    assert text == made(text), "run python docs/make_gallery.py"
    rows = re.findall(r"<a id=\"gallery-(.+?)\"></a>\[\1\]\(\.\./(\S+?)\) \| (.+?) \| <img src=\"\.\./(\S+?)\"", text)
    assert len(rows) == len(list((ROOT / "sample_outputs").glob("*.png")))
    for name, case, shows, picture in rows:
        assert f"(gallery-{name})=" in on_site(text)
        assert (ROOT / case).exists()
        assert (ROOT / picture).exists()
        assert len(shows.split()) > 3
    assert "<a id" not in on_site(text)


def test_links_to_the_gallery_lead_to_its_cases():
    there = set(re.findall(r'<a id="(gallery-[\w-]+)"', PAGE.read_text(encoding="utf-8")))
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert "](#gallery-" not in text, page
        assert set(re.findall(r"gallery\.md#(gallery-[\w-]+)", text)) <= there, page


@pytest.mark.long
def test_the_site_is_built_without_warnings(tmp_path):
    if not all(map(find_spec, ("sphinx", "myst_parser", "furo", "sphinx_design"))):
        pytest.skip('the site needs pip install -e ".[docs]"')
    site = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q"]
    built = subprocess.run(
        [*site, "-d", tmp_path / "trees", DOCS, tmp_path / "site"], capture_output=True, text=True, cwd=tmp_path
    )
    assert built.returncode == 0, built.stderr
    assert "configs/gallery/bracket.yaml" in (tmp_path / "site/gallery.html").read_text(encoding="utf-8")
