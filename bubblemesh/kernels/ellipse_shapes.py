"""Shapes of triangles in a metric, and flips of edges that better them, compiled or in NumPy alike."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.kernels.library import call, or_numpy
from bubblemesh.kernels.newton import FOUR_ROOTS

GAIN = 1e-6  # relative, of a shape measure, for which an edge is flipped
GOOD = 1.1  # shape measure: an edge between two triangles that are as good is not flipped; of half squares it is 1.15


def shape_measures_in_numpy(x: Floats, triangles: Integers, inside: Floats) -> Floats:
    """The same as `shape_measures`, in NumPy."""
    (ax, ay), (bx, by), (ox, oy) = (x[node].T for node in triangles.T)
    r11, r12, r22 = inside.T
    ux, uy = r11 * (bx - ax) + r12 * (by - ay), r22 * (by - ay)
    wx, wy = r11 * (ox - ax) + r12 * (oy - ay), r22 * (oy - ay)
    zx, zy, area = wx - ux, wy - uy, (ux * wy - uy * wx) / 2
    squares = (ux * ux + uy * uy) + (wx * wx + wy * wy) + (zx * zx + zy * zy)
    return np.divide(squares, FOUR_ROOTS * area, out=np.full(len(area), np.inf), where=area > 0)


@or_numpy(shape_measures_in_numpy)
def shape_measures(x: Floats, triangles: Integers, inside: Floats) -> Floats:
    """Shape measures (t,) of triangles (t, 3) of nodes x (n, 2) in metrics with roots (t, 3).

    They are those of `shapes.eta` in the metric: 1 for an equilateral triangle, infinite for a flat or inverted one.
    """
    result = np.empty(len(triangles))
    call(
        "metric_shapes",
        t=len(triangles),
        triangles=np.ascontiguousarray(triangles),
        x=np.ascontiguousarray(x),
        roots=np.ascontiguousarray(inside),
        eta=result,
    )
    return result


class Flips(NamedTuple):
    """Flips of edges: the two triangles of each before and after it."""

    owners: Integers  # (m, 2): their rows
    turned: Integers  # (m, 2, 3): what they become


class Shaped(NamedTuple):
    """Triangles with their shapes, which flips change in place."""

    triangles: Integers  # (t, 3)
    measures: Floats  # (t,)
    inside: Floats  # (t, 3): roots of the metric at the centroids

    def flips_in_numpy(self, n: int, facets: Integers, fresh: Booleans) -> Flips:
        """The same as `flips`, in NumPy."""
        triangles, t = self.triangles, len(self.triangles)
        sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        keys, back = sides[:, 0] * n + sides[:, 1], sides[:, 1] * n + sides[:, 0]
        order = np.argsort(keys)
        place = np.minimum(np.searchsorted(keys[order], back), max(3 * t - 1, 0))
        other = np.where(keys[order][place] == back, order[place], -1)
        ends = np.concatenate([facets, facets[:, ::-1]])
        inner = np.flatnonzero((other > np.arange(3 * t)) & ~np.isin(keys, ends[:, 0] * n + ends[:, 1]))
        (one, k), (two, k2) = np.divmod(inner, 3), np.divmod(other[inner], 3)
        poor = self.measures > GOOD
        chosen = (fresh[one] | fresh[two]) & (poor[one] | poor[two])
        (a, b), c, e = sides[inner].T, triangles[one, (k + 2) % 3], triangles[two, (k2 + 2) % 3]
        turned = np.stack([np.column_stack([a, e, c]), np.column_stack([e, b, c])], axis=1)
        return Flips(np.column_stack([one, two])[chosen], turned[chosen])

    @or_numpy(flips_in_numpy)
    def flips(self, n: int, facets: Integers, fresh: Booleans) -> Flips:
        """Flips that are worth a look of edges, but facets (f, 2), between ``n`` nodes.

        One of the two triangles is fresh (t,): other flips are known to be no better. Not both of them are good.
        """
        t, count = len(self.triangles), np.zeros(1, np.int64)
        owners, turned = np.empty((3 * t, 2), np.int64), np.empty((3 * t, 2, 3), np.int64)
        call(
            "flips_of_shapes",
            n=n,
            t=t,
            triangles=self.triangles,
            f=len(facets),
            facets=np.ascontiguousarray(facets),
            measures=self.measures,
            fresh=fresh,
            good=GOOD,
            owners=owners,
            turned=turned,
            count=count,
        )
        return Flips(owners[: count[0]], turned[: count[0]])

    def flip_in_numpy(self, flips: Flips, after: Floats, there: Floats) -> Booleans:
        """The same as `flip`, in NumPy."""
        after, there, owners = after.reshape(-1, 2), there.reshape(-1, 2, 3), flips.owners
        with np.errstate(invalid="ignore"):
            gain = 1 - after.max(axis=1) / self.measures[owners].max(axis=1)
        better = np.flatnonzero(gain > GAIN)
        better = better[np.argsort(-gain[better], kind="stable")]
        rank, first = np.arange(len(better)), np.full(len(self.triangles), len(better))
        np.minimum.at(first, owners[better], rank[:, None])
        chosen = better[(first[owners[better]] == rank[:, None]).all(axis=1)]
        flipped = owners[chosen]
        self.triangles[flipped], self.measures[flipped], self.inside[flipped] = (
            part[chosen] for part in (flips.turned, after, there)
        )
        return first < len(better)

    @or_numpy(flip_in_numpy)
    def flip(self, flips: Flips, after: Floats, there: Floats) -> Booleans:
        """Mask (t,) of the triangles that any of the flips betters; none if there was no flip.

        Those are flipped that lessen the larger measure of the two most, in both triangles; ``after`` (2 m,) are the
        measures that these would have, ``there`` (2 m, 3) the roots of the metric in them.
        """
        fresh = np.empty(len(self.triangles), bool)
        call(
            "flip_to_shapes",
            t=len(self.triangles),
            triangles=self.triangles,
            measures=self.measures,
            roots=self.inside,
            m=len(flips.owners),
            owners=np.ascontiguousarray(flips.owners),
            turned=np.ascontiguousarray(flips.turned),
            after=after,
            there=there,
            least=GAIN,
            fresh=fresh,
        )
        return fresh
