"""The page on messages: it quotes every message on files, geometry and layers, and nothing that is not said."""

import ast
import re
from functools import cache
from itertools import chain

from paths import ROOT

PACKAGE = ROOT / "bubblemesh"
PAGE = ROOT / "docs" / "messages.md"
ROOMS = ("readers", "geometry", "layers", "files")
PROBLEM = ("compatibility", "domain", "drawing", "layers", "lines_and_points", "prepare", "regions", "repair", "shapes")
ERRORS = (
    *("CaseError", "FileError", "GeometryError", "HighLayerError", "LimitError", "NeighbourError", "NodeLimitError"),
    "UnwrittenError",
)
WORD = re.compile(r"[a-z]{3}")
QUOTED = re.compile(r"^\| `([^`]+)` \|", re.MULTILINE)


def modules():
    """Modules in which files are read, geometry is checked and layers are made."""
    yield from sorted(chain.from_iterable((PACKAGE / room).rglob("*.py") for room in ROOMS))
    yield from (PACKAGE / "problem" / f"{name}.py" for name in PROBLEM)


def text_of(node):
    """Text of an expression, with ... for all that is not fixed."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(map(text_of, node.values))
    return "..."


def said(path):
    """Messages of the errors that a module raises."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.args:
            if node.func.id in ERRORS:
                yield text_of(node.args[0])
            elif node.func.id == "foreign":  # what a library says stands between problem and advice
                yield ": ...: ".join(map(text_of, node.args))


@cache
def messages():
    found = (re.sub(r"(\.\.\.)+", "...", text) for path in modules() for text in said(path))
    return {text for text in found if WORD.search(text)}


def quoted():
    """Messages of errors on the page, and the phrases of keys and notes."""
    errors, _, rest = PAGE.read_text().partition("## Values of keys")
    return set(QUOTED.findall(errors)), set(QUOTED.findall(rest))


def test_every_message_is_on_the_page():
    missing = sorted(messages() - quoted()[0])
    assert not missing, "add to docs/messages.md, with cause and cure:\n" + "\n".join(
        f"| `{text}` |" for text in missing
    )


def test_the_page_quotes_what_is_said():
    assert not sorted(quoted()[0] - messages())


def test_phrases_of_keys_and_notes_are_those_of_the_source():
    sources = "".join(
        re.sub(r"\{[^{}\"]*\}", "...", path.read_text())
        for room in ("case", "geometry", "layers", "readers")
        for path in sorted((PACKAGE / room).rglob("*.py"))
    )
    assert [phrase for phrase in sorted(quoted()[1]) if phrase not in sources] == []


def test_each_message_has_a_cause_and_a_cure():
    rows = [line for line in PAGE.read_text().splitlines() if line.startswith("| `")]
    assert len(rows) > 150
    assert all(len(cell.strip()) > 5 for row in rows for cell in re.split(r"(?<!`) \| ", row.strip("| "))[1:])
