"""Polygons with the faults that digitizing and conversion leave: each bounds an area, but not in a valid way."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from benchmarks.intake.maps import feature, write_geojson
from benchmarks.intake.shapes import Drawn, Random, loop

Rings = list[Any]  # points (n, 2) of the outer ring and of holes


def _crossing(random: Random, ring: Any) -> list[Rings]:
    """Two neighbours in the wrong order."""
    k = int(random.integers(5, len(ring) - 5))
    ring[[k, k + 1]] = ring[[k + 1, k]]
    return [[ring]]


def _bow_tie(random: Random, ring: Any) -> list[Rings]:
    return [[np.array([(0, 0), (2, random.uniform(0.5, 2)), (2, 0), (0, random.uniform(0.5, 2))])]]


def _touching(random: Random, ring: Any) -> list[Rings]:
    """A vertex on another one of the same ring."""
    ring[3 * len(ring) // 4] = ring[len(ring) // 4]
    return [[ring]]


def _spike(random: Random, ring: Any) -> list[Rings]:
    k = int(random.integers(len(ring)))
    return [[np.insert(ring, k + 1, [1.5 * ring[k], ring[k]], axis=0)]]


def _near_spike(random: Random, ring: Any) -> list[Rings]:
    k = int(random.integers(len(ring)))
    return [[np.insert(ring, k + 1, [1.5 * ring[k], ring[k] * (1 + 1e-7)], axis=0)]]


def _crossing_hole(random: Random, ring: Any) -> list[Rings]:
    return [[ring, 0.4 * ring + 0.8 * ring[0]]]


def _touching_hole(random: Random, ring: Any) -> list[Rings]:
    return [[ring, 0.3 * ring + 0.7 * ring[0]]]


def _hole_outside(random: Random, ring: Any) -> list[Rings]:
    return [[ring, 0.2 * ring + [3, 0]]]


def _same_twice(random: Random, ring: Any) -> list[Rings]:
    return [[ring], [ring]]


def _overlapping(random: Random, ring: Any) -> list[Rings]:
    return [[ring], [np.add(ring, (0.7, 0.1))]]


def _sliver(random: Random, ring: Any) -> list[Rings]:
    right = ring[:, 0].max()
    return [[ring], [np.array([(right + 1, -1), (right + 1.000001, 1), (right + 1.000002, -1)])]]


def _twice_around(random: Random, ring: Any) -> list[Rings]:
    return [[np.concatenate([ring, 0.9 * ring])]]


def _common_edge(random: Random, ring: Any) -> list[Rings]:
    """A hole with an edge on the outer ring."""
    return [[np.array([(0, 0), (4, 0), (4, 3), (0, 3)]), np.array([(1, 0), (2, 0), (2, 1), (1, 1)])]]


def _cut_in(random: Random, ring: Any) -> list[Rings]:
    """A hole joined to the outer ring by a cut there and back."""
    inner = 0.4 * ring[::-1]
    return [[np.concatenate([ring, ring[:1], np.roll(inner, 1, axis=0), inner[-1:]])]]


FAULTS: tuple[Callable[[Random, Any], list[Rings]], ...] = (
    _crossing,
    _bow_tie,
    _touching,
    _spike,
    _near_spike,
    _crossing_hole,
    _touching_hole,
    _hole_outside,
    _same_twice,
    _overlapping,
    _sliver,
    _twice_around,
    _common_edge,
    _cut_in,
)


def faulty(folder: Path, number: int, random: Random) -> Drawn:
    """A file with one fault, as GeoJSON or WKT; areas count where nothing of it is to be repaired."""
    ring = loop(random, int(random.integers(24, 90)), 0.15)
    parts = FAULTS[number % len(FAULTS)](random, ring)
    loops = [[[*map(tuple, one.tolist()), tuple(one[0].tolist())] for one in rings] for rings in parts]
    shape = shapely.MultiPolygon([(outer, holes) for outer, *holes in loops])
    shape = shape if len(parts) > 1 else shape.geoms[0]
    if number // len(FAULTS) % 2:
        path = folder / f"faulty-{number:02}.wkt"
        path.write_text(shapely.to_wkt(shape, rounding_precision=-1))
    else:
        path = write_geojson(folder / f"faulty-{number:02}.geojson", [feature(shape, name="site")])
    every = np.concatenate([one for rings in parts for one in rings])
    return Drawn(path, float(np.ptp(every, axis=0).max()))


def lines(folder: Path, number: int, random: Random) -> Drawn:
    """Lines that together bound an area: they meet, or miss each other by little; some files hold open lines only."""
    ring = loop(random, 60, 0.15)
    form = number % 4
    gap = (0, 1e-4, 0, 0)[form]
    pieces = [np.vstack([ring[a : a + 20], ring[(a + 20) % 60] + gap]) for a in (0, 20, 40)]
    pieces = pieces[:2] if form == 3 else pieces
    path = folder / f"lines-{number:02}.geojson"
    shapes = [shapely.LineString(piece) for piece in pieces]
    if form == 2:
        path.write_text(json.dumps(shapely.geometry.mapping(shapely.MultiLineString(shapes))))
    else:
        write_geojson(path, [feature(shape, kind="edge") for shape in shapes])
    areas = (shapely.Polygon(ring).area,) if form in (0, 2) else None
    return Drawn(path, float(np.ptp(ring, axis=0).max()), areas, holds_area=form != 3)
