"""Directions of columns: fans around corners, normals of curves, and what lies between along a wall."""

from dataclasses import replace

import numpy as np

from bubblemesh.arrays import Booleans, Floats, turned_left
from bubblemesh.layers.columns import Columns
from bubblemesh.layers.ladder import Ladder
from bubblemesh.layers.walls import Walls, rotated

FAN = np.radians(40)  # beyond a straight angle: sharper convex corners have a fan
TIP = np.radians(120)  # the same: around tips and trailing edges one column would leave cells flat
WIDEST = np.radians(30)  # between neighbours in a fan
NARROWEST = np.radians(10)  # the same where the fan is so high that it would become coarse
# A curve's normal counts if it is off the direction halfway by no more than half of the angle between edges, and this.
STRAY = np.radians(2)
HIGHEST_STRETCH = 4.0
BLENDINGS = 20  # passes
BEND = 0.5  # of the shorter edge beside a column: the height within which it bends
SEEN = 0.4  # least cosine between a blended column and the normals beside it


def fan(ladder: Ladder, normal: Floats, angle: float, spacing: float, *, is_corner: bool) -> Floats | None:
    """Directions (k, 2) of the columns around a convex bend, from the wall before it on; None if it has no fan.

    A curve, which is bent only because its nodes are far apart, has no fan but at a tip.
    """
    turn = angle - np.pi
    if turn <= FAN or not ((ladder.fans and is_corner) or turn > TIP):
        return None
    ideal = turn * float(ladder.thickness_below(np.array(spacing))) / spacing
    steps = int(np.clip(np.ceil(ideal), np.ceil(turn / WIDEST), np.ceil(turn / NARROWEST)))
    return rotated(normal[None], -turn * np.arange(steps + 1) / steps)


def on_curves(columns: Columns, walls: Walls, on_curve: Booleans, turns: Floats) -> tuple[Columns, Booleans]:
    """The columns with the normals of the true curves as the directions of those that stand on smooth walls.

    Of those ``on_curve`` (c,), where edges turn by some angle (c,), these are the ones (c,) with a normal about halfway
    between the edges: along a wall that is rough between its nodes the normal at a node says nothing.
    """
    mine = np.flatnonzero(on_curve)
    node, before = columns.foot[mine], _unit(columns.up[mine])
    normal = turned_left(walls.domain.boundary.tangents(walls.node_piece[node], walls.node_s[node]))
    cosine = (normal * before).sum(axis=1)
    sure = np.abs(cosine) >= np.cos(turns[mine] / 2 + STRAY)
    mine, normal = mine[sure], np.sign(cosine[sure])[:, None] * normal[sure]
    foot_up, up, smooth = columns.foot_up.copy(), columns.up.copy(), np.zeros(len(columns), bool)
    foot_up[mine], up[mine], smooth[mine] = normal, normal, True
    return replace(columns, foot_up=foot_up, up=up), smooth


def blended(columns: Columns, free: Booleans, smooth: Booleans, normals: Floats) -> Columns:
    """The columns with directions that change gradually along the wall, where layers are thick beside its edges.

    They turn from the direction at the foot above the first layer, so that its height is the requested one. Heights are
    those above the edges beside a column, or the curve that it stands on, if that is ``smooth``.
    """
    (i, j), normal = columns.pair[columns.apart].T, normals[columns.side[columns.apart]]
    width = columns.bare_widths[columns.apart]
    edge = columns.least_of_pairs(np.where(columns.apart, columns.bare_widths, np.inf))
    rate = np.where(free, 0.5 * np.clip(columns.thickness / edge - 0.25, 0, 1), 0.0)[:, None]
    if not (rate > 0).any():
        return columns
    start = direction = _unit(columns.up)
    ends, others, width = np.append(i, j), np.append(j, i), np.append(width, width)
    for _ in range(BLENDINGS):
        beside = [np.bincount(ends, part[others] / width, minlength=len(columns)) for part in direction.T]
        direction = _unit(direction + rate * (_unit(np.column_stack(beside)) - direction))
    least = np.ones(len(columns))
    total, walls = np.zeros((2, len(columns)))
    for end in (i, j):
        cosine = (normal * direction[end]).sum(axis=1)
        np.minimum.at(least, end, cosine)
        np.add.at(total, end, cosine)
        np.add.at(walls, end, 1)
    mean = np.where(smooth, (direction * start).sum(axis=1), total / np.maximum(walls, 1))
    turned_away = free & (least >= SEEN)
    up = direction / np.clip(mean, 1 / HIGHEST_STRETCH, 1.0)[:, None]
    return replace(columns, up=np.where(turned_away[:, None], up, columns.up), bend=BEND * edge)


def _unit(vectors: Floats) -> Floats:
    """Vectors (n, 2) of length 1, but for those of length 0."""
    return np.asarray(vectors / np.maximum(np.hypot(*vectors.T), 1e-300)[:, None])
