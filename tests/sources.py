"""The package's own modules, and what is found in them."""

import ast
from functools import cache
from typing import NamedTuple

import numpy as np
from paths import ROOT

PACKAGE = ROOT / "bubblemesh"
MODULES = sorted(PACKAGE.rglob("*.py"))


class Found(NamedTuple):
    """What a module imports, by dotted names, calls by plain names, and defines as classes and as constant numbers."""

    imports: list[str]
    calls: set[str]
    classes: list[str]
    numbers: dict[str, float]


def constant_numbers(tree):
    """Names in capitals and values of the numbers that a module assigns to them, as far as they depend on no others."""
    for node in tree.body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            several = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
            pairs = zip(target.elts, node.value.elts, strict=True) if several else [(target, node.value)]
            for name, value in pairs:
                if isinstance(name, ast.Name) and name.id.isupper():
                    try:
                        number = eval(ast.unparse(value), {"np": np})
                    except NameError:
                        continue
                    if isinstance(number, int | float):
                        yield name.id, number


@cache
def found_in(path):
    """What is found in a module, which is parsed once for all tests."""
    tree = ast.parse(path.read_text())
    found = Found([], set(), [], dict(constant_numbers(tree)))
    for node in ast.walk(tree):
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
