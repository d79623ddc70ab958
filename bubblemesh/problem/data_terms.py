"""Data terms of a spacing: their values read, and made functions of the place."""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.case.data_terms import DataTerm, FieldTerm, ImageTerm, RasterTerm, ScatteredTerm
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.errors import CaseError, Key, at_key, prefixed
from bubblemesh.meshfiles.read import read_field
from bubblemesh.readers.rasters import read_grey, read_gridded
from bubblemesh.readers.tables import read_columns
from bubblemesh.spacing.terms.field import MeshField, scattered
from bubblemesh.spacing.terms.raster import Raster


class DataFunction(Protocol):
    """A spacing made of data."""

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Box (x0, y0, x1, y1) of the data."""

    @property
    def spots(self) -> Floats:
        """Places (k, 2) at which it is fine over a short distance."""

    def __call__(self, x: Floats, y: Floats) -> Floats:
        """Values (m,) at x (m,) and y (m,)."""


def data_functions(terms: SpacingTerms) -> dict[Key, DataFunction]:
    """Functions of the data terms, by their keys; errors have the key, the file and the place in it."""
    found = {}
    for name, models in terms.data.items():
        for number, model in enumerate(models):
            key = Key(["spacing", name, *([number] if len(models) > 1 else [])])
            with at_key(*key):
                found[key] = FUNCTIONS[type(model)](model)
    return found


def elsewhere(key: Key, data: DataFunction, bounds: Sequence[float]) -> str | None:
    """Warning if data lies wholly outside a domain with the bounds (x0, y0, x1, y1)."""
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


def _field(term: FieldTerm) -> DataFunction:
    data = read_field(Path(term.file), term.name)
    with prefixed(f"{term.file}: {data.name}"):
        if data.at_points:
            return MeshField.of(data.points, data.triangles, data.values).scaled(term.scale)
        return MeshField.of_triangles(data.points, data.triangles, data.values, data.cells).scaled(term.scale)


def _raster(term: RasterTerm) -> DataFunction:
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


def _image(term: ImageTerm) -> DataFunction:
    with prefixed(term.file):
        grey = read_grey(Path(term.file))
        return Raster.within(term.bounds, term.finest + (term.coarsest - term.finest) * grey, upper=True)


def _scattered(term: ScatteredTerm) -> DataFunction:
    with nullcontext() if term.file is None else prefixed(term.file):
        given = np.array(term.points, float) if term.file is None else read_columns(Path(term.file), ("x", "y", "d"))
        return scattered(given[:, :2], given[:, 2]).scaled(term.scale)


FUNCTIONS: dict[type[DataTerm], Callable[[Any], DataFunction]] = {
    FieldTerm: _field,
    RasterTerm: _raster,
    ImageTerm: _image,
    ScatteredTerm: _scattered,
}
