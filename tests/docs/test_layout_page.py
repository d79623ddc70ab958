"""docs/layout.md names every room, and nothing that is not there."""

import re

from paths import ROOT

PAGE = (ROOT / "docs/layout.md").read_text()
PACKAGE = ROOT / "bubblemesh"


def test_every_room_is_told():
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    modules = {path.stem for path in PACKAGE.glob("[a-z]*.py")}
    assert set(re.findall(r"^\| `(\w+)` \|", PAGE, re.MULTILINE)) == rooms
    assert modules <= set(re.findall(r"`(\w+)`", PAGE))


def test_all_that_it_names_is_there():
    names = set(re.findall(r"`(\w+(?:/\w+)*/\w+(?:\.py)?)`", PAGE))
    assert len(names) > 10
    assert [name for name in names if not (PACKAGE / name).exists()] == []
