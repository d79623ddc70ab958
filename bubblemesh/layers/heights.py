"""Heights: how many layers each column has, and by how much these are compressed."""

import numpy as np

from bubblemesh.arrays import Floats, Integers, members
from bubblemesh.layers.columns import LARGEST_RATIO, Columns
from bubblemesh.layers.walls import Walls
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing

FEWEST_LAYERS = 3  # layers, if so many are asked for: where there is no room for them they are compressed
LEAST = 0.02  # factor of compressed layers; below it there are none
WIDEST_APART = 2.0  # distance of columns in terms of the spacing, or of their feet if that is more
PASSES = 1000
PASSING = 1 / 3  # of the spacing at its own place: from a last layer of this height on sizes pass to the triangles
AT_ONCE = 8  # layers of all columns for which the spacing is asked at once
HEIGHT_ROUNDING = 1e-12  # relative: what is just as high as it may be is not lost by it


@record
class Most:
    """Numbers of layers that columns can have where nothing is in their way."""

    count: Integers  # (c,)
    spaced: Integers  # (c,): the same if only what would be higher than the spacing ended them, not that they part
    passing: Integers  # (c,): from which on the last one is not far below the spacing; more than are asked for if none


@record
class Heights:
    """Heights of the columns."""

    most: Most
    requested: Integers  # (c,): number of layers that are asked for
    count: Integers  # (c,): number of layers that there are
    factor: Floats  # (c,): of the heights of these, at most 1


def heights(columns: Columns, room: Floats, possible: Most) -> Heights:
    """Layers that there is room (c,) for, of those that are ``possible``, and at most one fewer from column to column.

    Where few layers have room they are compressed, but in hollows of short edges and beside: else those along much of
    the wall would be so, too. Lower nodes that columns have in common would be too near to the wall.
    """
    most, fitting = possible.count, layers_within(columns, room)
    requested = np.where(columns.are_isotropic, np.maximum(most, 1), columns.requested)
    bound = gradual(columns, np.where(columns.are_in_hollows | columns.are_pinched, np.minimum(fitting, most), most))
    few = np.minimum(FEWEST_LAYERS, most)
    few[bound < few] = 0
    squeezed = np.clip(room / np.maximum(columns.tops(np.arange(len(columns)), few), 1e-300), 0, 1)
    squeezed[few == 0] = 1.0
    count = np.where(squeezed < LEAST, 0, np.clip(fitting, few, most))
    factor = np.where(fitting < few, np.maximum(squeezed, LEAST), 1.0)
    return Heights(possible, requested, *_gradual(columns, count, factor))


def layers_within(columns: Columns, height: Floats) -> Integers:
    """Number (c,) of the layers of each column that are no higher in all than some height (c,)."""
    found = np.zeros(len(columns), np.int64)
    full = height / columns.scale * (1 + HEIGHT_ROUNDING)
    for number, ladder in enumerate(columns.ladders):
        mine = columns.ladder == number
        found[mine] = np.searchsorted(ladder.tops, full[mine], side="right") - 1
    return found


def gradual(columns: Columns, count: Integers) -> Integers:
    """Counts (c,) of layers, or fewer: at most one fewer from column to column."""
    return _gradual(columns, count, np.ones(len(columns)))[0]


def _gradual(columns: Columns, count: Integers, factor: Floats) -> tuple[Integers, Floats]:
    """Counts and factors (c,) that change slowly from column to column."""
    (i, j), (one, other) = columns.pair.T, columns.twins.T
    for _ in range(PASSES):
        fewer, lower = count.copy(), factor.copy()
        for a, b in ((one, other), (other, one)):
            fewer[a], lower[a] = np.minimum(fewer[a], count[b]), np.minimum(lower[a], factor[b])
        for a, b in ((i, j), (j, i)):
            np.minimum.at(fewer, a, count[b] + 1)
            # Where there is no layer its factor says nothing.
            np.minimum.at(lower, a, np.where(count[b] > 0, LARGEST_RATIO * factor[b], np.inf))
        if (fewer == count).all() and (lower == factor).all():
            break
        count, factor = fewer, lower
    return count, factor


def most_layers(columns: Columns, spacing: Spacing) -> Most:
    """Numbers of layers that columns have where nothing is in their way.

    None is higher than the spacing at its middle, nor than it is wide, or than the spacing at the foot where that is
    more and the layers are not ``isotropic``. In a metric that is coarser across the wall than along it, none of these
    is higher in it than it is wide in it. Columns that part end before they are much farther from each other than the
    spacing. All columns of a fan are as wide as those beside it.
    """
    most, spaced, passing = np.zeros(len(columns), np.int64), columns.requested.copy(), columns.requested + 1
    at_foot = widest_at_feet(columns)
    for number, ladder in enumerate(columns.ladders):
        going, full, tops = np.flatnonzero(columns.ladder == number), ladder.heights, ladder.tops[1:]
        for layer in range(ladder.count):
            if layer % AT_ONCE == 0:
                asked, some = going, slice(layer, layer + AT_ONCE)
                middles, spacings = _in_layers(columns, asked, full[some], tops[some], layer + 1, spacing)
                widths = _widest_in_layers(columns, asked, tops[some], layer + 1)
                here = np.arange(len(asked))
            height = columns.scale[going] * full[layer]
            middle, d, widest = (table[layer % AT_ONCE, here] for table in (middles, spacings, widths))
            if ladder.isotropic:
                wide = widest * np.maximum(spacing.stretch(middle, columns.up[going]), 1.0)
            else:
                wide = np.maximum(widest, columns.spacing[going])
            low = height <= np.minimum(wide, d) * (1 + HEIGHT_ROUNDING)
            spaced[going[~low]] = most[going[~low]]
            near = going[height >= PASSING * d]
            passing[near] = np.minimum(passing[near], layer + 1)
            fits = low & (widest <= WIDEST_APART * np.maximum(d, at_foot[going]) * (1 + HEIGHT_ROUNDING))
            going, here = going[fits], here[fits]
            if not len(going):
                break
            most[going] += 1
    return Most(most, spaced, passing)


def _in_layers(
    columns: Columns, which: Integers, heights: Floats, tops: Floats, first: int, spacing: Spacing
) -> tuple[Floats, Floats]:
    """Middles (l, k, 2) of layers of some ``heights`` (l,) below ``tops`` (l,) on columns (k,), and the spacing (l, k).

    The layers are those from number ``first`` on.
    The spacing is that along the columns; outside the domain, if there is none, the foot's: layers that would reach so
    far end where there is room for them.
    """
    scale, each = columns.scale[which], np.tile(which, len(heights))
    number = np.repeat(first + np.arange(len(heights)), len(which))
    middles = columns.places(each, (scale * tops[:, None] - scale * heights[:, None] / 2).ravel(), number)
    d = spacing.anywhere_towards(middles, columns.up[each])
    shape = len(heights), len(which)
    return middles.reshape(*shape, 2), np.where(np.isnan(d), columns.spacing[each], d).reshape(shape)


def _widest_in_layers(columns: Columns, which: Integers, tops: Floats, first: int) -> Floats:
    """Largest widths (l, k) beside columns (k,) at the ``tops`` (l,) of layers from number ``first`` on.

    Neighbours whose layers are higher or lower are as far away as they are at the height of the column's own.
    """
    pair = columns.pair[columns.apart]
    scales = columns.scale[pair].T
    if (scales[0] == scales[1]).all():
        scales = scales[:1]
    numbers = np.repeat(first + np.arange(len(tops)), len(pair))
    widths = list[Floats]()
    for scale in scales:
        height = (scale * tops[:, None]).ravel()
        begin, end = (columns.places(np.tile(column, len(tops)), height, numbers) for column in pair.T)
        widths.append(np.hypot(*(end - begin).T).reshape(len(tops), len(pair)))
    return _widest(columns, widths[0], widths[-1])[:, which]


def widest_at_feet(columns: Columns) -> Floats:
    """Largest width (c,) on the wall beside columns of the same foot or bend, but for fans."""
    i, j = columns.pair[columns.apart].T
    width = np.hypot(*(columns.start[j] - columns.start[i]).T)[None]
    (widest,) = _widest(columns, width, width)
    return widest


def _widest(columns: Columns, of_first: Floats, of_second: Floats) -> Floats:
    """Largest of the widths (l, p) beside columns (c,), those of the first ones of pairs and of the second ones."""
    feet = columns.foot[columns.leader]
    widest = np.zeros((len(of_first), columns.foot.max() + 1))
    for end, width in zip(columns.pair[columns.apart].T, (of_first, of_second), strict=True):
        for wide, there in zip(widest, width, strict=True):
            np.maximum.at(wide, feet[end], there)
    return widest[:, feet]


def reached(columns: Columns, found: Heights, owner: Integers, level: Integers) -> Floats:
    """Heights (k,) above the wall, on the columns (k,), of the ends of their layers numbered ``level`` (k,)."""
    return columns.tops(owner, level) * found.factor[owner]


def column_nodes(columns: Columns, walls: Walls, found: Heights) -> Floats:
    """Nodes (n, 2) of all columns above their feet, one column after the other."""
    owner, rank = members(columns.own(found.count))
    height = reached(columns, found, owner, rank + 1)
    x = columns.places(owner, height, rank + 1)
    on_piece = np.flatnonzero(columns.follows[owner] >= 0)
    x[on_piece] = walls.domain.boundary.points(*on_pieces(columns, walls, owner[on_piece], height[on_piece]))
    return x


def on_pieces(columns: Columns, walls: Walls, owner: Integers, height: Floats) -> tuple[Integers, Floats]:
    """Pieces (k,) that columns follow, and arc lengths (k,) there at some height (k,) of the columns."""
    piece, way = columns.follows[owner], height * np.hypot(*columns.up[owner].T)
    return piece, np.where(columns.from_start[owner], way, walls.domain.boundary.lengths[piece] - way)
