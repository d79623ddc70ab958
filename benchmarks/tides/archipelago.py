"""A drawn archipelago in degrees: a mainland with bays, islands of all sizes, a lake, and the depth of the sea."""

import json
from pathlib import Path

import numpy as np
import shapely
from scipy.ndimage import distance_transform_edt

from bubblemesh.arrays import Floats

BOX = (-4.0, 50.0, 0.0, 52.0)
WIDER = 1.6  # a degree of latitude in degrees of longitude
STEP = 0.04  # degrees of latitude between the depths
SHELF, REACH = (6.0, 90.0), 0.4  # depth in metres at the shore and far from it, and degrees in which it gets deeper


def draw(folder: Path, seed: int = 0, islands: int = 60, points: int = 4000) -> None:
    """Write ``shore.geojson``, with so many islands and points on the mainland, and ``depth.asc`` to a folder."""
    land = shore(np.random.default_rng(seed), islands, points)
    features = [
        {"type": "Feature", "properties": {}, "geometry": shapely.geometry.mapping(shapely.set_precision(part, 1e-4))}
        for part in land.geoms
    ]
    (folder / "shore.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    depth = depths(land)
    head = f"ncols {depth.shape[1]}\nnrows {depth.shape[0]}\nxllcenter {BOX[0] - STEP}\nyllcenter {BOX[1] - STEP}\n"
    rows = "\n".join(" ".join(f"{value:.1f}" for value in row) for row in depth[::-1])
    (folder / "depth.asc").write_text(f"{head}cellsize {STEP}\n{rows}\n")


def shore(rng: np.random.Generator, islands: int, points: int) -> shapely.MultiPolygon:
    """Land in degrees: a mainland in the east that ends in the box, islands west of it, and a lake in it."""
    parts = [_island(rng, (0.6, 51.0), 1.1, points)]
    for _ in range(islands):
        size = 10 ** rng.uniform(-2.3, -0.8)
        middle = rng.uniform((BOX[0] + 0.5, BOX[1] + 0.3), (-1.0, BOX[3] - 0.3))
        parts.append(_island(rng, middle, size, max(12, int(points * size / 2))))
    land = shapely.union_all(parts).difference(shapely.Point(-0.3, 51).buffer(0.1))
    return shapely.MultiPolygon([part for part in shapely.get_parts(land) if part.area > 0])


def _island(rng: np.random.Generator, middle: tuple[float, float], size: float, points: int) -> shapely.Polygon:
    """A rough ring around a place."""
    turn = np.linspace(0, 2 * np.pi, points, endpoint=False)[:, None]
    waves = np.arange(2, 40)
    heights = 0.3 * rng.normal(size=len(waves)) / waves**1.3
    radius = size * (1 + (heights * np.cos(waves * turn + rng.uniform(0, 2 * np.pi, len(waves)))).sum(axis=1))
    ring = np.asarray(middle) + np.column_stack([WIDER * radius * np.cos(turn[:, 0]), radius * np.sin(turn[:, 0])])
    return shapely.Polygon(ring).buffer(0)


def depths(land: shapely.MultiPolygon) -> Floats:
    """Depth in metres, which grows with the distance from land, in rows from south to north, a step beyond the box."""
    lon = np.arange(BOX[0] - STEP, BOX[2] + 1.5 * STEP, STEP)
    lat = np.arange(BOX[1] - STEP, BOX[3] + 1.5 * STEP, STEP)[:, None]
    shapely.prepare(land)
    distance = distance_transform_edt(~shapely.contains_xy(land, *np.broadcast_arrays(lon, lat)), (STEP, STEP / WIDER))
    banks = 1 + 0.15 * np.sin(9 * lon + 3 * lat) * np.sin(7 * lat)
    return SHELF[0] + (SHELF[1] - SHELF[0]) * (1 - np.exp(-distance / REACH)) * banks
