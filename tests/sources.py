"""The package's own modules, and what is found in them."""

import ast
from functools import cache
from typing import NamedTuple

from paths import ROOT

PACKAGE = ROOT / "bubblemesh"
MODULES = sorted(PACKAGE.rglob("*.py"))


class Found(NamedTuple):
    """What a module imports, by dotted names, calls by plain names, and defines as classes."""

    imports: list[str]
    calls: set[str]
    classes: list[str]


@cache
def found_in(path):
    """What is found in a module, which is parsed once for all tests."""
    found = Found([], set(), [])
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found.imports.extend(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            rooms = [f"bubblemesh.{alias.name}" for alias in node.names]
            found.imports.extend(rooms if node.module == "bubblemesh" else [node.module])
        elif isinstance(node, ast.Call):
            found.calls.add(getattr(node.func, "id", ""))
        elif isinstance(node, ast.ClassDef):
            found.classes.append(node.name)
    return found
