"""Confinement of motion by the boundary: corners stay, boundary bubbles slide, interior bubbles stay inside."""

from dataclasses import dataclass

import numpy as np

from bubblemesh.arrays import Floats, turned_left
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.motion import Force


@dataclass
class Sliding:
    """The boundary pieces under the sliding bubbles, with arc lengths (b,), places and tangents (b, 2) of these."""

    boundary: Boundary
    bubbles: Bubbles  # at the start of the motion

    def __post_init__(self) -> None:
        self.tracks = self.boundary.tracks(self.bubbles.piece)
        self._stand_at(self.bubbles.s)

    def _stand_at(self, s: Floats) -> None:
        self.s, (self.here, self.tangents) = s, self.tracks.places(s)

    def project(self, vectors: Floats) -> Floats:
        """Forces or velocities (n, 2) without the part that the boundary takes up, in place."""
        slide = self.bubbles.sliding
        vectors[: self.bubbles.corners] = 0
        vectors[slide] = np.einsum("ij,ij->i", vectors[slide], self.tangents)[:, None] * self.tangents
        return vectors

    def projecting(self, force: Force) -> Force:
        """The force as a function of positions, without the part that the boundary takes up."""
        return lambda x: self.project(force(x))

    def advance(self, x: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Positions and velocities (n, 2) after a step, with the sliding bubbles projected back on their curves."""
        self.follow(x)
        return x, self.project(v)

    def follow(self, x: Floats) -> None:
        """Take note of where the sliding bubbles are, and project their x (n, 2) back on their curves, in place."""
        slide = self.bubbles.sliding
        if len(self.s):
            ahead = np.einsum("ij,ij->i", x[slide] - self.here, self.tangents)
            self._stand_at(self.tracks.wrapped(self.s + ahead))
            x[slide] = self.here

    def bubbles_at(self, x: Floats, d: Floats) -> Bubbles:
        """The bubbles at rest at x (n, 2) with spacing d (n,), at the end of the motion."""
        return self.bubbles.moved(x, d, self.s)


@dataclass
class Confinement:
    """Keeps interior bubbles inside, asking for the boundary only where one may have reached it.

    One that crossed it is put back to ``margin`` spacings from it: never onto it, which would make a flat triangle.
    """

    domain: Domain
    x: Floats
    margin: float = 0.3

    def __post_init__(self) -> None:
        self.free = self.domain.distance_at_least(self.x)

    def put_back(self, x: Floats, v: Floats, d: Floats) -> None:
        """Put interior bubbles x (k, 2) that crossed the boundary back and at rest, in place."""
        suspects = np.flatnonzero(np.hypot(*(x - self.x).T) > np.abs(self.free))
        if len(suspects) == 0:
            return
        self.x[suspects] = x[suspects]
        self.free[suspects] = self.domain.signed_distance(x[suspects])
        crossed = suspects[self.free[suspects] <= 0]
        if len(crossed):
            piece, s, foot, _ = self.domain.nearest(x[crossed])
            normals = turned_left(self.domain.boundary.tangents(piece, s))
            x[crossed] = foot + self.margin * d[crossed, None] * normals
            v[crossed] = 0
            self.x[crossed] = x[crossed]
            self.free[crossed] = self.domain.signed_distance(x[crossed])
