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

    def points(self, s: Floats) -> Floats:
        """Points (m, 2) at arc lengths s (m,) from the starts of the pieces."""
        along, result = self._along(s), np.empty((len(s), 2))
        for curves, nodes, curve in self.groups:
            result[nodes] = curves.points(curve, along[nodes])
        return result

    def tangents(self, s: Floats) -> Floats:
        """Unit tangents (m, 2) there; the domain is on their left."""
        along, result = self._along(s), np.empty((len(s), 2))
        for curves, nodes, curve in self.groups:
            result[nodes] = curves.tangents(curve, along[nodes])
        return result

    def places(self, s: Floats) -> tuple[Floats, Floats]:
        """Points and unit tangents, both (m, 2), there."""
        along = self._along(s)
        points = np.empty((len(s), 2))
        tangents = np.empty((len(s), 2))
        for curves, nodes, curve in self.groups:
            mine = along[nodes]
            points[nodes], tangents[nodes] = curves.points(curve, mine), curves.tangents(curve, mine)
        return points, tangents

    def _along(self, s: Floats) -> Floats:
        """Arc lengths (m,) on the whole curves."""
        along = self.offset + s
        # Only a piece of a split closed curve runs past the end, and none by rounding.
        return np.where(along > (1 + ROUNDING) * self.period, along - self.period, np.minimum(along, self.period))
