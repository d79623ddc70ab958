"""Figures of boundary layers: what came out of them on the walls of each label."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, cross, each_once, turned_left
from bubblemesh.layers.columns import NEARLY, Columns
from bubblemesh.layers.heights import gradual, layers_within
from bubblemesh.layers.joining import JoinedLayers
from bubblemesh.layers.lacks import LowColumns, lacks, low_columns, lowest
from bubblemesh.layers.ladder import MOST_LAYERS, Ladder
from bubblemesh.layers.obstacles import Obstacles
from bubblemesh.layers.placement import columns_on
from bubblemesh.layers.rest import Rest
from bubblemesh.layers.room import room
from bubblemesh.layers.strips import Strips
from bubblemesh.layers.walls import Walls
from bubblemesh.meshes.edges import find_sides
from bubblemesh.meshes.quads import corner_angles, quadrilaterals
from bubblemesh.meshes.quality import Measures
from bubblemesh.messages import place
from bubblemesh.packing.net import Net
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

LARGEST_JUMP = 1.5  # of the height from the last layer to the triangles beside it
FLAT_ANGLE = 175.0  # degrees: larger angles of the cells have a warning
FAR_JUMP = 10.0  # the same of layers that go on until they are isotropic: where walls are short they end before
MOSTLY = 0.5  # of the columns: if fewer have all layers, their number is not what makes sizes jump
EQUILATERAL = np.sqrt(0.75)  # height of a triangle over its sides
ENDED = "something is in their way, or they end one by one at an end of the wall"


@record
class LabelLayers:
    """Layers on the walls of one label.

    Attributes
    ----------
    label : str
    region : str or None
        Region that has them, if the case names one.
    by_thickness : bool
        Whether the case asks for their height in all.
    isotropic : bool
        Whether they go on until they are as high as wide.
    columns : int
        Number of columns, those of fans included, but not those at its ends that have lower layers of another entry.
    wanted, growth : float
        First height and ratio of heights that the case asks for.
    first : mapping of str to float
        ``least``, ``mean`` and ``largest`` first height above the wall over the wanted one, where there are layers, and
        ``kept``: the share of the wall's length on which it is the wanted one to 5 %.
        Empty where all edges of the wall are as corners.
    count : mapping of str to int
        ``wanted`` number of layers (the most of any column), the ``least`` and ``most`` that columns have.
    complete : float
        Share of the columns that have all layers, at full height.
    low : float
        Share of the columns that have less than half of the height that is asked for, but for those where layers end
        one by one along the wall.
    lacks : tuple of LowColumns
        Why they have: one for each reason. That neighbours have few layers is one only if it holds for many columns.
    shortest : tuple of mappings
        Columns that lack layers or height, the ones with the fewest layers first: ``layers`` and the place ``at`` of
        the foot.
    compressed : float
        Least factor of heights that were compressed; 1 if none was.
    thickness : float
        Mean height of the columns.
    orthogonality : mapping of str to float
        ``mean`` and ``least`` angle in degrees between columns and the wall.
    aspect : float
        Largest ratio of a cell's width to its height.
    angle_max : mapping or None
        The largest angle in ``degrees`` of the cells, and the place ``at`` of that cell's middle; unknown before the
        triangles beside them are there.
    across_front : float or None
        Median along the wall of the ratio of heights across the front, fans left out: of packed triangles on it to the
        last layer; an estimate by the spacing before there are any.
    farthest : mapping or None
        The largest ``ratio`` of these, and the place ``at`` of the middle of that front.
    advised : int or None
        Number of layers with which heights would pass across the front, where they do not; none if a case may not ask
        for so many.
    fitting : int or None
        Number of layers, up to the ``advised`` one, for which there is room on most columns.
    """

    label: str
    region: str | None
    by_thickness: bool
    isotropic: bool
    columns: int
    wanted: float
    growth: float
    first: Mapping[str, float]
    count: Mapping[str, int]
    complete: float
    low: float
    lacks: tuple[LowColumns, ...]
    shortest: tuple[Mapping[str, Any], ...]
    compressed: float
    thickness: float
    orthogonality: Mapping[str, float]
    aspect: float
    angle_max: Mapping[str, Any] | None
    across_front: float | None
    farthest: Mapping[str, Any] | None
    advised: int | None
    fitting: int | None

    @property
    def lacking(self) -> list[str]:
        """Warnings of columns that are much lower than asked for, one for each reason."""
        return [f"layers on {self.label!r}: {lack.warning(self.compressed)}" for lack in self.lacks]

    @property
    def flat(self) -> str | None:
        """Warning of triangles with an angle near 180 degrees, if there are any."""
        if self.angle_max is None or self.angle_max["degrees"] <= FLAT_ANGLE:
            return None
        return (
            f"layers on {self.label!r}: a triangle of them at {place(self.angle_max['at'])} has an angle of "
            f"{self.angle_max['degrees']:.1f} degrees: make the spacing on the wall finer there; in a sharp notch "
            "it is as it has to be"
        )

    @property
    def jumping(self) -> str | None:
        """Warning of sizes that change too much across the front, if they do."""
        most = FAR_JUMP if self.isotropic else LARGEST_JUMP
        if self.across_front is None or self.across_front <= most:
            return None
        times = f"{'about ' if self.angle_max is None else ''}{self.across_front:.3g}"
        jump = f"layers on {self.label!r}: triangles beside them are {times} times as high as the last layer"
        if self.isotropic:
            return (
                f"{jump}, since columns end before they are as high as wide: the wall has too few of them, {ENDED}; a "
                "larger first or growth needs fewer layers"
            )
        if any(lack.reason == "first" for lack in self.lacks):
            return f"{jump}, since first heights rise only gradually beside walls with lower ones"
        if self.complete < MOSTLY:
            return f"{jump}, since columns end before they have all layers: {ENDED}"
        if self.by_thickness:  # more of them would be thinner ones
            return f"{jump}: first with until: isotropic, in place of thickness, lets sizes pass without a jump"
        if self.advised is None or self.fitting is None:
            return f"{jump}: until: isotropic lets sizes pass without a jump"
        if self.fitting <= self.count["wanted"]:
            return f"{jump}, and there is no room for more of them: a finer spacing lets sizes pass"
        if self.fitting < self.advised:
            more = f"until: isotropic, or count: {self.fitting}, for which most columns have room"
            return f"{jump}: {more}, lessens that; a finer spacing lets sizes pass"
        return f"{jump}: until: isotropic, or count: {self.advised} lets sizes pass without a jump"


def layer_figures(
    strips: Strips, beyond: Floats | None = None, joined: JoinedLayers | None = None
) -> tuple[LabelLayers, ...]:
    """Figures of the layers on each label, in the order of the case.

    Ratios ``beyond`` (p,) are those of `beyond_fronts`, or expected ones before the packing. After it the cells are
    ``joined`` to what was packed.
    """
    across = np.full(len(strips.columns.pair), np.nan) if beyond is None else beyond
    return tuple(
        replace(_on(strips, label, k, mine, across), angle_max=None if joined is None else _largest_angle(joined, mine))
        for k, ladder in enumerate(strips.columns.ladders)
        for label in ladder.labels
        if (mine := _pairs_of(strips.columns, strips.walls, label, k)).any()
    )


def _pairs_of(columns: Columns, walls: Walls, label: str, ladder: int) -> Booleans:
    """Mask (p,) of the pairs of columns on the walls with a label and these layers."""
    boundary = walls.domain.boundary
    here = boundary.label[walls.piece] == boundary.labels.index(label)
    return (here & (walls.ladder == ladder))[columns.side]


def _on(strips: Strips, label: str, number: int, mine: Booleans, across: Floats) -> LabelLayers:
    """Figures of the layers with a number on a label, between the pairs ``mine`` (p,)."""
    ladder = strips.columns.ladders[number]
    columns, heights = strips.columns, strips.heights
    which = _own(columns, each_once(columns.pair[mine].ravel()), number)
    count, factor = heights.count[which], heights.factor[which]
    full = (count >= heights.requested[which]) & (factor == 1) & columns.have_own_first[which]
    low = low_columns(strips, which)
    first, length, angle, aspect = _first_layer(strips, ladder.first, np.flatnonzero(mine & columns.with_first_cells))
    beyond = np.flatnonzero(mine & columns.apart & np.isfinite(across))
    jump = _median_along(across[beyond], columns.bare_widths[beyond]) if len(beyond) else None
    requested = int(heights.requested[which].max())
    advised = _advised(ladder, requested, jump)
    return LabelLayers(
        label=label,
        region=ladder.region,
        by_thickness=ladder.by_thickness,
        isotropic=ladder.isotropic,
        columns=len(which),
        wanted=ladder.first,
        growth=ladder.growth,
        first=_first_heights(first, length),
        count={
            "wanted": requested,
            "least": int(count.min()),
            "most": int(count.max()),
        },
        complete=float(full.mean()),
        low=float(np.logical_or.reduce([*low.values()]).mean()),
        lacks=lacks(strips, which, low, _lengths_beside(columns, mine)),
        shortest=lowest(strips, which[~full]),
        compressed=float(factor[count > 0].min(initial=1.0)),
        thickness=float(strips.height[which].mean()),
        orthogonality={"mean": float(angle.mean()), "least": float(angle.min())} if len(angle) else {},
        aspect=aspect,
        angle_max=None,
        across_front=jump,
        farthest=_farthest(strips, beyond, across[beyond]),
        advised=advised,
        fitting=None if advised is None else _fitting(strips, label, number, advised),
    )


def _largest_angle(joined: JoinedLayers, mine: Booleans) -> dict[str, Any] | None:
    """The largest angle of the cells between pairs ``mine`` (p,), and the middle of that cell; None without any."""
    x, triangles = joined.net.bubbles.x, joined.cells[mine[joined.pairs]]
    if len(triangles) == 0:
        return None
    quads = quadrilaterals(joined.cells, joined.halves[mine[joined.pairs[joined.halves[:, 0]]]])
    of_each = (triangles, Measures(x, triangles).angles), (quads, np.degrees(corner_angles(x[quads])))
    largest = [(angles.max(axis=1), cells) for cells, angles in of_each if len(cells)]
    # The angles of halves are parts of those of their quadrilateral.
    angles, cells = max(largest, key=lambda found: float(found[0].max()))
    flattest = angles.argmax()
    return {"degrees": float(angles[flattest]), "at": tuple(x[cells[flattest]].mean(axis=0).tolist())}


def _own(columns: Columns, which: Integers, number: int) -> Integers:
    """Of the columns (k,) on a wall those with the layers of that number; all, if all are those of walls beside it."""
    own = which[columns.ladder[which] == number]
    return own if len(own) else which


def _median_along(ratio: Floats, length: Floats) -> float:
    """Median of ratios (k,) at edges of the wall of some lengths (k,): it has more than the median on half of it."""
    order = np.argsort(ratio)
    covered = np.cumsum(length[order])
    return float(ratio[order[np.searchsorted(covered, covered[-1] / 2)]])


def _farthest(strips: Strips, pairs: Integers, ratio: Floats) -> dict[str, Any] | None:
    """The largest of the ratios (k,) beyond the fronts of pairs (k,), with the middle of its front."""
    if len(pairs) == 0:
        return None
    front = strips.x[strips.fronts[pairs[ratio.argmax()]]]
    return {"ratio": float(ratio.max()), "at": tuple(front.mean(axis=0).tolist())}


def _advised(ladder: Ladder, requested: int, jump: float | None) -> int | None:
    """Number of layers, in place of ``requested`` ones, without a jump behind the last one; None if there is none."""
    if jump is None or jump <= LARGEST_JUMP or ladder.isotropic or ladder.by_thickness or ladder.growth <= 1:
        return None
    count = requested + int(np.ceil(np.log(jump) / np.log(ladder.growth)))
    return count if count <= MOST_LAYERS else None


def _fitting(strips: Strips, label: str, number: int, most: int) -> int:
    """Number of layers, at ``most`` so many, that most columns on a label have room for: of a ladder with a number.

    These are the columns of the most layers, which turn where they would meet in corners. Those of other ladders, from
    which the number goes on by one from column to column, have as many as before.
    """
    walls, ladders = strips.walls, list(strips.columns.ladders)
    ladders[number] = replace(ladders[number], count=most)
    columns = columns_on(walls, ladders)
    height = room(columns, walls, Obstacles.of(walls), np.zeros(len(columns), np.int64))
    count = np.where(height >= columns.thickness, most, layers_within(columns, height))
    others, counts = strips.columns.ladder != number, np.full(len(walls.x), most)
    np.minimum.at(counts, strips.columns.foot[others], strips.heights.count[others])
    count = gradual(columns, np.where(columns.ladder == number, count, np.minimum(count, counts[columns.foot])))
    which = each_once(columns.pair[_pairs_of(columns, walls, label, number)].ravel())
    return int(np.quantile(count[which], 1 - MOSTLY, method="lower"))


def _lengths_beside(columns: Columns, mine: Booleans) -> Floats:
    """Lengths (c,) of the wall at columns: half of the edges beside each, of the pairs ``mine`` (p,)."""
    length, edges = np.zeros(len(columns)), mine & ~columns.fan
    for end in columns.pair[edges].T:
        np.add.at(length, end, columns.bare_widths[edges] / 2)
    return length


def _first_heights(first: Floats, length: Floats) -> dict[str, float]:
    """Figures of first heights (k, 2) over the requested one, at edges of lengths (k,); none without any edge."""
    if len(length) == 0:
        return {}
    some = first > 0
    ratio, weight = first[some], np.broadcast_to(length[:, None], first.shape)[some]
    return {
        "least": float(ratio.min()) if len(ratio) else 0.0,
        "mean": float(np.average(ratio, weights=weight)) if len(ratio) else 0.0,
        "largest": float(ratio.max(initial=0.0)),
        "kept": float(length[(np.abs(first - 1) <= NEARLY).all(axis=1)].sum() / length.sum()),
    }


def _first_layer(strips: Strips, requested: float, pairs: Integers) -> tuple[Floats, Floats, Floats, float]:
    """First heights (k, 2) at both ends of edges of the wall over the ``requested`` one, and these edges' lengths (k,).

    Then the angles in degrees between columns and edges where there are any layers, and the largest aspect ratio.
    """
    columns = strips.columns
    i, j = columns.pair[pairs].T
    base = columns.start[j] - columns.start[i]
    length = np.hypot(*base.T)
    up = turned_left(base) / length[:, None]
    found, angles = np.zeros((len(pairs), 2)), list[Floats]()
    for end, (column, way) in enumerate(((i, base), (j, -base))):
        some = strips.heights.count[column] > 0
        step = strips.x[strips.node(column[some], np.ones_like(column[some]))] - columns.start[column[some]]
        found[some, end] = (step * up[some]).sum(axis=1)
        cosine = (step * way[some]).sum(axis=1) / (np.hypot(*step.T) * length[some])
        angles.append(90 - np.abs(np.degrees(np.arcsin(np.clip(cosine, -1, 1)))))
    height = found.max(axis=1)
    aspect = length[height > 0] / height[height > 0]
    return found / requested, length, np.concatenate(angles), float(aspect.max(initial=0.0))


def beyond_fronts(rest: Rest, net: Net) -> Floats:
    """Ratios (p,) of the height of the triangle on each pair's front to its last layer; NaN where there is no layer.

    The triangles are those of the packed rest. Of a front with nodes between its ends the first edge counts.
    """
    strips, points = rest.strips, net.bubbles.x
    columns, count = strips.columns, strips.heights.count
    own, after = np.full(len(strips.x), -1), np.full(len(points), -1)
    own[rest.corners] = np.arange(len(rest.corners))
    edges = net.facets[rest.straight[net.facet_piece] & ~net.two_sided]
    after[edges[:, 0]] = edges[:, 1]
    ratio = np.full(len(columns.pair), np.nan)
    some = np.flatnonzero((count[columns.pair] > 0).all(axis=1))
    begin = own[strips.fronts[some, 0]]
    ends = np.column_stack([begin, after[begin]])
    triangle, side = find_sides(net.triangles, len(points), ends)
    apex = points[net.triangles[triangle, (side + 2) % 3]]
    base, over = points[ends[:, 1]] - points[ends[:, 0]], apex - points[ends[:, 0]]
    beyond = cross(base, over) / np.hypot(*base.T)
    ratio[some] = beyond / _last_heights(strips, some)
    return ratio


def expected_beyond_fronts(strips: Strips, spacing: Spacing) -> Floats:
    """The ratios (p,) of `beyond_fronts` before the packing, if triangles are as high as equilateral ones there.

    The spacing is that of the packing, in the middles of fronts.
    """
    columns, count = strips.columns, strips.heights.count
    ratio = np.full(len(columns.pair), np.nan)
    some = np.flatnonzero((count[columns.pair] > 0).all(axis=1))
    d = spacing.anywhere_towards(strips.x[strips.fronts[some]].mean(axis=1), columns.up[columns.pair[some, 0]])
    ratio[some] = EQUILATERAL * d / _last_heights(strips, some)
    return ratio


def _last_heights(strips: Strips, pairs: Integers) -> Floats:
    """Mean heights (k,) above the wall of the last layers of both columns of pairs (k,)."""
    column = strips.columns.pair[pairs]
    step = strips.x[strips.top[column]] - strips.x[strips.node(column, strips.heights.count[column] - 1)]
    last = np.hypot(*np.moveaxis(step, -1, 0)) / np.hypot(*np.moveaxis(strips.columns.up[column], -1, 0))
    return np.asarray(last.mean(axis=1))
