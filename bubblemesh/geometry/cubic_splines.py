"""Cubic splines through points of the plane: the interpolating cubic spline of de Boor, in plain arithmetic.

It needs no library, which would take longer to load than most cases take to mesh, and gives the same bits everywhere.
"""

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import GeometryError
from bubblemesh.messages import place
from bubblemesh.records import record


@record(eq=False)
class CubicSpline:
    """A cubic polynomial for each interval between breaks, over [0, 1]."""

    breaks: Floats  # (k,), from 0 to 1
    coefficients: Floats  # (4, k - 1, 2), highest power first, of the distance from the interval's first break
    periodic: bool

    @classmethod
    def through(cls, points: Floats, slopes: Floats | None = None, *, cornered: bool = False) -> "CubicSpline":
        """Spline through ``points`` (k, 2) over [0, 1] by chord length.

        With ``slopes`` (2, 2) these are the derivatives by length at the ends; without them the ends are "not-a-knot".
        A closed spline is smooth at its start, unless that is ``cornered``. GeometryError if a chord is too short,
        compared to the others, to have different ends.
        """
        u = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        length, u = u[-1], u / u[-1]
        h = np.diff(u)
        if not (h > 0).all():
            raise GeometryError(
                f"two points of the spline at {place(points[int((h > 0).argmin())])} are too near to each other beside "
                f"its length of {length:.3g}: remove one of them"
            )
        rise = np.diff(points, axis=0) / h[:, None]
        periodic = slopes is None and not cornered and len(points) > 3 and bool(np.all(points[0] == points[-1]))
        if slopes is not None:
            rates = _between(h, rise, slopes * length)
        elif periodic:
            rates = _periodic(h, rise)
        else:
            rates = _not_a_knot(u, h, rise)
        bend = (rates[:-1] + rates[1:] - 2 * rise) / h[:, None]
        second = (rise - rates[:-1]) / h[:, None] - bend
        return cls(u, np.stack([bend / h[:, None], second, rates[:-1], points[:-1]]), periodic)

    def points(self, u: Floats) -> Floats:
        """Points (m, 2) at parameters u (m,)."""
        c, t = self._local(u)
        return c[3] + c[2] * t + c[1] * (t * t) + c[0] * (t * t * t)

    def rates(self, u: Floats) -> Floats:
        """Derivatives (m, 2) by the parameter at u (m,)."""
        c, t = self._local(u)
        return c[2] + c[1] * t * 2 + c[0] * (t * t) * 3

    def _local(self, u: Floats) -> tuple[Floats, Floats]:
        """Coefficients (4, m, 2) of the intervals that hold u, and the distances (m, 1) from their first breaks."""
        u = np.mod(u, 1) if self.periodic else u
        row = np.clip(np.searchsorted(self.breaks, u, side="right") - 1, 0, len(self.breaks) - 2)
        return self.coefficients[:, row], (u - self.breaks[row])[:, None]


def _inner(h: Floats, rise: Floats) -> tuple[Floats, Floats]:
    """Diagonal (k - 2,) and right sides (k - 2, 2) of the equations by which curvature has no jump at inner breaks."""
    return 2 * (h[:-1] + h[1:]), 3 * (h[1:, None] * rise[:-1] + h[:-1, None] * rise[1:])


def _between(h: Floats, rise: Floats, ends: Floats) -> Floats:
    """Derivatives (k, 2) at all breaks, those at the ends (2, 2) being given."""
    diagonal, right = _inner(h, rise)
    return _solved(
        np.append(h[1:], 0),
        np.concatenate([[1], diagonal, [1]]),
        np.append(0, h[:-1]),
        np.vstack([ends[0], right, ends[1]]),
    )


def _not_a_knot(u: Floats, h: Floats, rise: Floats) -> Floats:
    """Derivatives (k, 2) at all breaks, the third derivative having no jump at the first and the last inner one."""
    if len(h) == 1:
        return np.repeat(rise, 2, axis=0)
    diagonal, right = _inner(h, rise)
    if len(h) == 2:  # a parabola
        matrix = np.array([[1, 1, 0], [h[1], diagonal[0], h[0]], [0, 1, 1]])
        return np.linalg.solve(matrix, np.vstack([2 * rise[0], right, 2 * rise[1]]))
    first, last = u[2] - u[0], u[-1] - u[-3]
    begin = ((h[0] + 2 * first) * h[1] * rise[0] + h[0] * h[0] * rise[1]) / first
    end = (h[-1] * h[-1] * rise[-2] + (2 * last + h[-1]) * h[-2] * rise[-1]) / last
    return _solved(
        np.append(h[1:], last),
        np.concatenate([[h[1]], diagonal, [h[-2]]]),
        np.append(first, h[:-1]),
        np.vstack([begin, right, end]),
    )


def _periodic(h: Floats, rise: Floats) -> Floats:
    """Derivatives (k, 2) at all breaks of a closed spline, the same ones at both ends."""
    diagonal, right = _inner(h, rise)
    # Without the equation at the last break but one the system is tridiagonal, once with that break's derivative at
    # zero and once at one.
    lower, middle = h[1:-1], np.append(2 * (h[-1] + h[0]), diagonal[:-1])
    upper = np.append(h[-1], h[:-3])
    begin = 3 * (h[0] * rise[-1] + h[-1] * rise[0])
    unit = np.zeros((len(middle), 2))
    unit[0], unit[-1] = -h[0], -h[-3]
    plain, change = _solved(lower, middle, upper, np.vstack([begin, right[:-1]])), _solved(lower, middle, upper, unit)
    end = (3 * (h[-1] * rise[-2] + h[-2] * rise[-1]) - h[-2] * plain[0] - h[-1] * plain[-1]) / (
        2 * (h[-1] + h[-2]) + h[-2] * change[0] + h[-1] * change[-1]
    )
    rates = np.vstack([plain + end * change, end])
    return np.vstack([rates, rates[:1]])


def _solved(lower: Floats, diagonal: Floats, upper: Floats, right: Floats) -> Floats:
    """Solution (k, 2) of a tridiagonal system with two right sides (k, 2), by elimination with row interchanges."""
    below, d, above, (x, y) = lower.tolist(), diagonal.tolist(), upper.tolist(), right.T.tolist()
    last, beyond = len(d) - 1, [0.0] * len(d)  # a second upper diagonal, which interchanges fill
    above.append(0.0)
    for i in range(last):
        if abs(d[i]) >= abs(below[i]):
            factor = below[i] / d[i]
            d[i + 1] -= factor * above[i]
            x[i + 1] -= factor * x[i]
            y[i + 1] -= factor * y[i]
        else:
            factor = d[i] / below[i]
            d[i], d[i + 1], above[i] = below[i], above[i] - factor * d[i + 1], d[i + 1]
            if i + 1 < last:
                beyond[i], above[i + 1] = above[i + 1], -factor * above[i + 1]
            x[i], x[i + 1] = x[i + 1], x[i] - factor * x[i + 1]
            y[i], y[i + 1] = y[i + 1], y[i] - factor * y[i + 1]
    for values in (x, y):
        values[last] /= d[last]
        if last:
            values[last - 1] = (values[last - 1] - above[last - 1] * values[last]) / d[last - 1]
        for i in range(last - 2, -1, -1):
            values[i] = (values[i] - above[i] * values[i + 1] - beyond[i] * values[i + 2]) / d[i]
    return np.column_stack([x, y])
