"""Columns of layers: where they stand, and in which directions they go up from the wall."""

from functools import cached_property

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.layers.ladder import Ladder
from bubblemesh.records import record

LARGEST_RATIO = 1.7  # of the heights of the same layer on neighbours: with a lower one many are low beside a gap
RISE = 0.15  # of the first height along the wall, at most: so steep that there is room for a few layers of that height
NEARLY = 0.05  # relative difference of a first height from the requested one
LEAST_BEND = 1e-3  # by which columns come nearer for each unit of height: less is a straight wall


@record
class Columns:
    """Columns of layers, before their heights are known, and the pairs of them that have cells between.

    A column goes up in a straight line, but for a bend at its foot, or along a piece of the boundary without layers.
    """

    ladders: tuple[Ladder, ...]
    foot: Integers  # (c,): node of the wall
    start: Floats  # (c, 2): its place
    at: Floats  # (c, 2): where the column would start if it were straight: elsewhere for one with nodes of several
    foot_up: Floats  # (c, 2): way at the foot over height above the wall
    up: Floats  # (c, 2): the same above the bend
    bend: Floats  # (c,): height above the first layer within which it bends
    ladder: Integers  # (c,)
    follows: Integers  # (c,): piece that the column follows, -1 for none
    from_start: Booleans  # (c,): whether it follows the piece from its start, rather than from its end
    ends: Booleans  # (c,): whether there is no layer at the foot, since the wall beside it has none
    spacing: Floats  # (c,): at the foot
    pair: Integers  # (p, 2): columns with cells between, the wall being on the right of the way from one to the other
    side: Integers  # (p,): of the wall between their feet, or before a fan
    fan: Booleans  # (p,): whether both stand on one node
    twins: Integers  # (k, 2): columns that are equally high: on periodic sides that match, or with the same nodes
    owner: Integers  # (c,): column whose nodes it has from ``joined`` on: itself, or the first at a bend of short edges
    joined: Integers  # (c,): number of the layer from which on it has nodes in common with others, 0 if it has none
    leader: Integers  # (c,): the first of the columns on the same short edges, itself elsewhere
    pinch: Booleans  # (p,): whether both have nodes in common

    def __len__(self) -> int:
        return len(self.foot)

    def places(self, which: Integers, height: Floats, layer: Integers) -> Floats:
        """Places (k, 2) on columns (k,) at heights (k,) above the wall in a ``layer`` (k,), if they follow no piece."""
        joined, height = self.joined[which], height[:, None]
        alone, common = layer < joined, (joined > 0) & (layer >= joined)
        bent = np.clip((height[:, 0] - self.first[which]) / self.bend[which], 0, 1)
        bent = np.where(common, 1.0, np.where(alone, 0.0, bent))[:, None]
        begin = np.where(alone[:, None], self.start[which], self.at[which])
        return begin + height * ((1 - bent) * self.foot_up[which] + bent * self.up[which])

    @property
    def apart(self) -> Booleans:
        """Mask (p,) of the pairs that stand on two nodes, and have no nodes in common."""
        return ~(self.fan | self.pinch)

    @property
    def with_first_cells(self) -> Booleans:
        """Mask (p,) of the pairs that stand on two nodes, and may have a cell of four nodes there."""
        return ~self.fan & (self.joined_pairs != 1)

    @property
    def joined_pairs(self) -> Integers:
        """Number (p,) of the layer from which on pairs have nodes in common, 0 if they have none."""
        return np.where(self.pinch, self.joined[self.pair[:, 0]], 0)

    @property
    def are_pinched(self) -> Booleans:
        """Mask (c,) of the columns that have nodes in common with others."""
        found = np.zeros(len(self), bool)
        found[self.pair[self.pinch]] = True
        return found

    @property
    def are_in_fans(self) -> Booleans:
        """Mask (c,) of the columns that stand on one node with others."""
        found = np.zeros(len(self), bool)
        found[self.pair[self.fan]] = True
        return found

    @property
    def are_in_hollows(self) -> Booleans:
        """Mask (c,) of the columns that come nearer to each other, on edges that are short beside the first layer."""
        i, j = self.pair.T
        across = self.start[j] - self.start[i]
        nearer = -((self.foot_up[j] - self.foot_up[i]) * across).sum(axis=1)
        found = np.zeros(len(self), bool)
        found[self.pair[(self.leader[i] == self.leader[j]) & (nearer > LEAST_BEND * np.hypot(*across.T))]] = True
        return found

    def own(self, count: Integers) -> Integers:
        """Counts (c,) of nodes above the wall, without those that columns have of another one."""
        return np.where(self.owner == np.arange(len(self)), count, np.minimum(count, self.joined - 1))

    @property
    def thickness(self) -> Floats:
        """Height (c,) of all layers that are asked for, and no higher than the spacing at the foot."""
        thickness = np.array([ladder.thickness_below(self.spacing / self.scale) for ladder in self.ladders])
        return self.scale * thickness[self.ladder, np.arange(len(self))]

    @property
    def first(self) -> Floats:
        """Height (c,) of the first layer, as it is asked for beside the neighbours."""
        return self.scale * self._first

    @property
    def _first(self) -> Floats:
        return np.array([ladder.first for ladder in self.ladders])[self.ladder]

    @cached_property
    def scale(self) -> Floats:
        """Heights (c,) of the layers that are asked for over those of the ladder.

        They are below 1 beside columns of a ladder with a lower first height: heights rise gradually from these.
        """
        if len({ladder.first for ladder in self.ladders}) == 1:
            return np.ones(len(self))
        i, j = self.pair.T
        one, other = self.twins.T
        asked = self._first
        first, lower = asked, asked.copy()
        for _ in range(len(self)):
            for a, b in ((i, j), (j, i)):
                np.minimum.at(lower, a, np.minimum(LARGEST_RATIO * first[b], first[b] + RISE * self.bare_widths))
            for a, b in ((one, other), (other, one)):
                np.minimum.at(lower, a, first[b])
            if (lower == first).all():
                break
            first, lower = lower, lower.copy()
        return first / asked

    @property
    def have_own_first(self) -> Booleans:
        """Mask (c,) of the columns whose first height is not lower beside those of another ladder."""
        return self.scale >= 1 - NEARLY

    @property
    def requested(self) -> Integers:
        """Number (c,) of layers that are asked for."""
        return np.array([ladder.count for ladder in self.ladders])[self.ladder]

    @property
    def are_isotropic(self) -> Booleans:
        """Mask (c,) of the columns whose layers go on until they are as high as wide."""
        return np.array([ladder.isotropic for ladder in self.ladders])[self.ladder]

    def tops(self, which: Integers, count: Integers) -> Floats:
        """Height (k,) of so many layers (k,) on columns (k,), as they are asked for."""
        return self.scale[which] * self._tops[self.ladder[which], count]

    @cached_property
    def _tops(self) -> Floats:
        table = np.zeros((len(self.ladders), 1 + max(ladder.count for ladder in self.ladders)))
        for number, ladder in enumerate(self.ladders):
            table[number, : ladder.count + 1] = ladder.tops
        return table

    @property
    def bare_widths(self) -> Floats:
        """Distances (p,) between the feet of pairs."""
        return np.hypot(*(self.at[self.pair[:, 1]] - self.at[self.pair[:, 0]]).T)

    def least_of_pairs(self, values: Floats) -> Floats:
        """Least (c,) of the values (p,) of the pairs that each column belongs to; infinite for one in none."""
        least = np.full(len(self), np.inf)
        for end in self.pair.T:
            np.minimum.at(least, end, values)
        return least
