"""Warnings of narrow gaps that regions of files leave open, with what closes them."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import shapely

from bubblemesh.arrays import select
from bubblemesh.case import Case
from bubblemesh.case.domain import RegionFile
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.borders import matched
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.nesting import Shapes
from bubblemesh.geometry.slivers import Slivers, closed, hole_count, slivers
from bubblemesh.messages import counted, just_above, place
from bubblemesh.problem.shapes import length_in_file
from bubblemesh.spacing.spacing import Spacing

NARROW_GAP = 0.2  # spacings: gaps that are narrower are hardly meant
TRIED = (1, 1.5, 2, 3)  # times the widest gap: where three regions meet it takes more than that


def open_gaps(case: Case, domain: Domain, spacing: Spacing) -> Iterator[str]:
    """Warnings, one for each file, of gaps between its regions that are far narrower than the spacing."""
    for number, keys in enumerate(case.domain.regions):
        if isinstance(keys, RegionFile):
            own = [region for region in domain.parts.regions if region.entry == number and region.area.outer.origin]
            shapes = np.array([region.polygon for region in own], dtype=object)
            if len(shapes):
                yield from _open_gaps(keys, shapes, [region.name for region in own], spacing)


def _open_gaps(keys: RegionFile, shapes: Shapes, names: list[str], spacing: Spacing) -> Iterator[str]:
    found = slivers(shapes, names, NARROW_GAP * float(spacing(shapely.get_coordinates(shapes)).max()))
    if len(found.widths):
        found = select(found, found.widths < NARROW_GAP * spacing(found.places))
    if len(found.widths):
        one, other = sorted(names[k] for k in found.beside[0].tolist())
        count, stay = counted(len(found.widths), "narrow gap"), "stays" if len(found.widths) == 1 else "stay"
        yield (
            f"{Path(keys.file).name}: {count} between regions {stay} open, the widest "
            f"({found.widths[0]:.2g}) between {one!r} and {other!r} at {place(found.places[0])}"
            f"{_advice(keys, shapes, names, found)}"
        )


def _advice(keys: RegionFile, shapes: Shapes, names: list[str], found: Slivers) -> str:
    """The key, with its value in the file's lengths, that closes gaps, if there is one."""
    factor = length_in_file(keys)
    if factor is None:
        return ""
    join = _join(shapes, names, float(found.widths[0]), factor, keys.join or 0.0)
    if join is not None:
        return f": set join: {join} to close what is not meant"
    largest = float(found.holes.max())
    return f": set smallest: {just_above(largest / factor**2)} to fill those that are holes" if largest > 0 else ""


def _join(shapes: Shapes, names: list[str], width: float, factor: float, given: float) -> str | None:
    """The value of ``join``, in lengths of ``factor`` each, that closes gaps up to a width, if there is one.

    It is larger than the ``given`` one, which left them open.
    """
    for join in (just_above(times * width / factor) for times in TRIED):
        if float(join) <= given:
            continue
        with suppress(GeometryError):
            found = matched(shapes, names, float(join) * factor).shapes
            if hole_count(shapely.union_all(found)) <= hole_count(closed(shapely.union_all(shapes), width)):
                return join
    return None
