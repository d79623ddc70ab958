"""Lines with a vertex far outside of the domain, as one with a wrong digit has: most of their length is left out.

Lines may go on outside, as rivers of a file do, come back, as a horizon across a valley, or be drawn far beyond the
domain to cut it from side to side. Told are those with a straight way far out and back, or far out from inside.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.geometry.arrangement.clipping import length_inside
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import OpenPath
from bubblemesh.messages import place

FAR_OUTSIDE = 1.0  # of the domain's size: vertices farther from its box are far outside
FAR_END = 10.0  # likewise, of the end of a line: it may be drawn to some length
BACK = -0.9  # cosine of the angle between the ways out and back


def leap_notes(lines: Sequence[OpenPath], polygon: shapely.Polygon | shapely.MultiPolygon) -> Iterator[str]:
    """Notes on lines with a vertex far outside of a domain, with its place and the share of a line that is outside."""
    every = np.array([vertex for line in lines for vertex in line.vertices]).reshape(-1, 2)
    low, high = np.reshape(polygon.bounds, (2, 2))
    size = float((high - low).max())
    from_box = np.maximum(low - every, every - high).max(axis=1) / size
    if (from_box <= FAR_OUTSIDE).all():
        return
    ends = np.cumsum([len(line.vertices) for line in lines])[:-1]
    for line, vertices, away in zip(lines, np.split(every, ends), np.split(from_box, ends), strict=True):
        if (away <= FAR_OUTSIDE).all() or line.vertices[0] == line.vertices[-1]:
            continue
        if (spike := _spike(vertices, away, size)) is not None:
            yield f"{_told(line, vertices[spike], polygon)}, where the line comes back: is a coordinate wrong?"
        elif (end := _far_end(away, shapely.intersects_xy(polygon, vertices[[0, -1]]))) is not None:
            yield f"{_told(line, vertices[end], polygon)}, where it ends: is a coordinate wrong?"


def _spike(vertices: Floats, away: Floats, size: float) -> int | None:
    """Number of the farthest vertex (n, 2) between two sides on which a line goes far out and back again, if any.

    ``away`` (n,) are the distances of the vertices from the domain's box, in its ``size``.
    """
    far, steps = away > FAR_OUTSIDE, np.diff(vertices, axis=0)
    lengths = np.hypot(*steps.T)
    outward, inward = np.flatnonzero(~far[:-1] & far[1:]), np.flatnonzero(far[:-1] & ~far[1:])
    for out in outward.tolist():
        for back in inward[inward > out][:1].tolist():
            straight = min(lengths[out], lengths[back]) > FAR_OUTSIDE * size
            if straight and steps[out] @ steps[back] < BACK * lengths[out] * lengths[back]:
                return out + 1 + int(np.argmax(away[out + 1 : back + 1]))
    return None


def _far_end(away: Floats, inside: Booleans) -> int | None:
    """Number of the end of a line that lies far outside while the other one is ``inside`` (2,) the domain, if any.

    Many sides are as long together as one with a wrong digit: of a river, which may be that long.
    """
    if inside[0] and away[-1] > FAR_END and away[-2] <= FAR_OUTSIDE:
        return -1
    return 0 if inside[1] and away[0] > FAR_END and away[1] <= FAR_OUTSIDE else None


def _told(line: OpenPath, at: Floats, polygon: shapely.Polygon | shapely.MultiPolygon) -> str:
    """How much of a line is outside, and to which place it goes."""
    curves = Boundary.empty().with_inner([line])
    share = 1 - length_inside(curves, polygon) / float(curves.lengths.sum())
    return f"the line {line.name} is outside of the domain with {share:.3%} of its length, as far as {place(at)}"
