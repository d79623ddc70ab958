"""Mending: the worst triangles get other surroundings by trial and error, patch by patch."""

from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.arrays import Booleans, Floats, Integers, all_of_rows, largest_of_rows, taken
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.domain import Domain
from bubblemesh.kernels.library import or_numpy
from bubblemesh.kernels.patches import separate_patches
from bubblemesh.kernels.shapes import eta
from bubblemesh.packing.annealing import Effort
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.confinement import Sliding
from bubblemesh.packing.net import Net, connect_inside, reconnect
from bubblemesh.packing.placement import displaced
from bubblemesh.packing.smoothing import NoSmoothing, Smoothing
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

AT_MOST, SHARE_AT_MOST = 16, 0.001  # triangles around which a part is mended: so many, or of so many bubbles
DISPLACED = 1  # rings around a triangle
MOVING = 3  # rings around a triangle, the displaced ones among them
AROUND_BAD = 6  # rings around a triangle; a patch needs no look beyond
PASSES = 2
MORE, MOVED = 2, 0.1  # times as many attempts at most, as long as they move so few of all bubbles that they cost little
SQUARINGS = 6  # of the shape measure, for its 64th power
TIMES = {"fast": 1, "normal": 1, "best": 4}  # the attempts, by effort


class Patches(NamedTuple):
    """Patches of a net that have no node in common."""

    displaced: Booleans  # (n,): nodes that are displaced
    moving: Integers  # (n,): the patch that each node moves with, or -1
    number: int  # of patches


AnySmoothing = NoSmoothing | Smoothing


@record
class NoMending:
    """No mending."""

    attempts: ClassVar[int] = 0

    def __call__(
        self, net: Net, domain: Domain, spacing: Spacing, smoothing: AnySmoothing, random: np.random.Generator
    ) -> Net:
        """The net as it is."""
        return net


@record
class MendingAttempts:
    """Parameters of mending, of circles or of ellipses."""

    effort: Effort = "normal"
    mend_attempts: Annotated[
        int, Ge(0), Le(1000), Doc("attempts at each of the worst triangles, four times as many with `effort: best`")
    ] = 12
    mend_worse: Annotated[float, Ge(1), Doc("triangles of larger shape measure are mended; 1 is equilateral")] = 1.08
    mend_amplitude: Annotated[float, Gt(0), Le(0.5), Doc("standard deviation of the displacement, in spacings")] = 0.2

    @property
    def attempts(self) -> int:
        """Number of attempts at each of the worst triangles."""
        return TIMES[self.effort] * self.mend_attempts


@record
class Mending(MendingAttempts):
    """Random displacements around the worst triangles, smoothed, and kept where a patch gets better.

    Bubbles on the boundary are displaced along it. In large meshes, where few bubbles are at bad triangles, there are
    up to twice as many attempts. Without smoothing there is no mending.
    """

    def __call__(
        self, net: Net, domain: Domain, spacing: Spacing, smoothing: AnySmoothing, random: np.random.Generator
    ) -> Net:
        """The net with better worst triangles and the same number of bubbles."""
        bad = self._bad(net)[: max(AT_MOST, int(SHARE_AT_MOST * len(net.bubbles)))]
        if len(bad) == 0 or smoothing.shape_steps == 0:
            return net
        around = net.within(net.triangles[bad], AROUND_BAD)
        numbers, part = net.part(around)
        mended, patches, moved = part, self._patches(part), 0
        for attempt in range(MORE * self.attempts):
            if patches is None or (attempt >= self.attempts and moved > MOVED * len(net.bubbles)):
                break
            moved += int((patches.moving >= 0).sum())
            try:
                tried = self._tried(mended, patches, domain, smoothing, random)
            except GeometryError:  # where two walls are near, bubbles that slid made boundary edges that cross
                continue
            if tried is not mended:
                mended, patches = tried, self._patches(tried)
        if mended is part:
            return net
        try:
            return _with_part(net, mended, numbers, around, domain, spacing)
        except GeometryError:  # a wall beside the part is near
            return net

    def _bad(self, net: Net) -> Integers:
        """Numbers (k,) of the triangles to mend, the worst first."""
        measure = eta(net.bubbles.x, net.triangles)
        bad = np.flatnonzero(measure > self.mend_worse)
        return bad[np.argsort(-measure[bad], kind="stable")]

    def _patches(self, net: Net) -> Patches | None:
        """Patches around the worst triangles; None if none is bad."""
        bad = self._bad(net)
        return disjoint_patches(net, bad) if len(bad) else None

    def _tried(
        self, net: Net, patches: Patches, domain: Domain, smoothing: AnySmoothing, random: np.random.Generator
    ) -> Net:
        """The net after one attempt at each of its patches."""
        trial = reconnect(net, self._displaced(net.bubbles, patches, domain, random))
        for _ in range(PASSES):
            trial = reconnect(trial, smoothing.moved(trial, domain, patches.moving >= 0))
        better = badness(trial, patches) < badness(net, patches)
        better[patches.moving[(trial.valence == 0) & (patches.moving >= 0)]] = False  # one was displaced outside
        keep = np.append(better, False)[patches.moving]  # nodes of no patch have the last entry
        if not keep.any():
            return net
        old, new = net.bubbles, trial.bubbles
        x = np.where(keep[:, None], new.x, old.x)
        return reconnect(net, old.moved(x, s=np.where(keep[old.sliding], new.s, old.s)))

    def _displaced(self, bubbles: Bubbles, patches: Patches, domain: Domain, random: np.random.Generator) -> Bubbles:
        """The bubbles with those of patches displaced; on the boundary they slide.

        They do not beside bubbles that are held, as those of cuts: what is poor there is for these to mend.
        """
        held, beside = np.zeros(len(bubbles), bool), np.zeros(patches.number + 1, bool)
        held[bubbles.sliding] = domain.tied[bubbles.piece]
        beside[patches.moving[held]] = True  # nodes of no patch mark the last entry
        which = patches.displaced.copy()
        which[bubbles.sliding] &= ~beside[patches.moving[bubbles.sliding]]
        x = displaced(bubbles, which, self.mend_amplitude, random).x
        sliding = Sliding(domain.boundary, bubbles)
        sliding.follow(x)
        return sliding.bubbles_at(x, bubbles.d)


def _with_part(net: Net, mended: Net, numbers: Integers, around: Booleans, domain: Domain, spacing: Spacing) -> Net:
    """The net with the bubbles ``numbers`` (k,) and the triangles between those ``around`` (n,) as in a mended part."""
    bubbles = net.bubbles
    x, s = bubbles.x.copy(), bubbles.s.copy()
    x[numbers] = mended.bubbles.x
    s[numbers[mended.bubbles.sliding] - bubbles.corners] = mended.bubbles.s
    others = net.triangles[~all_of_rows(around[net.triangles])]
    triangles = np.concatenate([others, numbers[mended.triangles]])
    return connect_inside(bubbles.moved(x, s=s), domain, spacing, net, triangles)


def disjoint_patches_in_numpy(net: Net, bad: Integers) -> Patches:
    """The patches of `disjoint_patches`, made in NumPy."""
    n, free = len(net.bubbles), _free(net)
    displaced, moving, used = np.zeros(n, bool), np.full(n, -1), np.zeros(n, bool)
    count = 0
    for triangle in bad:
        core = net.within(net.triangles[triangle], DISPLACED)
        patch = net.dilated(core, MOVING - DISPLACED)
        if (patch & used).any():
            continue
        displaced |= core & free
        moving[patch & free] = count
        used |= net.dilated(patch)
        count += 1
    return Patches(displaced, moving, count)


@or_numpy(disjoint_patches_in_numpy)
def disjoint_patches(net: Net, bad: Integers) -> Patches:
    """Patches around the triangles ``bad`` (k,) that are apart from those of the ones before."""
    return Patches(*separate_patches(net.edges, net.triangles[bad], _free(net), DISPLACED, MOVING))


def _free(net: Net) -> Booleans:
    """Bubbles (n,) that may move: no corners, and none where a part of a net was cut off."""
    free = np.arange(len(net.bubbles)) >= net.bubbles.corners
    free[net.facets[net.facet_piece < 0]] = False
    return free


def badness(net: Net, patches: Patches) -> Floats:
    """Sums (number,) of eta^64, of the shape measure, over the triangles that move with each patch.

    The worst triangle counts by far the most, but no other one may get much worse for it.
    """
    patch = largest_of_rows(patches.moving[net.triangles])
    moving = np.flatnonzero(patch >= 0)
    power = eta(net.bubbles.x, taken(net.triangles, moving))
    with np.errstate(over="ignore"):
        for _ in range(SQUARINGS):
            power = power * power
    return np.bincount(patch[moving], power, minlength=patches.number).astype(float)
