"""Input of the Triangle program: ``.poly`` files with their vertices, segments, markers and holes."""

from collections.abc import Iterator
from pathlib import Path

from bubblemesh.errors import CaseError
from bubblemesh.geometry.rings import LineTo
from bubblemesh.readers.features import Content, Feature, Point, Stroke, checked
from bubblemesh.readers.text import read_text

__all__ = ["read_poly"]


class Rows:
    """The lines of a file that hold numbers, one after the other."""

    def __init__(self, path: Path) -> None:
        self._rows = self._numbered(read_text(path))

    def _numbered(self, text: str) -> Iterator[tuple[int, list[float]]]:
        for number, line in enumerate(text.splitlines(), start=1):
            words = line.partition("#")[0].split()
            if words:
                try:
                    yield number, [float(word) for word in words]
                except ValueError:
                    raise CaseError(f"line {number}: not a row of numbers: {line.strip()[:40]!r}") from None

    def head(self, what: str) -> list[float]:
        """The line that says how many rows of a section follow."""
        line, row = self._next(1, what)
        if not (row[0] >= 0 and row[0] == row[0] // 1):
            raise CaseError(f"line {line}: {row[0]:g} is no number of rows: expected {what}")
        return row

    def section(self, count: float, columns: int, what: str) -> Iterator[tuple[int, list[float]]]:
        """Line and numbers of each row."""
        for _ in range(int(count)):
            yield self._next(columns, what)

    def rest(self) -> bool:
        """Whether there are more rows."""
        return next(self._rows, None) is not None

    def _next(self, columns: int, what: str) -> tuple[int, list[float]]:
        number, row = next(self._rows, (0, []))
        if len(row) < columns:
            where = f"line {number}" if row else "the end of the file"
            raise CaseError(f"{where}: expected {what}")
        return number, row


def read_poly(path: Path) -> Content:
    """The segments of a ``.poly`` file; a boundary marker other than 0 becomes the label of its segment.

    Vertices that the file leaves out are read from the ``.node`` file beside it.

    Raises
    ------
    FileError, CaseError
        With the line.
    """
    rows = Rows(path)
    head = rows.head("the number of vertices")
    vertices = (
        _vertices(rows, head)
        if head[0]
        else _vertices(nodes := Rows(path.with_suffix(".node")), nodes.head("the number of vertices"))
    )
    count, marked, *_ = [*rows.head("the number of segments"), 0.0]
    strokes = []
    for line, (_, begin, end, *marker) in rows.section(count, 3, "a segment: its number and two vertices"):
        name = f"segment in line {line}"
        if begin not in vertices or end not in vertices:
            missing = begin if begin not in vertices else end
            raise CaseError(f"{name}: there is no vertex {missing:g}")
        label = f"{marker[0]:g}" if marked and marker and marker[0] else None
        strokes.append(Stroke(vertices[begin], (LineTo(vertices[end], label),), name))
    holes = [(x, y) for _, (_, x, y, *_) in rows.section(rows.head("the number of holes")[0], 3, "a hole: x and y")]
    notes = ("regions and area limits of the file are not used",) if rows.rest() else ()
    return Content((Feature("the segments", strokes=tuple(strokes)),), notes, tuple(checked(holes, "hole")))


def _vertices(rows: Rows, head: list[float]) -> dict[float, Point]:
    """Vertices by their numbers."""
    found = {}
    for line, (number, x, y, *_) in rows.section(head[0], 3, "a vertex: its number, x and y"):
        (found[number],) = checked([(x, y)], f"vertex in line {line}")
    return found
