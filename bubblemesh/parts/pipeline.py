"""A domain packed in parts: cut, packed part by part, joined, and packed once more along the seams."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import sqrt

import numpy as np

from bubblemesh.arrays import Booleans, Integers, each_once
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.census import Census
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.messages import place
from bubblemesh.packing.net import Net, reconnect
from bubblemesh.packing.rounds import Figures
from bubblemesh.parts.cuts import Cuts, find_cuts
from bubblemesh.parts.division import CutDomain, Places, cut_domain
from bubblemesh.parts.packing import PartJob, packed_part
from bubblemesh.parts.part import Core, Margin
from bubblemesh.parts.patches import Patch, join_bands, patch
from bubblemesh.parts.seams import JUNCTION, SEAM, SeamStrips, Strip, near, settled
from bubblemesh.parts.store import Store
from bubblemesh.parts.work import Deadline, Job, Terms
from bubblemesh.parts.workshop import Workshop
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

# Nodes, about, of each part, where their number is not given; from `FEW` parts on they grow with the mesh, as their
# number does, or the seams would.
PER_PART, FEW = 100_000, 10
EVEN = 4, 2  # workers that share the parts evenly then, if there are enough
SEAMS_WORK = 0.15  # share of the progress


@record
class Parted:
    """A domain packed in parts: all bands as one net, and where the cores are kept."""

    net: Net  # of all bubbles on the boundary, and of those of the bands, which their triangles connect
    rim: Integers  # (r, 2): sides of its triangles beyond which cores are
    rim_region: Integers  # (r,): region there
    numbers: tuple[Integers, ...]  # of each part: what the first nodes of its core's triangles are in the net
    store: Store
    sizes: Integers  # (parts, 2): nodes and triangles of the cores
    regions: Integers  # (k,): of the whole, that cores have triangles in
    census: tuple[Census, ...]  # of the cores, if figures are wanted
    valence: Integers  # (n,): edges of the cores at each bubble of the net, if figures are wanted
    cell: Integers  # (t,): part that each triangle of the net lies in
    start: Figures  # of all parts before their first rounds
    on_cuts: int  # bubbles along the cuts
    in_seams: int  # bubbles that were packed again

    @property
    def firsts(self) -> Integers:
        """Number (parts + 1,) of the first node of each core, after those of the net; and of all nodes."""
        return len(self.net.bubbles) + np.cumsum(np.append(0, self.sizes[:, 0]))

    @property
    def nodes(self) -> int:
        """Number of all nodes."""
        return int(self.firsts[-1])

    def core(self, part: int) -> Core:
        """The core of a part, whose triangles (t, 3) have the numbers of all nodes."""
        core = self.store.core(part)
        number = np.append(self.numbers[part], self.firsts[part] + np.arange(len(core.x)))
        return core._replace(triangles=number[core.triangles])

    def whole(self, spacing: Spacing) -> Net:
        """All bubbles, with all triangles."""
        net, cores = self.net, [self.core(part) for part in range(len(self.sizes))]
        x = np.concatenate([core.x for core in cores])
        bubbles = net.bubbles.append(x, spacing.extended(x))
        triangles = np.concatenate([net.triangles, *(core.triangles for core in cores)])
        if spacing.in_metric:  # flips by circles in space would undo those in the metric
            return replace(net.of(bubbles), triangles=triangles, edges=unique_edges(triangles)[0], legal=None)
        return reconnect(net, bubbles, triangles)


def enough_parts(expected_nodes: float) -> int:
    """Number of parts that a mesh is worth."""
    parts = expected_nodes / PER_PART
    parts = min(parts, sqrt(FEW * parts))
    return next((each * round(parts / each) for each in EVEN if parts >= 0.75 * each), 1)


def packed_in_parts(
    domain: Domain,
    expected_nodes: float,
    parts: int,
    terms: Terms,
    workshop: Workshop,
    deadline: Callable[[], Deadline],
) -> Parted:
    """Pack a domain in so many parts.

    Bubbles on the cuts are set beforehand and stay, so that the parts know nothing of each other. In the end strips
    along the cuts are packed once more with these bubbles free: first between the ends of cuts, then around the ends.
    The bands of the parts, in which these strips are, are all that is held here. The deadline is asked for once the
    domain is cut, by which it shows how much of the processor there is.
    """
    workshop.crew(packed_part, ())  # no jobs yet: its workers start while the domain is cut
    cuts = find_cuts(domain, terms.spacing, expected_nodes, parts)
    division = cut_domain(domain, cuts, terms.spacing, coarsened=terms.method.coarsens)
    terms = replace(terms, deadline=deadline())
    places, margins = _packed_parts(division, cuts, expected_nodes, terms, workshop)
    net, along, ends, numbers = join_bands(division, list(_patches(division, places, margins)), terms.spacing)
    rim = np.concatenate([number[margin.band.rim] for number, margin in zip(numbers, margins, strict=True)])
    between = near(net, along, SEAM) & ~near(net, ends, JUNCTION)
    between[rim] = False
    in_seams = int(between.sum())
    net, moved = _packed_seams(net, between, terms, workshop, 1 - SEAMS_WORK)
    # Where the first strips ended the bubbles of the cuts stayed, and left them in disorder.
    around = near(net, moved[ends], JUNCTION + SEAM)
    around[moved[rim]] = False
    net, again = _packed_seams(net, around, terms, workshop, 1 - SEAMS_WORK / 2)
    # Bubbles that are gone have no number; no core knows any of them.
    number = np.where(moved < 0, -1, again[moved])
    numbers = tuple(number[known] for known in numbers)
    valence = np.zeros(len(net.bubbles), np.int64)
    for known, margin in zip(numbers, margins, strict=True):
        edged = margin.valence > 0  # each of these is a bubble of its own
        valence[known[edged]] += margin.valence[edged]
    net = settled(net, terms.spacing)
    return Parted(
        net=net,
        cell=cuts.cell_of(net.bubbles.x[net.triangles].mean(axis=1)),
        rim=number[rim],
        rim_region=np.concatenate([margin.band.rim_region for margin in margins]),
        numbers=numbers,
        store=workshop.store,
        sizes=np.array([(margin.nodes, margin.triangles) for margin in margins]),
        regions=each_once(np.concatenate([margin.regions for margin in margins])),
        census=tuple(margin.census for margin in margins if margin.census is not None),
        valence=valence,
        start=Figures.together([margin.start for margin in margins]),
        on_cuts=len(along),
        in_seams=in_seams + int(around.sum()),
    )


def _packed_parts(
    division: CutDomain, cuts: Cuts, expected_nodes: float, terms: Terms, workshop: Workshop
) -> tuple[list[Places], list[Margin]]:
    """Pack all parts: the places and the margin of each."""
    shares = (cuts.work / cuts.work.sum()).tolist()
    places = dict[int, Places]()

    def job(cell: int) -> Job:
        domain, places[cell] = division.part(cell)
        part = PartJob(domain, places[cell], shares[cell] * expected_nodes, terms.for_part(shares[cell]))
        return Job(f"the part around {_middle_of(domain.bounds)}", (part,))

    margins = workshop.margins(job, [(1 - SEAMS_WORK) * share for share in shares], terms.target is not None)
    for cell in range(cuts.cells):
        if cell not in places:  # it was kept
            _, places[cell] = division.part(cell)
    return [places[cell] for cell in range(cuts.cells)], margins


def _packed_seams(net: Net, free: Booleans, terms: Terms, workshop: Workshop, done: float) -> tuple[Net, Integers]:
    """Pack strips of a net once more, as `SeamStrips.put_back` needs them; bubbles that are ``free`` (n,) may move.

    The share ``done`` of all work is done before; half of that for seams is done here.
    """
    found = SeamStrips.of(net, free)
    made = dict[int, Strip]()
    terms = terms.for_seams()
    sizes = found.sizes

    def job(number: int) -> Job:
        strip = made[number] = found[number]
        around = _middle_of((*strip.x.min(axis=0), *strip.x.max(axis=0)))
        return Job(f"the seam around {around}", (strip, terms))

    packed = workshop.strips(job, [SEAMS_WORK / 2 * size / sum(sizes) for size in sizes], done)
    return found.put_back([(made[number], part) for number, part in enumerate(packed)], terms.spacing)


def _middle_of(bounds: tuple[float, float, float, float]) -> str:
    x0, y0, x1, y1 = bounds
    return place(((x0 + x1) / 2, (y0 + y1) / 2))


def _patches(division: CutDomain, places: Sequence[Places], margins: Sequence[Margin]) -> Iterator[Patch]:
    first = len(division.boundary.corners) + len(division.held.s)
    for where, margin in zip(places, margins, strict=True):
        yield patch(division, where, margin.band, first)
        first += len(margin.band.x)
