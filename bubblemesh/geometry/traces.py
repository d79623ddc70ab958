"""Polylines by arc length: the family of curves that are given by many points."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bubblemesh.arrays import Floats, Integers


@dataclass(frozen=True)
class Polylines:
    """Polylines through ``vertices``, one array (k, 2) each, whose tangents jump at them."""

    vertices: Sequence[Floats]

    @cached_property
    def _first(self) -> Integers:
        """Row (n + 1,) of each polyline's first vertex in the tables of all."""
        return np.cumsum([0, *map(len, self.vertices)])

    @cached_property
    def _points(self) -> Floats:
        return np.concatenate(list(self.vertices))

    @cached_property
    def _s(self) -> Floats:
        """Arc length at each vertex."""
        return np.concatenate([np.cumsum(np.append(0, np.hypot(*np.diff(v, axis=0).T))) for v in self.vertices])

    @cached_property
    def _order(self) -> Floats:
        """Increasing numbers for a search over all tables at once."""
        owner = np.repeat(np.arange(len(self.vertices)), np.diff(self._first))
        return owner + self._s / self.lengths[owner]

    @cached_property
    def lengths(self) -> Floats:
        return self._s[self._first[1:] - 1]

    @property
    def exact(self) -> bool:
        return True

    def stations(self) -> tuple[Integers, Floats]:
        owner = np.repeat(np.arange(len(self.vertices)), np.diff(self._first))
        starts = np.delete(np.arange(len(owner)), self._first[1:] - 1)
        return owner[starts], self._s[starts]

    def points(self, index: Integers, s: Floats) -> Floats:
        j = self._segment(index, s)
        share = (s - self._s[j]) / (self._s[j + 1] - self._s[j])
        return self._points[j] + share[:, None] * (self._points[j + 1] - self._points[j])

    def tangents(self, index: Integers, s: Floats) -> Floats:
        j = self._segment(index, s)
        return (self._points[j + 1] - self._points[j]) / (self._s[j + 1] - self._s[j])[:, None]

    def _segment(self, index: Integers, s: Floats) -> Integers:
        """Row (m,) of the vertex before each place."""
        j = np.searchsorted(self._order, index + s / self.lengths[index], side="right") - 1
        return np.clip(j, self._first[index], self._first[index + 1] - 2)
