"""What a case asks for and cannot have: warnings, each with its place."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.refinement import Sources
from bubblemesh.spacing.spacing import Spacing

__all__ = ["narrow_walls", "poor_result", "refined_boundary", "sharp_angles"]

SAMPLING = 1 / 64  # of the domain's size, along straight walls
SHARPEST = 5.0  # degrees
POOR_QUALITY = 0.2
FEWEST, MOST = 0.9, 1.15  # nodes in terms of the ideal number
FEW_NODES = 100  # below which the boundary decides the number


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
    parts = np.ceil(line.step / (SAMPLING * domain.size)).astype(int)
    row = np.repeat(np.arange(len(parts)), parts)
    part = np.arange(len(row)) - (np.cumsum(parts) - parts)[row]
    piece, s = line.piece[row], line.s[row] + (part + 0.5) * line.step[row] / parts[row]
    points = boundary.points(piece, s)
    tx, ty = boundary.tangents(piece, s).T
    d = spacing(points)
    normal = d[:, None] * np.column_stack([-ty, tx])
    rays = np.stack([points + 1e-6 * normal, points + normal], axis=1)
    chords = shapely.linestrings(np.stack([line.points, line.points[line.successor]], axis=1))
    ray, chord = shapely.STRtree(chords).query(shapely.linestrings(rays), predicate="intersects")
    mine, other = piece[ray], line.piece[chord]
    joints = np.column_stack([boundary.start, boundary.end])
    joined = (joints[mine][:, :, None] == joints[other][:, None, :]).any(axis=(1, 2))
    along = s[ray]
    apart = np.abs(np.clip(along, line.s[chord], line.s[chord] + line.step[chord]) - along)
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


def poor_result(figures: Mapping[str, Any], ideal_nodes: float) -> list[str]:
    """What the finished mesh falls short of."""
    warnings = []
    worst = figures["quality"]["worst"][0]
    if worst["quality"] < POOR_QUALITY:
        warnings.append(f"the worst triangle, at {_text(worst['at'])}, has a quality of {worst['quality']:.3f} only")
    ratio = figures["nodes"] / ideal_nodes
    if figures["nodes"] > FEW_NODES and not FEWEST <= ratio <= MOST:
        warnings.append(f"the mesh has {ratio:.2f} times the {ideal_nodes:.0f} nodes that the spacing asks for")
    if figures["boundary_nodes"] == figures["nodes"]:
        warnings.append("all nodes are on the boundary: the spacing is too large for a node inside")
    return warnings


def _text(point: Floats | tuple[float, float]) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"
