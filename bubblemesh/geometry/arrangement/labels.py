"""Labels where pieces run along each other: which of them counts, and which are on no edge in the end."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import OpenPath
from bubblemesh.messages import place


class Along(NamedTuple):
    """Inner pieces (k,) that run along others, and these others (k,), which stay."""

    piece: Integers
    other: Integers


def laid_on_rings(
    boundary: Boundary, lines: int, keep: Booleans, along: Along, polygon: shapely.Polygon | shapely.MultiPolygon
) -> Booleans:
    """Mask (p,) of the pieces of lines that run along rings and have no part inside the domain, the polygon.

    The pieces of the first so many ``lines`` have the ring numbers -1, -2 and so on; ``keep`` (p,) are those that stay.
    """
    number = -1 - boundary.ring
    of_line = (number >= 0) & (number < lines)
    own = np.flatnonzero(of_line & keep)
    inside = own[shapely.contains_xy(polygon, middles(boundary, own))]
    within = along.piece[boundary.inner[along.other]]
    elsewhere = np.isin(number, number[np.append(inside, within)])
    laid = np.zeros(len(number), bool)
    laid[along.piece] = ~boundary.inner[along.other]
    return laid & of_line & ~elsewhere


def with_given_labels(boundary: Boundary, along: Along, laid: Booleans) -> Boundary:
    """The boundary with the labels that count on pieces along which others run.

    Pieces of rings have the labels of lines that are ``laid`` (p,) on them. A label that was made up gives way to one
    that was given; of several, that of a line counts before those of regions, and the first of these.
    """
    piece, other = along
    counts = boundary.named[piece] & (laid[piece] | ~boundary.named[other])
    order = np.lexsort((piece, -boundary.ring[piece], ~laid[piece], other))
    order = order[counts[order]]
    first = order[np.diff(other[order], prepend=-1) != 0]
    piece, other = piece[first], other[first]
    label, named, turned = boundary.label.copy(), boundary.named.copy(), boundary.turned.copy()
    label[other], named[other] = boundary.label[piece], True
    turned[other] = boundary.inner[other] & (boundary.turned[piece] != _opposite(boundary, piece, other))
    return replace(boundary, label=label, named=named, turned=turned)


def _opposite(boundary: Boundary, one: Integers, other: Integers) -> Booleans:
    """Mask (k,) of the pieces that run the other way than the ``other`` ones, along which they lie."""
    tangents = [boundary.tangents(pieces, boundary.lengths[pieces] / 2) for pieces in (one, other)]
    return np.einsum("ij,ij->i", *tangents) < 0


def overlap_notes(boundary: Boundary, lines: Sequence[OpenPath], along: Along) -> tuple[str, ...]:
    """Notes on embedded lines with pieces that run along others, whose labels count."""
    told: dict[str, None] = {}
    for piece, other in zip(*map(np.ndarray.tolist, along), strict=True):
        number = -1 - int(boundary.ring[piece])
        label, own = (boundary.labels[boundary.label[k]] for k in (other, piece))
        if 0 <= number < len(lines) and label != own:
            (middle,) = middles(boundary, np.array([piece]))
            told.setdefault(
                f"the line {lines[number].name} runs along {label!r} at {place(middle)}: that part of it has the label "
                f"{label!r} alone"
            )
    return tuple(told)


def lost_notes(given: Boundary, final: Boundary, along: Along, seen: Booleans) -> tuple[str, ...]:
    """Notes on labels that were given, but that no edge has.

    Parameters
    ----------
    given, final
        All pieces (p,) with the labels that they were given, and with those that count.
    along
        Pieces that run along others.
    seen : (p,)
        Pieces that bound the domain or are inside it, of those that stay.
    """
    stays = np.arange(len(given.kind))
    stays[along.piece] = along.other
    lost = given.named & ~np.isin(given.label, final.label[seen])
    # Of the pieces that had a label, the first one whose place is in the mesh tells most.
    order = np.lexsort((~seen[stays], given.label))
    order = order[lost[order]]
    notes = list[str]()
    for piece in np.sort(order[np.diff(given.label[order], prepend=-1) != 0]).tolist():
        (middle,) = middles(given, np.array([piece]))
        label, there = given.labels[given.label[piece]], final.labels[final.label[stays[piece]]]
        if seen[stays[piece]]:
            where = f"{place(middle)} runs along {there!r} and has the label {there!r} alone"
            notes.append(f"the label {label!r} is on no edge: its side at {where}")
        else:
            notes.append(f"the label {label!r} is on no edge: its side at {place(middle)} is outside the domain")
    return tuple(notes)


def middles(boundary: Boundary, pieces: Integers) -> Floats:
    """Points (k, 2) halfway along pieces (k,)."""
    return boundary.points(pieces, boundary.lengths[pieces] / 2)
