"""Embedded lines of which no piece is left: those that lie on other lines count once, others are mistakes."""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import select
from bubblemesh.errors import GeometryError, about
from bubblemesh.geometry.arrangement.labels import Along
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import OpenPath
from bubblemesh.messages import counted, listed, place


class Gone(NamedTuple):
    """A line of which no piece is left, and where its pieces are."""

    line: OpenPath
    at: str  # middle of the first of its pieces
    outside: bool  # some are outside of the domain
    on_rings: list[str]  # labels of parts of the boundary on which others lie
    on_lines: list[OpenPath]
    nameless: bool  # no piece on the boundary has a label that was given, which it would give to the boundary
    loses: bool  # a label that was given, since these lines have others

    @property
    def where(self) -> str:
        """Where the line lies, with the names of what it lies on."""
        ways = ["outside the domain"] if self.outside else []
        ways += [f"on the boundary of the domain, {listed(list(map(repr, self.on_rings)))}"] if self.on_rings else []
        noun = "line" if len(self.on_lines) == 1 else "lines"
        ways += [f"on the {noun} {listed([line.name for line in self.on_lines])}"] if self.on_lines else []
        return " and ".join(ways) + (" after join" if self.is_joined else "")

    @property
    def is_joined(self) -> bool:
        """Whether it lies on something since ends have been moved, its own or those of a line below it."""
        lies_on = bool(self.on_rings or self.on_lines)
        return lies_on and any(line.joined for line in (self.line, *self.on_lines))

    @property
    def advice(self) -> str:
        """What to do about it."""
        if self.is_joined:
            return "make join smaller, or remove the line"
        if self.on_lines:
            return "move or remove it, or give both one label"
        if self.nameless:
            return "give it a label, which that part of the boundary gets, or remove it"
        is_entry = "lines" in self.line.key and not self.on_rings
        return "move or remove it" + (", or leave it out by outside: skip" if is_entry else "")


def covered_lines(
    boundary: Boundary,
    lines: Sequence[OpenPath],
    left: AbstractSet[int],
    along: Along,
    polygon: shapely.Polygon | shapely.MultiPolygon,
) -> tuple[list[int], tuple[str, ...]]:
    """Ring numbers of the lines that count as those on which they lie, and a note on them.

    Parameters
    ----------
    boundary
        Noded pieces of the rings, lines and regions.
    lines
        Lines, whose pieces have the ring numbers -1, -2 and so on.
    left
        Ring numbers of which pieces are left.
    along
        Inner pieces that are dropped, and those along which they run.
    polygon
        The domain.

    Raises
    ------
    GeometryError
        About the first line that has no piece left but for another reason, or whose label would be lost.
    """
    numbers = [-number for number in range(1, len(lines) + 1) if -number not in left]
    gone = [_gone(boundary, lines, number, along, polygon) for number in numbers]
    for one in gone:
        if one.loses or not one.on_lines:
            with about(one.line.key):
                raise GeometryError(f"the line {one.line.name} at {one.at} lies {one.where}: {one.advice}")
    if not gone:
        return [], ()
    first = gone[0]
    some = f"{counted(len(gone), 'line')} left out, of which all lies on others, the first, {first.line.name} at "
    return numbers, (f"{some}{first.at}, {first.where}",)


def _gone(
    boundary: Boundary,
    lines: Sequence[OpenPath],
    number: int,
    along: Along,
    polygon: shapely.Polygon | shapely.MultiPolygon,
) -> Gone:
    """Where the line with a ring number is."""
    line = lines[-1 - number]
    own = np.flatnonzero(boundary.ring == number)
    piece, other = select(along, np.isin(along.piece, own))
    ringed = ~boundary.inner[other]
    middle = boundary.points(own, boundary.lengths[own] / 2)
    inside = own[shapely.contains_xy(polygon, middle)]
    lined = ~ringed & np.isin(piece, inside)
    mine, theirs = boundary.label[piece[lined]], boundary.label[other[lined]]
    return Gone(
        line,
        at=place(middle[0]),
        outside=not np.isin(own, np.append(inside, piece[ringed])).all(),
        on_rings=[boundary.labels[k] for k in dict.fromkeys(boundary.label[other[ringed]].tolist())],
        on_lines=[lines[-1 - k] for k in dict.fromkeys(boundary.ring[other[lined]].tolist())],
        nameless=bool(ringed.any()) and not boundary.named[piece[ringed]].any(),
        loses=bool((boundary.named[piece[lined]] & (mine != theirs)).any()),
    )
