"""Warnings of narrow gaps that regions of files leave open, with what closes them."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import shapely

from bubblemesh.case import Case
from bubblemesh.case.domain import RegionFile
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.borders import matched
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.nesting import Shapes
from bubblemesh.geometry.slivers import closed, hole_count, slivers
from bubblemesh.messages import counted, just_above, place
from bubblemesh.problem.shapes import length_in_file
from bubblemesh.spacing.spacing import Spacing

NARROW = 0.2  # spacings: gaps that are narrower are hardly meant
TRIED = (1, 1.5, 2, 3)  # times the widest gap: where three regions meet it takes more than that


def open_gaps(case: Case, domain: Domain, spacing: Spacing) -> Iterator[str]:
    """Warnings, one for each file, of gaps between its regions that are far narrower than the spacing."""
    for number, keys in enumerate(case.domain.regions):
        if isinstance(keys, RegionFile) and keys.join is None:
            own = [region for region in domain.parts.regions if region.entry == number]
            shapes = np.array([region.polygon for region in own], dtype=object)
            yield from _open_gaps(keys, shapes, [region.name for region in own], spacing)


def _open_gaps(keys: RegionFile, shapes: Shapes, names: list[str], spacing: Spacing) -> Iterator[str]:
    found = slivers(shapes, names, NARROW * float(spacing(shapely.get_coordinates(shapes)).max()))
    if len(found.widths):
        keep = found.widths < NARROW * spacing(found.places)
        wide, places, beside = found.widths[keep], found.places[keep], found.beside[keep]
        if len(wide):
            one, other = sorted(names[k] for k in beside[0].tolist())
            join = _join(keys, shapes, names, float(wide[0]))
            yield (
                f"{Path(keys.file).name}: {counted(len(wide), 'narrow gap')} between regions stay open, the widest "
                f"({wide[0]:.2g}) between {one!r} and {other!r} at {place(places[0])}"
                + (f": set join: {join} to close what is not meant" if join else "")
            )


def _join(keys: RegionFile, shapes: Shapes, names: list[str], width: float) -> str | None:
    """The value of ``join``, in the file's lengths, that closes gaps up to a width, if they can be closed so."""
    factor = length_in_file(keys)
    if factor is None:
        return None
    for times in TRIED:
        join = just_above(times * width / factor)
        with suppress(GeometryError):
            found = matched(shapes, names, float(join) * factor).shapes
            if hole_count(shapely.union_all(found)) <= hole_count(closed(shapely.union_all(shapes), width)):
                return join
    return None
