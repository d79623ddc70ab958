"""Areas of a file: its rings as they are nested, and the choice of some of them by a case."""

from collections.abc import Sequence

import numpy as np
import shapely

from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry.nesting import Shapes, nested, shapes_of
from bubblemesh.geometry.paths import Area, Point, Ring
from bubblemesh.geometry.repair import Repair
from bubblemesh.geometry.validity import first_place
from bubblemesh.messages import MOST_NAMES, place
from bubblemesh.readers.selection import PartChoice


def areas_by_nesting(areas: Sequence[Area], loose: Sequence[Ring], marks: Sequence[Point] | None) -> list[Area]:
    """The areas of a file, and those that its other rings bound by their nesting.

    If the file has ``marks``, points in holes, GeometryError for a hole without a mark and a mark outside of all holes.
    """
    if not loose and len(areas) == 1:
        return list(areas)
    found = nested([*areas, *(Area(ring) for ring in loose)], whole=len(areas))
    if marks is not None:
        _require_marks(found, marks)
    return found


def _require_marks(areas: Sequence[Area], marks: Sequence[Point]) -> None:
    """Check that each hole has a mark, and each mark is in a hole."""
    holes = shapes_of([Area(hole) for area in areas for hole in area.holes])
    solid, points = shapes_of(areas), shapely.points(np.array(marks, float).reshape(-1, 2))
    marked = np.zeros(len(holes), bool)
    if len(holes):
        marked[shapely.STRtree(points).query(holes, predicate="contains")[0]] = True
    for hole in holes[~marked]:
        raise GeometryError(
            f"the ring at {first_place(hole)} has no hole point in it: it would part the domain into regions"
        )
    for point in points:
        inside = shapely.contains(solid, point).any()
        if inside or not shapely.contains(holes, point).any():
            where = "in no hole, but in the area itself" if inside else "outside the outer ring"
            raise GeometryError(f"the hole point {place(point.coords[0])} is {where}: move or remove it")


def chosen_areas(areas: Sequence[Area], part: PartChoice | None) -> list[Area]:
    """The areas of a part, largest first; GeometryError if none is given and there are several."""
    if part is None and len(areas) == 1:
        return list(areas)
    shapes = shapes_of(areas)
    order = np.argsort(-shapely.area(shapes), kind="stable").tolist()
    ordered = [areas[k] for k in order]
    if part == "all":
        return ordered
    number = 0 if part == "largest" else part
    if number is not None and number < len(areas):
        return [ordered[number]]
    parts = [
        f"{k}: area {shape.area:.6g} at {first_place(shape)}" + (f", {area.outer.origin}" if area.outer.origin else "")
        for k, (area, shape) in enumerate(zip(ordered[:MOST_NAMES], shapes[order], strict=False))
    ]
    more = f"; and {len(order) - MOST_NAMES} smaller ones" if len(order) > MOST_NAMES else ""
    listed = f"parts are {'; '.join(parts)}{more}"
    first, all_ = _beside(shapes[order[:1]]), _beside(shapes)
    if number is not None:
        raise CaseError(f"it has no part {number}: give a number from 0 to {len(areas) - 1}; {listed}")
    raise GeometryError(
        f"{len(areas)} separate areas are in it: choose by part: largest{first}, part: all{all_} for a mesh of "
        f"separate pieces, or part: N, or by feature or layer; {listed}",
        mendable=not _apart(shapes),
    )


def _apart(shapes: Shapes) -> bool:
    """Whether a repair would change none of the shapes: all are valid, and none are close enough to be united."""
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    i, j = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=Repair().gap_of(max(x1 - x0, y1 - y0)))
    return bool(shapely.is_valid(shapes).all() and (i == j).all())


def _beside(shapes: Shapes) -> str:
    """The key that is needed in addition to a choice of shapes, if their rings cross or they overlap; else empty."""
    i, j = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    return "" if shapely.is_valid(shapes).all() and (i == j).all() else " and repair: true"
