"""Terms of a spacing whose values are in files: read, and made functions of the place."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.case.data_terms import FieldTerm, ImageTerm, RasterTerm, ScatteredTerm, several
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.errors import CaseError, Key, at_key, prefixed
from bubblemesh.meshfiles.read import read_field
from bubblemesh.readers.arrays import read_gridded
from bubblemesh.readers.images import read_grey
from bubblemesh.readers.tables import read_columns
from bubblemesh.spacing.terms.field import Field
from bubblemesh.spacing.terms.raster import Raster
from bubblemesh.spacing.terms.scattered import scattered

Sampled = Field | Raster


def sampled_terms(terms: SpacingTerms) -> dict[Key, Sampled]:
    """The terms given by values on meshes, on grids, by pictures and at points, by their keys.

    Raises
    ------
    CaseError, FileError
        With the key, the file and the place in it.
    """
    made: list[tuple[str, Callable[[Any], Sampled]]] = [
        ("field", _field),
        ("raster", _raster),
        ("image", _image),
        ("scattered", _scattered),
    ]
    found = {}
    for key, of in made:
        models: tuple[Any, ...] = several(getattr(terms, key))
        for number, model in enumerate(models):
            path = Key(["spacing", key, *([number] if len(models) > 1 else [])])
            with at_key(*path):
                found[path] = of(model)
    return found


def elsewhere(key: Key, data: Sampled, bounds: Sequence[float]) -> str | None:
    """A warning if data lies wholly outside a domain with the bounds (x0, y0, x1, y1)."""
    (x0, y0, x1, y1), (left, low, right, high) = data.bounds, bounds
    if x0 <= right and left <= x1 and y0 <= high and low <= y1:
        return None
    return (
        f"{key}: the data is in {_box(data.bounds)}, the domain in {_box(bounds)}: they do not meet, so that only "
        "values at the rim of the data count"
    )


def _box(bounds: Sequence[float]) -> str:
    x0, y0, x1, y1 = bounds
    return f"[{x0:.6g}, {x1:.6g}] x [{y0:.6g}, {y1:.6g}]"


def _field(term: FieldTerm) -> Sampled:
    data = read_field(Path(term.file), term.name)
    with prefixed(f"{term.file}: {data.name}"):
        if data.at_points:
            return Field.of(data.points, data.triangles, data.values).scaled(term.scale)
        return Field.of_triangles(data.points, data.triangles, data.values, data.cells).scaled(term.scale)


def _raster(term: RasterTerm) -> Sampled:
    with prefixed(term.file):
        data = read_gridded(Path(term.file), term.name)
        with prefixed(data.name):
            if term.bounds is not None:
                return Raster.within(term.bounds, data.values, upper=term.origin == "upper").scaled(term.scale)
            if data.x is None or data.y is None:
                raise CaseError("has no arrays x and y with it: give bounds, the rectangle that its pixels fill")
            if term.origin == "upper":
                raise CaseError("has an array y with it, which says where its rows are: leave origin out")
            return Raster.of(data.x, data.y, data.values).scaled(term.scale)


def _image(term: ImageTerm) -> Sampled:
    with prefixed(term.file):
        grey = read_grey(Path(term.file))
        return Raster.within(term.bounds, term.finest + (term.coarsest - term.finest) * grey, upper=True)


def _scattered(term: ScatteredTerm) -> Sampled:
    if term.file is None:
        samples = np.array(term.points, float)
        return scattered(samples[:, :2], samples[:, 2]).scaled(term.scale)
    with prefixed(term.file):
        samples = read_columns(Path(term.file), ("x", "y", "d"))
        return scattered(samples[:, :2], samples[:, 2]).scaled(term.scale)
