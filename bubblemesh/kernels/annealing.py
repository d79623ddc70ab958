"""Cycles of annealing at once: the twin, which goes through them one by one, is in `packing.annealing`."""

from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, ShortIntegers
from bubblemesh.kernels.library import call
from bubblemesh.kernels.linking import Legal, room_of_edges, shortened
from bubblemesh.kernels.relaxing import Steps


class Cycles(NamedTuple):
    """Cycles of annealing, each a random displacement of bubbles whose order is broken, and a relaxation."""

    seed: int  # of the random numbers
    first: int  # number of the first one
    inside: Floats  # (k,): standard deviations of the displacements, in spacings
    beside: Floats  # (k,): those next to the boundary
    calm: Booleans  # (n,): bubbles that are not displaced

    def after(self, done: int) -> "Cycles":
        """The cycles without the first ``done`` ones."""
        return Cycles(self.seed, self.first + done, self.inside[done:], self.beside[done:], self.calm)


class Links(NamedTuple):
    """How n bubbles are connected, all in the order of `linking.in_order`."""

    triangles: Integers  # (t, 3)
    edges: Integers  # (m, 2)
    twins: ShortIntegers | None  # (t, 3): as in `linking.Legal`; None if not known
    facets: Integers  # (b, 2): edges that stay
    start: Floats  # (n, 2): places of the bubbles when they were connected


class Acting(NamedTuple):
    """Sizes and strengths of n bubbles, by which forces act between those that edges join: see `relaxing.Pull`."""

    d: Floats  # (n,): spacing at the bubbles
    strength: Floats  # (n,)
    cutoff: float


class Annealed(NamedTuple):
    """Bubbles after cycles of annealing."""

    x: Floats  # (n, 2): places
    legal: Legal | None  # None where the places are those of one displacement more, which flips cannot connect
    connected_at: Floats  # (n, 2): places for which flips made it
    speeds: Floats  # (cycles, steps): mean speeds


def annealed(x: Floats, links: Links, acting: Acting, steps: Steps, cycles: Cycles) -> Annealed:
    """Bubbles after cycles of annealing from x (n, 2), up to the first one whose bubbles flips cannot connect."""
    places, start = np.array(x, order="C"), np.array(links.start, order="C")
    speeds, done = np.empty((len(cycles.inside), len(steps.c))), np.empty(1, np.int64)
    triangles, edges, count = np.array(links.triangles, order="C"), *room_of_edges(links.triangles)
    twins = np.empty(triangles.shape, np.int32) if links.twins is None else links.twins.copy()
    edges[: len(links.edges)] = links.edges
    call(
        "anneal",
        n=len(x),
        t=len(triangles),
        triangles=triangles,
        m=len(links.edges),
        edges=edges,
        known=int(links.twins is not None),
        twins=twins,
        facet_count=len(links.facets),
        facets=np.ascontiguousarray(links.facets),
        start=start,
        x=places,
        fixed=steps.fixed,
        calm=cycles.calm,
        d=acting.d,
        strength=acting.strength,
        cutoff=acting.cutoff,
        most=steps.most,
        dt=steps.dt,
        steps=len(steps.c),
        c=steps.c,
        cycles=len(speeds),
        inside=cycles.inside,
        beside=cycles.beside,
        seed=cycles.seed,
        first=cycles.first,
        speeds=speeds,
        count=count,
        done=done,
    )
    if done[0] < len(speeds):
        return Annealed(places, None, start, speeds[: done[0]])
    return Annealed(places, Legal(triangles, shortened(edges, count), twins), start, speeds)
