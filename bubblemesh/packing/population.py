"""Population control: bubbles go where they overlap too much and come where there is a gap."""

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from annotated_types import Gt
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.adjacency import Neighbours, independent, pairs_within
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.connection import arcs, connected, parted
from bubblemesh.packing.forces import CUTOFF
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.triangulation import circumcircles

__all__ = ["Change", "Thresholds", "boundary_overlaps", "overlaps"]

REACH_OF_OVERLAP = 2.0  # 2 r_i + r_j < l cannot overlap; in units of l0 that is below 2 for any two radii


class Change(NamedTuple):
    """Bubbles after population control.

    ``touched`` (n,) marks those next to a deleted or an inserted bubble, and the inserted ones.
    """

    bubbles: Bubbles
    deleted: int
    inserted: int
    touched: Booleans


@dataclass(frozen=True)
class Thresholds:
    """Deletion and insertion by thresholds of the overlap ratio, in the order in which bubbles are met.

    Attributes
    ----------
    delete_above, delete_above_boundary : float
        Overlap ratios, in the plane and along a curve, above which a bubble goes.
    delete_apart : float
        Two deletions in one round are at least this far apart, in units of spacing.
    insert_below : float
        A bubble may come next to one whose overlap ratio is below this.
    insert_apart : float
        It keeps this distance from all others, in units of spacing.
    """

    delete_above: Annotated[float, Gt(0)] = 7.9
    delete_above_boundary: Annotated[float, Gt(0)] = 3.5
    delete_apart: Annotated[float, Gt(0)] = 1.2
    insert_below: Annotated[float, Gt(0)] = 4.5
    insert_apart: Annotated[float, Gt(0)] = 0.85

    def __call__(self, bubbles: Bubbles, domain: Domain, spacing: Spacing) -> Change:
        """One control of the whole population."""
        near = Neighbours.of(bubbles.x, bubbles.d, REACH_OF_OVERLAP)
        alpha = overlaps(near)
        along = boundary_overlaps(bubbles, domain)
        gone = self._deleted(bubbles, near, alpha, along)
        touched = next_to(near, gone)
        keep = np.flatnonzero(~gone)
        kept = bubbles.kept(keep)
        rest = parted(kept, domain, spacing)
        alpha, touched = with_more(alpha[keep], kept, rest, np.inf), with_more(touched[keep], kept, rest, True)
        x, piece, s, hosts = self._insertions(rest, alpha, domain, spacing)
        grown = rest.joined_by(x, spacing(x), piece, s)
        touched[hosts] = True
        touched = with_inserted(rest, touched, len(x), len(piece))
        whole = parted(grown, domain, spacing)
        return Change(whole, int(gone.sum()), len(whole) - len(kept), with_more(touched, grown, whole, True))

    def _deleted(self, bubbles: Bubbles, near: Neighbours, alpha: Floats, along: Floats) -> Booleans:
        """Bubbles (n,) to delete."""
        crowded = np.zeros(len(bubbles), bool)
        crowded[bubbles.sliding] = along > self.delete_above_boundary
        crowded[bubbles.interior] = alpha[bubbles.interior] > self.delete_above
        return chosen(crowded, near, self.delete_apart, self.rank(alpha))

    def rank(self, alpha: Floats) -> Integers:
        """Order (n,) in which crowded bubbles are deleted."""
        return np.arange(len(alpha))

    def _insertions(
        self, bubbles: Bubbles, alpha: Floats, domain: Domain, spacing: Spacing
    ) -> tuple[Floats, Integers, Floats, Integers]:
        """New centres (k, 2), pieces and arc lengths (j,) of the first j, and indices of bubbles beside them."""
        edges, edge_piece, triangles = connected(bubbles, domain)
        piece, s, gap = boundary_gaps(bubbles, domain, edges, edge_piece, self.insert_apart)
        on_boundary = domain.boundary.points(piece, s)
        center, radius = circumcircles(bubbles.x, triangles)
        loose = (alpha[triangles] < self.insert_below).any(axis=1) & np.isfinite(radius)
        loose[loose] = domain.contains(center[loose])
        loose[loose] = radius[loose] > self.insert_apart * spacing(center[loose])
        hole = np.flatnonzero(loose)
        d = spacing(center[hole])
        hole = hole[domain.signed_distance(center[hole]) > self.insert_apart / 2 * d]
        x = np.vstack([on_boundary, center[hole]])
        apart = independent(pairs_within(x, spacing(x), self.insert_apart), np.arange(len(x))) if len(x) else gap < 0
        slides = len(piece)
        hosts = np.concatenate([edges[gap][apart[:slides]].ravel(), triangles[hole][apart[slides:]].ravel()])
        return x[apart], piece[apart[:slides]], s[apart[:slides]], hosts


def overlaps(near: Neighbours) -> Floats:
    """Overlap ratios (n,): alpha_i = sum over neighbours of max(0, 2 r_i + r_j - l) / r_i; 6 in a perfect packing."""
    i, j = near.pairs.T
    r, distance = near.d / 2, np.hypot(*(near.x[i] - near.x[j]).T)
    on_i = np.maximum(0, 2 * r[i] + r[j] - distance) / r[i]
    on_j = np.maximum(0, 2 * r[j] + r[i] - distance) / r[j]
    return np.bincount(np.append(i, j), np.append(on_i, on_j), len(r)).astype(float)


def boundary_overlaps(bubbles: Bubbles, domain: Domain) -> Floats:
    """Overlap ratios (b,) of the sliding bubbles with the two bubbles on either side of them; 2 if all are in place."""
    edges, _ = domain.boundary.edges(bubbles.piece, bubbles.s)
    ahead, behind = (np.full(bubbles.boundary_count, -1) for _ in range(2))
    ahead[edges[:, 0]], behind[edges[:, 1]] = edges[:, 1], edges[:, 0]
    me = np.arange(bubbles.corners, bubbles.boundary_count)
    x, r = bubbles.x, bubbles.d / 2
    alpha = np.zeros(len(me))
    for step in (ahead, behind):
        first = step[me]
        second = np.where(first >= bubbles.corners, step[first], -1)  # not past a corner
        for other in (first, second):
            overlap = 2 * r[me] + r[other] - np.hypot(*(x[me] - x[other]).T)
            alpha += np.where((other >= 0) & (other != me), np.maximum(0, overlap) / r[me], 0)
    return alpha


def boundary_gaps(
    bubbles: Bubbles, domain: Domain, edges: Integers, edge_piece: Integers, apart: float
) -> tuple[Integers, Floats, Integers]:
    """Pieces and arc lengths (k,) of the midpoints of boundary edges with room for one more bubble, and the edges."""
    boundary = domain.boundary
    begin, end = arcs(bubbles, domain, edges, edge_piece)
    d = (bubbles.d[edges[:, 0]] + bubbles.d[edges[:, 1]]) / 2
    gap = np.flatnonzero(end - begin > 2 * apart * d)
    middle = boundary.wrapped(edge_piece[gap], (begin[gap] + end[gap]) / 2)
    return edge_piece[gap], middle, gap


def chosen(wanted: Booleans, near: Neighbours, apart: float, rank: Integers) -> Booleans:
    """Those of the ``wanted`` (n,) that keep a distance of ``apart`` spacings from each other, by rank."""
    i, j = near.pairs.T
    conflict = wanted[i] & wanted[j]
    close = np.hypot(*(near.x[i] - near.x[j]).T) < apart * near.contact
    number = np.cumsum(wanted) - 1
    result = np.zeros(len(wanted), bool)
    result[wanted] = independent(number[near.pairs[conflict & close]], rank[wanted])
    return result


def next_to(near: Neighbours, marked: Booleans) -> Booleans:
    """Bubbles (n,) that a marked one acts on."""
    i, j = near.pairs[np.hypot(*(near.x[near.pairs[:, 0]] - near.x[near.pairs[:, 1]]).T) < CUTOFF * near.contact].T
    result = np.zeros(len(marked), bool)
    result[j[marked[i]]] = True
    result[i[marked[j]]] = True
    return result


def with_inserted(rest: Bubbles, touched: Booleans, count: int, slides: int) -> Booleans:
    """The marks of ``rest`` carried over to the bubbles joined by ``count`` new ones, which are marked too."""
    at = rest.boundary_count
    return np.concatenate([touched[:at], np.ones(slides, bool), touched[at:], np.ones(count - slides, bool)])


def with_more(values: NDArray[Any], before: Bubbles, after: Bubbles, value: float) -> NDArray[Any]:
    """Values (n,) of the bubbles, and one ``value`` for those that came to the boundary."""
    at = before.boundary_count
    return np.insert(values, at, np.full(after.boundary_count - at, value))
