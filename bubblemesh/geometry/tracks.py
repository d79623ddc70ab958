"""Nodes on the pieces of a boundary, which are looked up once for all the steps of nodes that move along them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import ROUNDING, Booleans, Floats, Integers
from bubblemesh.geometry.curves import Family


class CurveNodes(NamedTuple):
    """Nodes on curves of one kind."""

    curves: Family
    nodes: Integers | slice  # which of the m nodes
    curve: Integers  # their curves in the family

    @classmethod
    def all_of(cls, families: Sequence[Family], kind: Integers, curve: Integers) -> "tuple[CurveNodes, ...]":
        """Groups of the nodes on the curves ``curve`` (m,) of the families ``kind`` (m,)."""
        if len(families) == 1:
            return (cls(families[0], slice(None), curve),)
        groups = []
        for k, curves in enumerate(families):
            mine = (kind == k).nonzero()[0]
            if len(mine):
                groups.append(cls(curves, slice(None) if len(mine) == len(kind) else mine, curve[mine]))
        return tuple(groups)


class Tracks(NamedTuple):
    """The pieces under m nodes."""

    offset: Floats  # (m,): arc lengths on the curves at which the pieces start
    period: Floats  # (m,): lengths of the whole curves
    length: Floats  # (m,): lengths of the pieces
    closed: Booleans  # (m,): pieces that end where they start
    groups: tuple[CurveNodes, ...]

    def wrapped(self, s: Floats) -> Floats:
        """Arc lengths s (m,) brought back to the pieces: modulo the length of closed ones, else to the ends."""
        return np.where(self.closed, np.mod(s, self.length), np.clip(s, 0, self.length))

    def tangents(self, s: Floats) -> Floats:
        """Unit tangents (m, 2) at arc lengths s (m,) from the starts of the pieces; the domain is on their left."""
        return tangents_of(self.groups, along_curves(self.offset, self.period, s))

    def places(self, s: Floats) -> tuple[Floats, Floats]:
        """Points and unit tangents, both (m, 2), there."""
        along = along_curves(self.offset, self.period, s)
        if len(self.groups) == 1:  # of all nodes
            return self.groups[0].curves.places(self.groups[0].curve, along)
        points, tangents = np.empty((len(s), 2)), np.empty((len(s), 2))
        for curves, nodes, curve in self.groups:
            points[nodes], tangents[nodes] = curves.places(curve, along[nodes])
        return points, tangents


def along_curves(offset: Floats, period: Floats, s: Floats) -> Floats:
    """Arc lengths (m,) on whole curves of lengths ``period`` (m,), of s (m,) from an ``offset`` (m,) on."""
    along = offset + s
    if not (along > period).any():
        return along
    # Only a piece of a split closed curve runs past the end, and none by rounding.
    return np.where(along > (1 + ROUNDING) * period, along - period, np.minimum(along, period))


def points_of(groups: Sequence[CurveNodes], along: Floats) -> Floats:
    """Points (m, 2) of nodes in groups, at arc lengths ``along`` (m,) their curves."""
    if len(groups) == 1:  # of all nodes
        return groups[0].curves.points(groups[0].curve, along)
    result = np.empty((len(along), 2))
    for curves, nodes, curve in groups:
        result[nodes] = curves.points(curve, along[nodes])
    return result


def tangents_of(groups: Sequence[CurveNodes], along: Floats) -> Floats:
    """Unit tangents (m, 2) at nodes in groups, at arc lengths ``along`` (m,) their curves."""
    if len(groups) == 1:
        return groups[0].curves.tangents(groups[0].curve, along)
    result = np.empty((len(along), 2))
    for curves, nodes, curve in groups:
        result[nodes] = curves.tangents(curve, along[nodes])
    return result
