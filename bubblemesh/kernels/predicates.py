"""Signs of determinants of places, 0 where rounding could decide.

References
----------
J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", Discrete Comput.
Geom. 18 (1997), for the bounds A of the rounding.
"""

import numpy as np

from bubblemesh.arrays import Floats

ROUNDING = 2.0**-53
# Of the sums of the determinants' terms: a larger determinant has the sign of the exact one.
TURN_ERROR, CIRCLE_ERROR = (3 + 16 * ROUNDING) * ROUNDING, (10 + 96 * ROUNDING) * ROUNDING


def turns(a: Floats, b: Floats, c: Floats) -> Floats:
    """Whether a, b and c (..., 2) turn left, 1, or right, -1, for sure; else 0."""
    (ux, uy), (vx, vy) = np.moveaxis(a - c, -1, 0), np.moveaxis(b - c, -1, 0)
    left, right = ux * vy, uy * vx
    turn = left - right
    return np.asarray(np.where(np.abs(turn) > TURN_ERROR * (np.abs(left) + np.abs(right)), np.sign(turn), 0.0))


def in_circle(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Whether d is in the circle through a, b and c (..., 2) that turn left, 1, or outside, -1, for sure; else 0."""
    (ax, ay), (bx, by), (cx, cy) = (np.moveaxis(place - d, -1, 0) for place in (a, b, c))
    bc, cb, ca, ac, ab, ba = bx * cy, cx * by, cx * ay, ax * cy, ax * by, bx * ay
    over_a, over_b, over_c = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    value = over_a * (bc - cb) + over_b * (ca - ac) + over_c * (ab - ba)
    most = (np.abs(bc) + np.abs(cb)) * over_a + (np.abs(ca) + np.abs(ac)) * over_b + (np.abs(ab) + np.abs(ba)) * over_c
    return np.asarray(np.where(np.abs(value) > CIRCLE_ERROR * most, np.sign(value), 0.0))
