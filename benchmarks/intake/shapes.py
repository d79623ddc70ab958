"""Shapes that several kinds of files are drawn from: coasts, partitions of them, arcs, and what a file holds."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

Random = np.random.Generator
Shape = Any  # of shapely
STRAIGHT, CURVED = 1e-9, 0.06  # how far, relative, the area of a mesh may be from the file's


class Drawn(NamedTuple):
    """A file that has been drawn, and what is known of it without reading it."""

    path: Path
    size: float  # longer side of the box around it, in the file's lengths
    areas: tuple[float, ...] | None = None  # of its separate parts, the largest first; None if that has no clear answer
    tolerance: float = STRAIGHT
    holds_area: bool = True


def drawn(path: Path, shapes: Iterable[Shape], tolerance: float = STRAIGHT) -> Drawn:
    """A file that holds these polygons; their areas count if they are valid and at most touch in points."""
    parts = [part for shape in shapes for part in polygons_of(shape)]
    bounds = shapely.total_bounds(np.array(parts, dtype=object))
    size = float(max(bounds[2] - bounds[0], bounds[3] - bounds[1]))
    whole = shapely.MultiPolygon(parts)
    areas = tuple(sorted((part.area for part in parts), reverse=True)) if whole.is_valid else None
    return Drawn(path, size, areas, tolerance)


def polygons_of(shape: Shape) -> list[Shape]:
    """Polygons with an area in a shape or collection."""
    parts = shapely.get_parts(shape).tolist()
    if any(part.geom_type == "GeometryCollection" for part in parts):
        return [one for part in parts for one in polygons_of(part)]
    return [part for part in parts if part.geom_type == "Polygon" and part.area > 0]


def coast(random: Random, cells: int = 64, rough: float = 1.7, sea: float = 0.25) -> list[Shape]:
    """Islands with lakes, and islands in those, within the unit square: a contour of noise of all wavelengths."""
    from contourpy import FillType, contour_generator

    waves = np.hypot(*np.meshgrid(*[np.fft.fftfreq(cells, 1 / cells)] * 2))
    waves[0, 0] = np.inf
    phases = np.exp(2j * np.pi * random.random((cells, cells)))
    height = np.fft.ifft2(phases * waves**-rough).real
    height /= height.std()
    x, y = np.meshgrid(*[np.linspace(-1, 1, cells)] * 2)
    height -= sea + 5 * np.maximum(np.hypot(x, y) - 0.55, 0)
    height[[0, -1], :] = height[:, [0, -1]] = -9
    at = np.linspace(0, 1, cells)
    points, offsets = contour_generator(at, at, height, fill_type=FillType.OuterOffset).filled(0, np.inf)
    islands = []
    for ring, offset in zip(points, offsets, strict=True):
        outer, *holes = (ring[a:b] for a, b in pairwise(offset.tolist()))
        islands.append(shapely.Polygon(outer, holes))
    return sorted((one for one in islands if one.is_valid), key=lambda one: -one.area)


def rough_line(random: Random, a: Sequence[float], b: Sequence[float], levels: int, amplitude: float) -> Shape:
    """Points (n, 2) of a border from a to b, whose middles are moved aside again and again."""
    points = np.array([a, b], float)
    for _ in range(levels):
        step = np.diff(points, axis=0)
        aside = step[:, ::-1] * [-1, 1] * random.uniform(-amplitude, amplitude, (len(step), 1))
        middles = points[:-1] + step / 2 + aside
        points = np.insert(points, np.arange(1, len(points)), middles, axis=0)
    return points


def partition(random: Random, outline: Shape, count: int, levels: int = 3) -> list[Shape]:
    """Neighbours that fill an outline and share their borders exactly."""
    inside = shapely.points(random.uniform(*np.array(outline.bounds).reshape(2, 2), (count, 2)))
    cells = shapely.voronoi_polygons(shapely.MultiPoint(inside), extend_to=outline)
    borders = shapely.unary_union([cell.boundary for cell in cells.geoms])
    borders = shapely.intersection(shapely.line_merge(borders), outline)
    expected = len(polygons_of(shapely.polygonize([shapely.unary_union([borders, outline.boundary])])))
    faces: list[Shape] = []
    for amplitude in (0.15, 0.05, 0):
        moved = [
            shapely.LineString(rough_line(random, ends[0], ends[1], levels, amplitude))
            for line in shapely.get_parts(borders)
            for ends in pairwise(line.coords)
        ]
        edges = shapely.unary_union([*(shapely.intersection(line, outline) for line in moved), outline.boundary])
        faces = [face for face in polygons_of(shapely.polygonize([edges])) if outline.contains(face.point_on_surface())]
        if len(faces) == expected:
            break
    return faces


def moved(shape: Shape, scale: float | tuple[float, float], to: Sequence[float], digits: int | None = None) -> Shape:
    """The shape times a scale, moved, with so many decimals as files have; it may become invalid by that."""

    def place(points: Any) -> Any:
        points = points * scale + np.array(to)
        return points if digits is None else np.round(points, digits)

    return shapely.transform(shape, place)


def loop(random: Random, count: int, rough: float = 0.2, lobes: int = 5) -> Any:
    """Points (count, 2) of a closed smooth curve of about the unit circle's size, without the first at its end."""
    angle = np.arange(count) * 2 * np.pi / count
    radius = np.ones(count)
    for k in range(2, 2 + lobes):
        radius += rough / k * np.cos(k * angle + random.uniform(0, 2 * np.pi))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
