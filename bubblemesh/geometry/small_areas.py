"""Small areas and holes among neighbours: they become part of what is beside them, so that no hole is left."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely

from bubblemesh.arrays import Integers
from bubblemesh.geometry.neighbours import common_holes, merged, owners, united
from bubblemesh.geometry.nesting import Shapes, enclosures, holes_of, polygons_of, smallest_around
from bubblemesh.messages import counted, listed, place


class Absorbed(NamedTuple):
    """Polygons that are left, with their names, and what became of small ones and of holes."""

    shapes: list[shapely.Polygon]
    names: list[str]
    owner: Integers  # (n,), number of the given polygon that each one is, or is a part of now; -1 if it is left out
    filled: list[shapely.Polygon]  # holes that are filled

    @property
    def left(self) -> list[int]:
        """Numbers of the given polygons that are left out."""
        return np.flatnonzero(self.owner < 0).tolist()

    @property
    def given(self) -> list[int]:
        """Numbers of the given polygons that are a part of another one."""
        return np.flatnonzero((self.owner >= 0) & (self.owner != np.arange(len(self.owner)))).tolist()


def absorbed(shapes: Shapes, names: Sequence[str], smallest: float, curved: bool = False) -> Absorbed:
    """Valid polygons (n,) that may share borders, without those of less area than ``smallest``, and without such holes.

    A small one becomes part of the polygon or the hole around it, else of the neighbour with the longest common border.
    So does a hole, also one between several polygons. Polygons of one name that come to have a common border become
    one. All others stay as they are. If these are copies of ``curved`` areas outer rings stay as well: a small one
    between several is left out.
    """
    count = len(shapes)
    small = shapely.area(shapely.polygons(shapely.get_exterior_ring(shapes))) < smallest
    holes = holes_of(shapes) if curved else common_holes(np.delete(shapes, enclosures(shapes, shapes)[0]))
    holes = holes[shapely.area(holes) < smallest]
    pieces = np.concatenate([shapes, holes])
    around = np.append(smallest_around(shapes, pieces), np.full(len(holes), -1))
    free = np.append(small, np.ones(len(holes), bool)) | (around >= count)
    flat, within = np.flatnonzero(around < 0), np.flatnonzero(free & (around >= 0))
    to = owners(pieces[flat], free[flat], surrounded=curved)
    owner = np.arange(len(pieces))
    owner[flat] = np.where(to < 0, -1, flat[to])
    for number in within[np.argsort(-shapely.area(pieces[within]), kind="stable")].tolist():
        owner[number] = owner[around[number]]
    whole = pieces.copy()
    whole[flat], whole[within] = merged(pieces[flat], to), None
    kept = [number for number in range(count) if whole[number] is not None]
    larger = {names[number] for number in kept if whole[number] is not shapes[number] and not curved}
    rows = list(_united_by_name(whole[kept], [names[number] for number in kept], larger))
    return Absorbed(
        [shape for shape, _ in rows], [name for _, name in rows], owner[:count], holes[owner[count:] >= 0].tolist()
    )


def _united_by_name(shapes: Shapes, names: Sequence[str], larger: set[str]) -> Iterator[tuple[shapely.Polygon, str]]:
    """The polygons with their names; those of a name that has become ``larger`` are one where they share a border."""
    of = np.array(names, dtype=object)
    for name in dict.fromkeys(names):
        own = shapes[of == name]
        yield from ((part, name) for part in (polygons_of(united(own)) if name in larger else own))


def notes_of(found: Absorbed, shapes: Sequence[shapely.Polygon], names: Sequence[str], smallest: float) -> list[str]:
    """Notes on the polygons below ``smallest`` that others have absorbed, or that are left out."""
    notes = []
    for numbers, fate in ((found.given, "given to a neighbour"), (found.left, "left out and given to none")):
        if numbers:
            one = max(numbers, key=lambda number: shapes[number].area)
            to = "" if found.owner[one] < 0 else f" to {names[found.owner[one]]!r}"
            where = place(shapely.get_coordinates(shapely.point_on_surface(shapes[one]))[0])
            largest = f"the largest ({shapes[one].area:.3g}) of {names[one]!r}{to} at {where}"
            notes.append(f"{counted(len(numbers), 'area')} below {smallest:g} {fate}, {largest}")
    gone = [repr(name) for name in dict.fromkeys(names) if name not in found.names]
    return [*notes, f"all of {listed(gone)} is below {smallest:g}: no such region is left"] if gone else notes
