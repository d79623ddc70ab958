"""Flips of edges that make triangles Delaunay in a metric, compiled or in NumPy alike.

Tensors are rows (m11, m12, m22).
"""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.kernels.library import call, or_numpy
from bubblemesh.kernels.linking import room_of_edges, shortened
from bubblemesh.kernels.tensors import mapped, roots

MOST_FLIP_PASSES = 60
SURE = 1e-9  # of the terms of the circle test: what is nearer to 0 is rounding
FLATTEST_FLIP = 1e-3  # area of a triangle that a flip makes, in terms of both


def flipped_in_numpy(triangles: Integers, x: Floats, m: Floats, facets: Integers) -> tuple[Integers, Integers]:
    """The same as `flipped`, in NumPy."""
    triangles, n, t = triangles.copy(), len(x), len(triangles)
    ends = np.concatenate([facets, facets[:, ::-1]])
    held = np.sort(ends[:, 0] * n + ends[:, 1])
    for left in range(MOST_FLIP_PASSES, -1, -1):
        sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        keys = sides[:, 0] * n + sides[:, 1]
        order = np.argsort(keys)
        place = np.minimum(np.searchsorted(keys[order], keys % n * n + keys // n), 3 * t - 1)
        other = order[place]
        other[keys[other] != keys % n * n + keys // n] = -1
        inner = np.flatnonzero((other > np.arange(3 * t)) & ~np.isin(keys, held))
        (row, k), (row2, k2) = np.divmod(inner, 3), np.divmod(other[inner], 3)
        a, b = sides[inner].T
        c, e = triangles[row, (k + 2) % 3], triangles[row2, (k2 + 2) % 3]
        wrong: list[int] = np.flatnonzero(_wrong(x, m, a, b, c, e)).tolist() if left else []
        changed, chosen = np.zeros(t, bool), list[int]()
        for number in wrong:
            if not (changed[row[number]] or changed[row2[number]]):
                changed[row[number]] = changed[row2[number]] = True
                chosen.append(number)
        if not chosen:
            break
        triangles[row[chosen]] = np.column_stack([a, e, c])[chosen]
        triangles[row2[chosen]] = np.column_stack([e, b, c])[chosen]
    return triangles, sides[(other < 0) | (other > np.arange(3 * t))]


@or_numpy(flipped_in_numpy)
def flipped(triangles: Integers, x: Floats, m: Floats, facets: Integers) -> tuple[Integers, Integers]:
    """Triangles (t, 3) between nodes x (n, 2) after flips that make them Delaunay in a metric, and their edges (e, 2).

    The metric of an edge between two triangles is the mean of the tensors m (n, 3) at their four nodes: the edge is
    flipped if the circle in it around one triangle holds the other's node. The facets (f, 2) stay. Flips come in passes
    in which no triangle changes twice; where the metric changes from edge to edge they need not end by themselves.
    """
    result, (edges, count) = np.array(triangles, order="C"), room_of_edges(triangles)
    call(
        "metric_flips",
        n=len(x),
        t=len(result),
        triangles=result,
        x=np.ascontiguousarray(x),
        m=np.ascontiguousarray(m),
        f=len(facets),
        facets=np.ascontiguousarray(facets),
        passes=MOST_FLIP_PASSES,
        sure=SURE,
        flattest=FLATTEST_FLIP,
        edges=edges,
        count=count,
    )
    return result, shortened(edges, count)


def _wrong(x: Floats, m: Floats, a: Integers, b: Integers, c: Integers, e: Integers) -> Booleans:
    """Mask (k,) of the edges from a to b, between triangles (a, b, c) and (b, a, e), that have to be flipped."""
    root = roots(m[a] + m[b] + m[c] + m[e])
    (ax, ay), (bx, by), (cx, cy) = (mapped(root, x[nodes] - x[e]).T for nodes in (a, b, c))
    bc, ca, ab = bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx
    aa, bb, cc = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    value, whole = aa * bc + bb * ca + cc * ab, np.abs(ca) + np.abs(bc)
    scale = aa * np.abs(bc) + bb * np.abs(ca) + cc * np.abs(ab)
    return (value > SURE * scale) & (ca > FLATTEST_FLIP * whole) & (bc > FLATTEST_FLIP * whole)
