"""Similarities of the plane: maps that keep angles, so that circles stay circles and arcs stay arcs."""

import cmath
import math

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.records import record

# Cosine and sine of whole quarter turns, which floating-point numbers of pi would miss.
QUARTERS = (1 + 0j, 1j, -1 + 0j, -1j)


@record
class Similarity:
    """The map of the complex number z = x + iy to ``factor`` * z + ``shift``, of its conjugate if ``mirrored``."""

    factor: complex = 1 + 0j  # how lengths grow, and by what angle all is turned
    shift: complex = 0j
    mirrored: bool = False  # y becomes -y before all else

    @classmethod
    def of(
        cls,
        mirror: str | None = None,
        scale: float = 1.0,
        rotate: float = 0.0,
        about: tuple[float, float] = (0.0, 0.0),
        move: tuple[float, float] = (0.0, 0.0),
    ) -> "Similarity":
        """The similarity that mirrors, scales, rotates and moves, in this order.

        ``mirror`` "x" turns x into -x and "y" turns y into -y; lengths become ``scale`` times as long, seen from the
        origin; ``rotate`` is in degrees, counter-clockwise about the point ``about``; ``move`` is added last.
        """
        turn, center = direction_at(rotate), complex(*about)
        flip = -1 if mirror == "x" else 1  # x to -x is y to -y and half a turn
        shift = center - turn * center + complex(*move) if center else complex(*move)
        return cls(turn * (flip * scale), shift, mirror is not None)

    def then(self, other: "Similarity") -> "Similarity":
        """The similarity that does this one, then the other one."""
        factor, shift = self.factor, self.shift
        if other.mirrored:
            factor, shift = factor.conjugate(), shift.conjugate()
        return Similarity(other.factor * factor, other.factor * shift + other.shift, self.mirrored != other.mirrored)

    @property
    def scale(self) -> float:
        """The factor by which lengths grow."""
        return abs(self.factor)

    @property
    def angle(self) -> float:
        """The angle in radians by which all is turned, after it has been mirrored."""
        return cmath.phase(self.factor)

    @property
    def matrix(self) -> Floats:
        """The map as columns (2, 3): what becomes of the vectors (1, 0) and (0, 1), and a shift."""
        (a, b), (c, d) = self.vectors(np.eye(2)).tolist()
        return np.array([[a, c, self.shift.real], [b, d, self.shift.imag]])

    @property
    def turn(self) -> int:
        """-1 if the map reverses orientations, else +1."""
        return -1 if self.mirrored else 1

    def point(self, point: tuple[float, float]) -> tuple[float, float]:
        """The place that a point comes to."""
        (x, y), (a, b) = point, (self.factor.real, self.factor.imag)
        y *= self.turn
        return a * x - b * y + self.shift.real, b * x + a * y + self.shift.imag

    def points(self, points: Floats) -> Floats:
        """The places (n, 2) that points (n, 2) come to."""
        return self.vectors(points) + np.array([self.shift.real, self.shift.imag])

    def vectors(self, vectors: Floats) -> Floats:
        """Differences (n, 2) of places after the map, of those (n, 2) before it."""
        (x, y), (a, b) = vectors.T, (self.factor.real, self.factor.imag)
        y = y * self.turn
        return np.column_stack([a * x - b * y, b * x + a * y])

    def directions(self, vectors: Floats) -> Floats:
        """Vectors (n, 2) mirrored and turned, but as long as before."""
        return self.vectors(vectors) / self.scale

    def angle_of(self, angle: float) -> float:
        """The angle, in radians from the x axis, that a direction at ``angle`` comes to."""
        return self.turn * angle + self.angle


UNMOVED = Similarity()


def direction_at(degrees: float) -> complex:
    """Direction at an angle from the x axis, as a number of length 1; exact for whole quarter turns."""
    quarters, rest = divmod(degrees, 90)
    if rest == 0:
        return QUARTERS[int(quarters % 4)]
    return QUARTERS[int(quarters % 4)] * cmath.exp(1j * math.radians(rest))
