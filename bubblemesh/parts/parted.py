"""A domain packed in parts: cut, packed part by part, joined, and packed once more along the seams."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from bubblemesh.arrays import Booleans, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.annealing import Annealing
from bubblemesh.packing.levels import SingleLevel
from bubblemesh.packing.methods import Method
from bubblemesh.packing.net import Net, reconnect
from bubblemesh.parts.cuts import cut
from bubblemesh.parts.division import Division, Places, divided
from bubblemesh.parts.patches import Patch, joined, patch
from bubblemesh.parts.seams import near, put_back, strips
from bubblemesh.parts.work import Crew, Deadline, Packed, Record, packed, packed_from
from bubblemesh.spacing.spacing import Spacing

PER_PART = 100_000  # nodes, about, of each part, where their number is not given
SEAM = 6  # edges from a cut to the bubbles that stay
JUNCTION = 10  # the same from where a cut ends, which is packed once more after the rest of the seams
SEAMS_WORK = 0.15  # share of the progress


class Parted(NamedTuple):
    """What was packed in parts."""

    net: Net
    on_cuts: int  # bubbles along the cuts
    in_seams: int  # bubbles that were packed again


def enough_parts(expected_nodes: float) -> int:
    """How many parts a mesh is worth."""
    return max(round(expected_nodes / PER_PART), 1)


@dataclass
class Together:
    """What all parts and strips have in common: how they are packed, by whom, and who is told of it."""

    spacing: Spacing
    method: Method
    max_nodes: int
    deadline: Deadline
    crew: Crew
    on_done: Callable[[Record], None]  # is told of each part, in their order, and of each pass over the seams
    on_share: Callable[[float], None]  # is told what share of all is done
    share: float = 0.0

    def parts(self, domains: Sequence[Domain], shares: Sequence[float], expected_nodes: float) -> list[Packed]:
        """Pack parts with these shares of all bubbles."""
        jobs = (
            (domain, self.spacing, self._of_a_part(share), share * expected_nodes, self.max_nodes, self.deadline)
            for domain, share in zip(domains, shares, strict=True)
        )
        done = list[Packed]()
        for part in self._in_order(packed, jobs, [(1 - SEAMS_WORK) * share for share in shares]):
            self.on_done(part.record)
            done.append(part)
        return done

    def seams(self, net: Net, free: Booleans) -> tuple[Net, Integers]:
        """Pack strips of a net once more, as of `put_back`, in which the bubbles that are ``free`` (n,) may move."""
        found, method = list(strips(net, free)), self._of_a_seam()
        jobs = ((strip.domain, self.spacing, method, strip.x, self.deadline) for strip in found)
        work = [SEAMS_WORK * len(strip.inside) / len(net.bubbles) for strip in found]
        done = list(self._in_order(packed_from, jobs, work))
        if done:
            self.on_done(Record.together([part.record for part in done]))
        return put_back(net, list(zip(found, done, strict=True)), self.spacing)

    def _of_a_seam(self) -> Method:
        """The method for strips, whose order is that of the parts beside them."""
        annealing = self.method.annealing
        if isinstance(annealing, Annealing):
            annealing = replace(annealing, effort="fast")
        return replace(self.method, levels=SingleLevel(), annealing=annealing)

    def _of_a_part(self, share: float) -> Method:
        """The method as a part gets it: it takes as long for each bubble as in one piece."""
        annealing = self.method.annealing
        if isinstance(annealing, Annealing):
            annealing = replace(annealing, fully_shaken=max(round(share * annealing.fully_shaken), 1))
        return replace(self.method, annealing=annealing)

    def _in_order(
        self, function: Callable[..., Packed], jobs: Iterable[tuple[Any, ...]], work: Sequence[float]
    ) -> Iterator[Packed]:
        """Results of all jobs in their order; each is a share of all work."""
        waiting, told = dict[int, Packed](), 0
        for number, result in self.crew(function, jobs):
            waiting[number] = result
            self.share += work[number]
            self.on_share(min(self.share, 1.0))
            while told in waiting:
                yield waiting.pop(told)
                told += 1


def packed_in_parts(domain: Domain, expected_nodes: float, parts: int, together: Together) -> Parted:
    """Pack a domain in so many parts.

    Bubbles on the cuts are set beforehand and stay, so that the parts know nothing of each other. In the end strips
    along the cuts are packed once more with these bubbles free: first between the ends of cuts, then around the ends.
    """
    cuts = cut(domain, together.spacing, expected_nodes, parts)
    division = divided(domain, cuts, together.spacing)
    domains, places = zip(*map(division.part, range(cuts.cells)), strict=True)
    done = together.parts(domains, (cuts.work / cuts.work.sum()).tolist(), expected_nodes)
    net, along, ends = joined(division, list(_patches(division, places, done)), together.spacing)
    between = near(net, along, SEAM) & ~near(net, ends, JUNCTION)
    in_seams = int(between.sum())
    net, number = together.seams(net, between)
    around = near(net, number[ends], JUNCTION)
    net, _ = together.seams(net, around)
    # Where rims of strips were, edges are flipped until they are Delaunay.
    net = reconnect(net, net.bubbles, net.triangles)
    return Parted(net, len(along), in_seams + int(around.sum()))


def _patches(division: Division, places: Sequence[Places], done: Sequence[Packed]) -> Iterator[Patch]:
    first = len(division.boundary.corners) + len(division.held.s)
    for where, part in zip(places, done, strict=True):
        yield patch(division, where, part, first)
        first += len(part.bubbles)
