"""Text of files: tables and JSON that do no harm where they are opened."""

import csv
import json

import pytest

from bubblemesh.meshfiles.text import csv_text, dumped, json_text


@pytest.mark.parametrize(
    ("cell", "expected"),
    [
        ("=HYPERLINK(A1)", "'=HYPERLINK(A1)"),
        ("+cmd", "'+cmd"),
        ("-cmd|' /C calc'!A0", "'-cmd|' /C calc'!A0"),
        ("@SUM(1)", "'@SUM(1)"),
        ("-1+cmd", "'-1+cmd"),
        ("\t=1", r"\t=1"),
        ("\r=1", r"\r=1"),
        ("a\n=1", r"a\n=1"),
        ("\x1b[31m", r"\x1b[31m"),
        ("-5", "-5"),
        ("+1.5e-3", "+1.5e-3"),
        (-5, "-5"),
        (-1e-05, "-1e-05"),
        (None, ""),
        ("wall, left", "wall, left"),
    ],
)
def test_a_cell_of_a_table_is_no_formula_and_steers_no_terminal(cell, expected):
    text = csv_text([[cell, 1]])
    assert text.count("\n") == 1
    assert list(csv.reader([text.rstrip("\n")])) == [[expected, "1"]]


@pytest.mark.parametrize("text", ["\x7f\x9b31m", "\u202e", "name-\udcff", "\U000e0001", 'quote " \\ \n', "é直"])
def test_json_has_escapes_for_what_steers_a_terminal_or_is_no_utf_8(text):
    for written in (dumped({text: [text]}), json_text({text: [text]})):
        assert written.replace("\n", "").isprintable()
        assert json.loads(written.encode()) == {text: [text]}
    assert "é" in dumped("é")
