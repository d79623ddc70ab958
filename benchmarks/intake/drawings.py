"""Drawings as CAD programs write them: parts of lines, arcs, polylines, splines, fills and blocks, and more."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from benchmarks.intake.shapes import CURVED, Drawn, Random, Shape, drawn, loop

Space = Any  # of ezdxf
OUTLINE = {"layer": "OUTLINE"}
QUARTER = np.tan(np.pi / 8)  # bulge of a quarter of a circle


def _rounded(space: Space, x: float, y: float, w: float, h: float, r: float, **how: Any) -> Shape:
    """A rectangle with round corners as one polyline."""
    points = [
        (x + r, y, 0),
        (x + w - r, y, QUARTER),
        (x + w, y + r, 0),
        (x + w, y + h - r, QUARTER),
        (x + w - r, y + h, 0),
        (x + r, y + h, QUARTER),
        (x, y + h - r, 0),
        (x, y + r, QUARTER),
    ]
    space.add_lwpolyline(points, format="xyb", close=True, dxfattribs=how)
    return shapely.box(x + r, y + r, x + w - r, y + h - r).buffer(r, 64)


def _slot(space: Space, x: float, y: float, length: float, r: float, **how: Any) -> Shape:
    """A slot of two lines and two arcs."""
    space.add_line((x, y - r), (x + length, y - r), how)
    space.add_arc((x + length, y), r, -90, 90, dxfattribs=how)
    space.add_line((x + length, y + r), (x, y + r), how)
    space.add_arc((x, y), r, 90, 270, dxfattribs=how)
    return shapely.LineString([(x, y), (x + length, y)]).buffer(r, 64)


def _rectangle(space: Space, w: float, h: float, gap: float = 0, **how: Any) -> Shape:
    """A rectangle of four lines in any order, whose ends may miss each other by a gap."""
    corners = [(0, 0), (w, 0), (w, h), (0, h)]
    for k in (2, 0, 3, 1):
        a, b = corners[k], corners[(k + 1) % 4]
        space.add_line(a if k % 2 else b, (b[0] + gap, b[1]) if k % 2 else (a[0], a[1] + gap), how)
    return shapely.box(0, 0, w, h)


def _bores(space: Space, random: Random, w: float, h: float, count: int = 3) -> Shape:
    """Bores in a row."""
    bores = []
    for k in range(count):
        at, r = (w * (k + 1) / (count + 1), h / 2), random.uniform(0.05, 0.2) * min(h, w / count)
        space.add_circle(at, r, dxfattribs={"layer": "BORES"})
        bores.append(shapely.Point(at).buffer(r, 64))
    return shapely.union_all(bores)


def _plate(space: Space, random: Random, w: float, h: float) -> Any:
    return [_rounded(space, 0, 0, w, h, 0.1 * h, **OUTLINE) - _bores(space, random, w, h)]


def _slotted(space: Space, random: Random, w: float, h: float) -> Any:
    slots = [_slot(space, 0.2 * w, y * h, 0.5 * w, 0.08 * h, **OUTLINE) for y in (0.3, 0.7)]
    return [_rectangle(space, w, h, **OUTLINE) - shapely.union_all(slots)]


def _gaps(space: Space, random: Random, w: float, h: float) -> Any:
    _rectangle(space, w, h, 2e-4 * w, **OUTLINE)
    return None


def _double(space: Space, random: Random, w: float, h: float) -> Any:
    _rectangle(space, w, h, **OUTLINE)
    return [_rectangle(space, w, h, layer="COPY") - _bores(space, random, w, h, 1)]


def _overlapping_lines(space: Space, random: Random, w: float, h: float) -> Any:
    space.add_line((0, 0), (0.6 * w, 0), OUTLINE)
    space.add_line((0.4 * w, 0), (w, 0), OUTLINE)
    for a, b in (((w, 0), (w, h)), ((w, h), (0, h)), ((0, h), (0, 0))):
        space.add_line(a, b, OUTLINE)
    return [shapely.box(0, 0, w, h)]


def _splined(space: Space, random: Random, w: float, h: float) -> Any:
    points = loop(random, 12, 0.1, 3) * [w / 3, h / 3] + [w / 2, h / 2]
    space.add_spline([*points.tolist(), points[0].tolist()], dxfattribs=OUTLINE)
    space.add_ellipse((w / 2, h / 2), (0.1 * w, 0), 0.5, dxfattribs=OUTLINE)
    return [shapely.Polygon(points) - shapely.Polygon(0.1 * w * loop(random, 64, 0) * [1, 0.5] + [w / 2, h / 2])]


def _hatched(space: Space, random: Random, w: float, h: float) -> Any:
    hatch = space.add_hatch(color=2, dxfattribs={"layer": "HATCH"})
    hatch.paths.add_polyline_path([(0, 0), (w, 0), (w, h), (0, h)], is_closed=True, flags=1)
    hatch.paths.add_polyline_path([(0.3 * w, 0.3 * h, 1), (0.5 * w, 0.3 * h, 1)], is_closed=True, flags=16)
    return [shapely.box(0, 0, w, h) - shapely.Point(0.4 * w, 0.3 * h).buffer(0.1 * w, 64)]


def _arrayed(space: Space, random: Random, w: float, h: float) -> Any:
    block = space.doc.blocks.new("BORE")
    block.add_circle((0, 0), 1)
    r = 0.03 * min(w, h)
    keys = {"xscale": r, "yscale": r, "layer": "BORES"}
    keys |= {"column_count": 4, "row_count": 3, "column_spacing": w / 5, "row_spacing": h / 4}
    space.add_blockref("BORE", (w / 5, h / 4), keys)
    bores = [shapely.Point(w * i / 5, h * j / 4).buffer(r, 64) for i in range(1, 5) for j in range(1, 4)]
    return [_rectangle(space, w, h, **OUTLINE) - shapely.union_all(bores)]


def _several(space: Space, random: Random, w: float, h: float) -> Any:
    parts = []
    for k in range(int(random.integers(2, 5))):
        parts.append(_rounded(space, 1.2 * k * w, 0, w * (1 - 0.1 * k), h, 0.05 * h, **OUTLINE))
    return parts


def _annotated(space: Space, random: Random, w: float, h: float) -> Any:
    part = _plate(space, random, w, h)
    space.add_text("PLATE 3 mm", dxfattribs={"layer": "TEXT"}).set_placement((0.1 * w, 1.1 * h))
    space.add_mtext("all edges broken", dxfattribs={"layer": "TEXT"})
    space.add_linear_dim((0, -0.2 * h), (0, 0), (w, 0), dxfattribs={"layer": "DIM"}).render()
    for k in range(3):
        at = w * (k + 1) / 4
        space.add_line((at, 0.2 * h), (at, 0.8 * h), {"layer": "CENTER", "linetype": "CENTER"})
    return part


def _titled(space: Space, random: Random, w: float, h: float) -> Any:
    part = _plate(space, random, w, h)
    frame = {"layer": "FRAME"}
    space.add_lwpolyline([(-w, -h), (2 * w, -h), (2 * w, 2 * h), (-w, 2 * h)], close=True, dxfattribs=frame)
    for k in range(3):
        space.add_line((w, -h + 0.1 * k * h), (2 * w, -h + 0.1 * k * h), frame)
    space.add_line((w, -h), (w, -0.8 * h), frame)
    return part


def _old_polyline(space: Space, random: Random, w: float, h: float) -> Any:
    points = [(0, 0, 2.5), (w, 0, 2.5), (w, h, 2.5), (0.5 * w, 0.7 * h, 2.5), (0, h, 2.5)]
    space.add_polyline3d(points, close=True)
    return [shapely.Polygon([point[:2] for point in points])]


def _mirrored_block(space: Space, random: Random, w: float, h: float) -> Any:
    block = space.doc.blocks.new("HALF")
    block.add_lwpolyline([(0, 0, 0), (w / 2, 0, 0), (w / 2, h, 0.3), (0, h, 0)], format="xyb")
    for factor in (1, -1):
        space.add_blockref("HALF", (0, 0), {"xscale": factor})
    return None


def _contours(space: Space, random: Random, w: float, h: float) -> Any:
    rings = [loop(random, 80, 0.1) * size for size in (w, 0.6 * w, 0.3 * w)]
    for ring in rings:
        space.add_lwpolyline(ring.tolist(), close=True, dxfattribs=OUTLINE)
    return [shapely.Polygon(rings[0], [rings[1]]), shapely.Polygon(rings[2])]


FORMS: tuple[Callable[[Space, Random, float, float], Any], ...] = (
    _plate,
    _slotted,
    _gaps,
    _double,
    _splined,
    _hatched,
    _arrayed,
    _several,
    _annotated,
    _titled,
    _old_polyline,
    _mirrored_block,
    _contours,
    _overlapping_lines,
)


def drawing(folder: Path, number: int, random: Random) -> Drawn:
    """A drawing of one of the forms, in one of the versions of the format."""
    import ezdxf

    path = folder / f"drawing-{number:02}.dxf"
    document = ezdxf.new(["R12", "R2000", "R2010", "R2018"][1 + number % 3], setup=True, units=4)
    w = float(random.choice([1, 40, 210, 3000]))
    h = w * random.uniform(0.4, 1)
    areas = FORMS[number % len(FORMS)](document.modelspace(), random, w, h)
    document.saveas(path)
    return Drawn(path, w) if areas is None else drawn(path, areas, CURVED)._replace(size=w)
