"""Signs of determinants of places; 0 where rounding could change the sign.

References
----------
J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", Discrete Comput.
Geom. 18 (1997), for the bounds A of the rounding.
"""

import numpy as np

from bubblemesh.arrays import Floats

ROUNDING = 2.0**-53
# Bounds of the rounding error, as shares of the sum of the absolute terms: beyond them the sign is right.
TURN_ERROR, CIRCLE_ERROR = (3 + 16 * ROUNDING) * ROUNDING, (10 + 96 * ROUNDING) * ROUNDING


def turns(a: Floats, b: Floats, c: Floats) -> Floats:
    """1 if a, b and c (..., 2) surely turn left, -1 if they surely turn right, else 0."""
    (ux, uy), (vx, vy) = np.moveaxis(a - c, -1, 0), np.moveaxis(b - c, -1, 0)
    left, right = ux * vy, uy * vx
    turn = left - right
    return np.asarray(np.where(np.abs(turn) > TURN_ERROR * (np.abs(left) + np.abs(right)), np.sign(turn), 0.0))


def in_circle(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """1 if d is surely inside the circle through a, b and c (..., 2), which turn left, -1 if surely outside, else 0."""
    (ax, ay), (bx, by), (cx, cy) = (np.moveaxis(place - d, -1, 0) for place in (a, b, c))
    bc, cb, ca, ac, ab, ba = bx * cy, cx * by, cx * ay, ax * cy, ax * by, bx * ay
    over_a, over_b, over_c = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    value = over_a * (bc - cb) + over_b * (ca - ac) + over_c * (ab - ba)
    most = (np.abs(bc) + np.abs(cb)) * over_a + (np.abs(ca) + np.abs(ac)) * over_b + (np.abs(ab) + np.abs(ba)) * over_c
    return np.asarray(np.where(np.abs(value) > CIRCLE_ERROR * most, np.sign(value), 0.0))
