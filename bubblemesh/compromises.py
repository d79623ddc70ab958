"""What a case asks for and cannot have: warnings, each with its place."""

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.refinement import Sources
from bubblemesh.spacing.spacing import Spacing

__all__ = ["narrow_walls", "refined_boundary", "sharp_angles"]

SHARPEST = 5.0  # degrees


def sharp_angles(domain: Domain) -> list[str]:
    """Corners whose interior angle is so small that the triangles there cannot be good."""
    boundary = domain.boundary
    open_ = np.flatnonzero(~boundary.closed)
    begin = boundary.tangents(open_, np.zeros(len(open_)))
    end = boundary.tangents(open_, boundary.lengths[open_])
    follower = {(boundary.ring[p], boundary.start[p]): k for k, p in enumerate(open_.tolist())}
    after = np.array([follower[boundary.ring[p], boundary.end[p]] for p in open_.tolist()], int)
    back, ahead = -end, begin[after]
    angle = np.degrees(
        np.arctan2(ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0], (ahead * back).sum(axis=1)) % (2 * np.pi)
    )
    sharp = np.flatnonzero(angle < SHARPEST)
    places = boundary.corners[boundary.end[open_[sharp]]]
    return [
        f"the angle at {_text(place)} is {a:.2g} degrees: triangles there are as sharp"
        for place, a in zip(places, angle[sharp], strict=True)
    ]


def narrow_walls(domain: Domain, spacing: Spacing) -> list[str]:
    """Places where the domain is narrower than the spacing."""
    line, boundary = domain.polyline, domain.boundary
    middle = line.s + line.step / 2
    points = boundary.points(line.piece, middle)
    tx, ty = boundary.tangents(line.piece, middle).T
    d = spacing(points)
    rays = np.stack([points, points + d[:, None] * np.column_stack([-ty, tx])], axis=1)
    chords = shapely.linestrings(np.stack([line.points, line.points[line.successor]], axis=1))
    ray, chord = shapely.STRtree(chords).query(shapely.linestrings(rays), predicate="intersects")
    mine, other = line.piece[ray], line.piece[chord]
    joints = np.column_stack([boundary.start, boundary.end])
    joined = (joints[mine][:, :, None] == joints[other][:, None, :]).any(axis=(1, 2))
    apart = np.abs(line.s[chord] - line.s[ray])
    apart = np.where(boundary.closed[mine], np.minimum(apart, boundary.lengths[mine] - apart), apart)
    opposite = np.where(mine == other, apart > np.pi / 2 * d[ray], ~joined)
    ray, chord = ray[opposite], chord[opposite]
    if len(ray) == 0:
        return []
    width = shapely.distance(shapely.points(points[ray]), chords[chord])
    worst = int(np.argmin(width / d[ray]))
    return [
        f"the domain is {width[worst]:.3g} wide at {_text(points[ray[worst]])}, narrower than the spacing there "
        f"({d[ray[worst]]:.3g}): only boundary nodes fit"
    ]


def refined_boundary(short: Sources, coarse: Sources) -> list[str]:
    """Where short edges and tight curves made the spacing finer."""
    warnings = []
    if len(short):
        k = int(short.sizes.argmin())
        warnings.append(
            f"{len(short) // 2} boundary edges are shorter than the spacing, the shortest ({short.sizes[k]:.3g}) at "
            f"{_text(short.points[k])}: the mesh is finer around them"
        )
    if len(coarse):
        k = int(coarse.sizes.argmin())
        warnings.append(
            f"the spacing is too coarse for the curve at {_text(coarse.points[k])}: it is reduced to "
            f"{coarse.sizes[k]:.3g} there"
        )
    return warnings


def _text(point: Floats) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"
