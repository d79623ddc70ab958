"""Views of Gmsh as text (.pos): triangles with numbers, vectors or tensors at their corners."""

import re
from codecs import BOM_UTF8
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.errors import FileError
from bubblemesh.files import read_bytes
from bubblemesh.meshfiles.sources.source import Block, Source, reals

COMPONENTS = {b"ST": 1, b"VT": 3, b"TT": 9}  # of triangles
NO_AREAS = (b"SP", b"VP", b"TP", b"SL", b"VL", b"TL", b"T2", b"T3")  # points, lines and texts
REMARK = re.compile(rb"//[^\n]*|/\*.*?\*/", re.DOTALL)
VIEW = re.compile(rb'\s*View\s*"([^"]*)"\s*\{')
TIMES = re.compile(rb"\s*TIME\s*\{[^{}]*\}\s*;")
ITEM = re.compile(rb"\s*([A-Z][A-Z0-9])\s*\(([^()]*)\)\s*\{([^{}]*)\}\s*;")
END = re.compile(rb"\s*\}\s*;?\s*")
CORNERS, COORDINATES = 3, 9


class ViewTriangle(NamedTuple):
    """A triangle of a view: its kind, and the texts of its coordinates and values."""

    kind: bytes
    coordinates: bytes
    values: bytes


def read_pos(path: Path) -> Source:
    """Triangles of a view, each with corners of its own, and their values at the last step.

    FileError if the file holds no view in Gmsh's text format, more than one, triangles of several kinds, or anything
    but triangles, points, lines and texts.
    """
    # Remarks become blanks, but line breaks stay.
    content = read_bytes(path).removeprefix(BOM_UTF8)
    text = REMARK.sub(lambda remark: re.sub(rb"[^\n]", b" ", remark[0]), content)
    head = VIEW.match(text)
    if head is None:
        raise FileError('does not begin with View "name" {: let Gmsh write the view in its parsed text format')
    elements = list(_elements(text, head.end()))
    points = reals(_words([element.coordinates for element in elements]), "coordinates").reshape(-1, 3)
    triangles = Block("triangle", np.arange(len(points)).reshape(-1, CORNERS))
    if not elements:
        return Source(points, [triangles])
    values = reals(_words([element.values for element in elements]), "values")
    steps = values.reshape(len(elements), -1, CORNERS, COMPONENTS[elements[0].kind])
    notes = (f"of {steps.shape[1]} steps the last one is read",) if steps.shape[1] > 1 else ()
    name = head[1].decode(errors="replace")
    return Source(points, [triangles], {name: steps[:, -1].reshape(len(points), -1)}, notes=notes)


def _elements(text: bytes, at: int) -> Iterator[ViewTriangle]:
    """Triangles of a view that begins at an index of the text; FileError, with the line, for other contents."""
    first: ViewTriangle | None = None
    while (end := END.match(text, at)) is None:
        item = ITEM.match(text, at)
        found = item or TIMES.match(text, at)
        if found is None:
            raise FileError(f"{_line(text, at)} is no element of a view, such as TT(...){{...}};, or it ends too early")
        if item is not None and item[1] not in NO_AREAS:
            element = ViewTriangle(*item.groups())
            first = first or element
            try:
                _check(element, first)
            except FileError as error:  # lines are counted for errors only, as that takes long
                raise FileError(f"{_line(text, at)}: {error}") from None
            yield element
        at = found.end()
    if end.end() < len(text):
        raise FileError(f"{_line(text, end.end())} follows after the view: give a file of one view")


def _check(element: ViewTriangle, first: ViewTriangle) -> None:
    """Check that an element is a triangle like the first one."""
    kind = element.kind.decode()
    if element.kind not in COMPONENTS:
        raise FileError(f"holds {kind}: only triangles are read, ST, VT or TT")
    if element.kind != first.kind:
        raise FileError(f"holds {kind} after {first.kind.decode()}: give a view of one kind")
    coordinates, values = (row.count(b",") + 1 for row in element[1:])
    step = CORNERS * COMPONENTS[element.kind]
    if coordinates != COORDINATES or values % step or values != first.values.count(b",") + 1:
        raise FileError(
            f"has {coordinates} coordinates and {values} values: {kind} takes {COORDINATES}, and {step} for each step, "
            "in all triangles alike"
        )


def _words(rows: list[bytes]) -> list[bytes]:
    return b",".join(rows).split(b",") if rows else []


def _line(text: bytes, at: int) -> str:
    """Name of the line at which the text after an index begins."""
    begin = len(text) - len(text[at:].lstrip())
    number = text.count(b"\n", 0, begin) + 1
    return f"line {number}"
