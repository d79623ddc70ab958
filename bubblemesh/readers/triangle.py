"""Input of the Triangle program: ``.poly`` files with their vertices, segments, markers and holes."""

from collections.abc import Iterator
from pathlib import Path

from bubblemesh.errors import CaseError, prefixed
from bubblemesh.files import read_text
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.rings import LineTo
from bubblemesh.messages import shown
from bubblemesh.readers.features import CompoundCurve, Feature, FeatureCollection, finite_points

Row = tuple[int, list[float]]  # line and numbers


def _rows(path: Path) -> Iterator[Row]:
    """The lines of a file that hold numbers, one after the other."""
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        words = line.partition("#")[0].split()
        if words:
            try:
                yield number, [float(word) for word in words]
            except ValueError:
                raise CaseError(f"line {number}: not a row of numbers: {shown(line, 40)!r}") from None


def _next(rows: Iterator[Row], columns: int, what: str) -> Row:
    """The next row, which must have so many columns."""
    number, row = next(rows, (0, []))
    if len(row) < columns:
        raise CaseError(f"{f'line {number}' if row else 'the end of the file'}: expected {what}")
    return number, row


def _head(rows: Iterator[Row], what: str) -> tuple[int, list[float]]:
    """Number of rows that follow in a section, and the further numbers of the line that says so."""
    line, (count, *more) = _next(rows, 1, what)
    if not (count >= 0 and count.is_integer()):
        raise CaseError(f"line {line}: {count:g} is no number of rows: expected {what}")
    return int(count), more


def _section(rows: Iterator[Row], count: int, what: str) -> Iterator[Row]:
    """Rows of a section, each with three columns or more."""
    return (_next(rows, 3, what) for _ in range(count))


def read_poly(path: Path) -> FeatureCollection:
    """The segments of a ``.poly`` file; a boundary marker other than 0 becomes the label of its segment.

    Vertices that the file leaves out are read from the ``.node`` file beside it. FileError or CaseError with the line.
    """
    rows = _rows(path)
    count, dimension = _head(rows, "the number of vertices")
    vertices = _vertices(rows, count, dimension) if count else _vertices_beside(path.with_suffix(".node"))
    count, marked = _head(rows, "the number of segments")
    curves = []
    for line, (_, begin, end, *marker) in _section(rows, count, "a segment: its number and two vertices"):
        name = f"segment in line {line}"
        if begin not in vertices or end not in vertices:
            missing = begin if begin not in vertices else end
            raise CaseError(f"{name}: there is no vertex {missing:g}: vertices are named by their numbers")
        label = f"{marker[0]:g}" if marked and marked[0] and marker and marker[0] else None
        curves.append(CompoundCurve(vertices[begin], (LineTo(vertices[end], label),), name))
    count, _ = _head(rows, "the number of holes")
    holes = [(x, y) for _, (_, x, y, *_) in _section(rows, count, "a hole: its number, x and y")]
    notes = ("regions and area limits of the file are not used",) if next(rows, None) is not None else ()
    return FeatureCollection(
        (Feature("the segments", curves=tuple(curves)),), notes, tuple(finite_points(holes, "hole"))
    )


def _vertices_beside(path: Path) -> dict[float, Point]:
    """Vertices of a ``.node`` file; errors name it."""
    with prefixed(f"its vertices are in {path.name}"):
        rows = _rows(path)
        return _vertices(rows, *_head(rows, "the number of vertices"))


def _vertices(rows: Iterator[Row], count: int, dimension: list[float]) -> dict[float, Point]:
    """Vertices by their numbers."""
    if dimension and dimension[0] != 2:
        raise CaseError(f"the vertices have {dimension[0]:g} dimensions: only those of the plane are read")
    found: dict[float, Point] = {}
    for line, (number, x, y, *_) in _section(rows, count, "a vertex: its number, x and y"):
        if number in found:
            raise CaseError(f"line {line}: the vertex {number:g} is given twice: number them one after the other")
        (found[number],) = finite_points([(x, y)], f"vertex in line {line}")
    return found
