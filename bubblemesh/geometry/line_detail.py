"""Lines with fewer vertices: those of straight sides that are not needed within a tolerance."""

from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from itertools import chain, pairwise
from typing import NamedTuple

import shapely

from bubblemesh.geometry.paths import Line, OpenPath, Point, Ring, Side, as_point

Points = tuple[Point, ...]


class StraightRun(NamedTuple):
    """Straight sides of a line with one label, from the side ``begin`` to before the side ``end``, through points."""

    begin: int
    end: int
    points: Points

    @property
    def key(self) -> Points:
        """The points, in the same order if another line runs the other way."""
        return min(self.points, self.points[::-1])


def simplified_lines(
    lines: Sequence[OpenPath], tolerances: Sequence[float], rings: Sequence[Ring], stay: Set[Point]
) -> list[OpenPath]:
    """The lines without vertices that are no farther from what is left of them than a tolerance, 0 for none.

    The algorithm of Ramer, Douglas and Peucker, between ends of lines, changes of the label, curves and the vertices in
    ``stay``. What lines have in common stays so, and nothing crosses afterwards that did not before. The first line
    with fewer vertices has a note.
    """
    runs = [list(_runs(line, stay)) if tolerances[k] > 0 else [] for k, line in enumerate(lines)]
    found = list(lines)
    for tolerance in sorted({tolerances[k] for k, some in enumerate(runs) if some}):
        mine = [k for k, some in enumerate(runs) if some and tolerances[k] == tolerance]
        others = [line for k, line in enumerate(found) if k not in set(mine)]
        sparse = _sparser(list(chain(*(runs[k] for k in mine))), tolerance, _obstacles(others, rings))
        for k in mine:
            found[k] = _along(lines[k], runs[k], sparse)
    given, left = (sum(len(line.vertices) for line in some) for some in (lines, found))
    if left < given:
        first = next(k for k, line in enumerate(found) if len(line.vertices) < len(lines[k].vertices))
        note = f"{given - left:,} of {given:,} vertices of lines left out (simplify)"
        found[first] = replace(found[first], notes=(*found[first].notes, note))
    return found


def _runs(line: OpenPath, stay: Set[Point]) -> Iterator[StraightRun]:
    """The runs of a line that have vertices to leave out."""
    sides = line.sides
    straight = [isinstance(side.curve, Line) for side in sides]
    inner = [
        k
        for k in range(1, len(sides))
        if line.vertices[k] in stay or sides[k].label != sides[k - 1].label or not (straight[k] and straight[k - 1])
    ]
    for begin, end in pairwise([0, *inner, len(sides)]):
        if straight[begin] and end - begin > 1:
            yield StraightRun(begin, end, line.vertices[begin : end + 1])


def _obstacles(lines: Sequence[OpenPath], rings: Sequence[Ring]) -> shapely.STRtree:
    """The rings, and lines whose vertices stay."""
    loops = [shapely.LinearRing(ring.outline) for ring in rings]
    return shapely.STRtree([*loops, *(shapely.LineString(line.vertices) for line in lines if line.vertices)])


def _sparser(runs: Sequence[StraightRun], tolerance: float, obstacles: shapely.STRtree) -> dict[Points, Points]:
    """The points that are left of each run, by its key; runs that would cross obstacles anew stay as they are."""
    keys = list(dict.fromkeys(run.key for run in runs))
    given = list(map(shapely.LineString, keys))
    sparse = shapely.get_parts(shapely.simplify(shapely.MultiLineString(given), tolerance))
    crossed = [[set(obstacles.query(line, predicate="crosses").tolist()) for line in some] for some in (given, sparse)]
    return {
        key: tuple(map(as_point, shapely.get_coordinates(line))) if after <= before else key
        for key, line, before, after in zip(keys, sparse, *crossed, strict=True)
    }


def _along(line: OpenPath, runs: Sequence[StraightRun], sparse: dict[Points, Points]) -> OpenPath:
    """The line with the points that are left of its runs."""
    sides, vertices, done = list[Side](), list(line.vertices[:1]), 0
    for run in runs:
        points = sparse[run.key] if run.key == run.points else sparse[run.key][::-1]
        sides += line.sides[done : run.begin]
        vertices += line.vertices[done + 1 : run.begin + 1]
        sides += [Side(Line(*ends), line.sides[run.begin].label) for ends in pairwise(points)]
        vertices += points[1:]
        done = run.end
    return replace(line, sides=(*sides, *line.sides[done:]), vertices=(*vertices, *line.vertices[done + 1 :]))
