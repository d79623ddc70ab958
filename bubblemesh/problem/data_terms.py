"""Data terms of a spacing: their values read, and made functions of the place."""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.case.data_terms import DataTerm, FieldTerm, FunctionTerm, ImageTerm, RasterTerm, ScatteredTerm
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.errors import CaseError, Key, at_key, prefixed
from bubblemesh.files import local_copy
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.systems import same_system
from bubblemesh.meshfiles.fields import read_field
from bubblemesh.messages import extent, given_coordinates
from bubblemesh.problem.crs import given_bounds, given_system
from bubblemesh.readers.grids.grids import Box, Grid, filled_from_nearest, is_grid, read_grid, system_of
from bubblemesh.readers.grids.rasters import read_grey, read_gridded
from bubblemesh.readers.tables import read_columns
from bubblemesh.spacing.terms.field import MeshField, scattered
from bubblemesh.spacing.terms.function import CheckedFunction
from bubblemesh.spacing.terms.raster import Raster

SMALLEST_SHARE = 0.01  # of a domain beyond a raster that is told
FAR_LARGER = 30  # times the size of the domain: a field may be in another unit
RasterNames = Mapping[str, Raster]  # rasters by the names that expressions have for them


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


Read = tuple[DataFunction, list[str]]  # with notes on what is missing or left out of it


@given_coordinates()
def data_functions(
    terms: SpacingTerms, box: Box, system: str | None, others: Container[str]
) -> tuple[dict[Key, DataFunction], tuple[str, ...]]:
    """Functions of the data terms around a box in a system, by their keys, but for rasters by ``others`` names.

    With them come notes on what is missing or left out. The box is (x0, y0, x1, y1). Errors have the key, the file and
    the place in it.
    """
    found: dict[Key, DataFunction] = {}
    notes: list[str] = []
    for key, model in _models(terms):
        if not (isinstance(model, RasterTerm) and model.known_as in others):
            with at_key(*key):
                found[key], more = FUNCTIONS[type(model)](model, box, system)
            notes += more
    return found, tuple(notes)


@given_coordinates()
def raster_variables(
    terms: SpacingTerms, domain: Domain, names: Container[str]
) -> tuple[dict[str, Raster], tuple[str, ...]]:
    """The rasters by some names, around a domain, and notes on them; the same errors as `data_functions`.

    CaseError if two have one name.
    """
    box, system = given_bounds(domain), given_system(domain)
    functions: dict[str, Raster] = {}
    notes: list[str] = []
    for key, model in _models(terms):
        if isinstance(model, RasterTerm) and model.known_as in names:
            with at_key(*key):
                if model.known_as in functions:
                    raise CaseError(f"{model.known_as!r} is the name of another raster too: give one of them by name")
                functions[model.known_as], more = _grid(model, box, system)
            notes += [*more, *coverage_notes(key, functions[model.known_as], domain)]
    return functions, tuple(notes)


def rasters_in(
    file: str, bounds: Box | None, names: Sequence[str], box: Box, system: str | None
) -> tuple[tuple[Raster, ...], tuple[str, ...]]:
    """The rasters by some names in a file, around a box in a system, and notes on them; errors have the file.

    The ``bounds`` are those of the pixels, if the file does not tell where these are. What one of them misses in a
    pixel, all miss there: they are numbers of one thing.
    """
    terms = [RasterTerm(file=file, name=name, bounds=bounds) for name in names]
    if not is_grid(Path(file)):
        return tuple(_array(term, signed=True) for term in terms), ()
    grids = [_around(term, box, system) for term in terms]
    if len({grid.values.shape for grid in grids}) == 1:
        lacking = np.isnan([grid.values for grid in grids]).any(axis=0)
        grids = [grid._replace(values=np.where(lacking, np.nan, grid.values)) for grid in grids]
    found, notes = zip(*(_complete(term, grid) for term, grid in zip(terms, grids, strict=True)), strict=True)
    return found, tuple(dict.fromkeys(note for several in notes for note in several))


def raster_step(raster: Raster, domain: Domain) -> float:
    """The least distance between neighbouring pixels of a raster, near the middle of a domain and in its plane."""
    x0, y0, x1, y1 = given_bounds(domain)
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    dx, dy = (np.abs(np.diff(at)).min(initial=np.inf) for at in (raster.x, raster.y))
    if domain.plane is None or not np.isfinite([dx, dy]).all():
        return float(min(dx, dy))
    middle, east, north = domain.plane.to(np.array([[x, y], [x + dx, y], [x, y + dy]]))
    return float(min(np.hypot(*(east - middle)), np.hypot(*(north - middle))))


def _models(terms: SpacingTerms) -> Iterator[tuple[Key, DataTerm]]:
    """The data terms with their keys."""
    for name, models in terms.data.items():
        for number, model in enumerate(models):
            yield Key(["spacing", name, *([number] if len(models) > 1 else [])]), model


def coverage_notes(key: Key, data: DataFunction, domain: Domain) -> Iterator[str]:
    """Warning if data lies wholly outside a domain, or a raster does not reach over a part of it."""
    bounds = given_bounds(domain)
    (x0, y0, x1, y1), (left, low, right, high) = data.bounds, bounds
    if not (x0 <= right and left <= x1 and y0 <= high and low <= y1):
        yield (
            f"{key}: the data is in {extent(data.bounds)}, the domain in {extent(bounds)}: they do not meet, so that "
            "only values at the rim of the data count"
        )
    elif isinstance(data, MeshField) and _is_beside_one_cell(data, bounds):
        yield (
            f"{key}: the data is in {extent(data.bounds)}, without a node in the domain, which is in {extent(bounds)}: "
            "are its units those of the domain?"
        )
    elif isinstance(data, Raster) and (beyond := _share_beyond(data.bounds, domain)) >= SMALLEST_SHARE:
        yield (
            f"{key}: {beyond:.0%} of the domain is beyond the data, which is in {extent(data.bounds)}: nearest values "
            "count there"
        )


def _is_beside_one_cell(data: MeshField, box: Box) -> bool:
    """Whether a field is far larger than a box (x0, y0, x1, y1), and has no node in it."""
    low, high = np.array(data.bounds).reshape(2, 2)
    (x0, y0, x1, y1), (x, y) = box, data.points[data.triangles.ravel()].T
    within = (x0 <= x) & (x <= x1) & (y0 <= y) & (y <= y1)
    return bool((high - low).max() > FAR_LARGER * max(x1 - x0, y1 - y0) and not within.any())


def _share_beyond(box: Box, domain: Domain) -> float:
    """Share of the area of a domain that lies outside a box (x0, y0, x1, y1), in the given coordinates."""
    x0, y0, x1, y1 = given_bounds(domain)
    if box[0] <= x0 and box[1] <= y0 and box[2] >= x1 and box[3] >= y1:
        return 0.0
    given = domain.polygon if domain.plane is None else shapely.transform(domain.polygon, domain.plane.given)
    within = shapely.clip_by_rect(given, max(box[0], x0), max(box[1], y0), min(box[2], x1), min(box[3], y1))
    return float(1 - within.area / given.area)


def _field(term: FieldTerm, box: Box, system: str | None) -> Read:
    data = read_field(Path(term.file), term.name)
    with prefixed(f"{term.file}: {data.name}"):
        if data.at_points:
            field = MeshField.of(data.points, data.triangles, data.values)
        else:
            field = MeshField.of_triangles(data.points, data.triangles, data.values, data.cells)
        return field.scaled(term.scale), []


def _raster(term: RasterTerm, box: Box, system: str | None) -> Read:
    return _grid(term, box, system, signed=False)


def _array(term: RasterTerm, *, signed: bool) -> Raster:
    """A raster of NumPy's files."""
    with prefixed(term.file):
        data = read_gridded(Path(term.file), term.name)
        with prefixed(data.name):
            if term.bounds is not None:
                upper = term.origin == "upper"
                return Raster.within(term.bounds, data.values, upper=upper, signed=signed).scaled(term.scale)
            if data.x is None or data.y is None:
                raise CaseError("has no arrays x and y with it: give bounds, the rectangle that its pixels fill")
            if term.origin == "upper":
                raise CaseError("has an array y with it, which says where its rows are: leave origin out")
            return Raster.of(data.x, data.y, data.values, signed=signed).scaled(term.scale)


def _grid(term: RasterTerm, box: Box, system: str | None, *, signed: bool = True) -> tuple[Raster, list[str]]:
    """A raster that may have places of its own, around a box, and notes on what is missing or left out of it."""
    if not is_grid(Path(term.file)):
        return _array(term, signed=signed), []
    return _complete(term, _around(term, box, system), signed=signed)


def _around(term: RasterTerm, box: Box, system: str | None) -> Grid:
    """The values around a box of a raster that has places of its own."""
    with prefixed(term.file):
        if term.bounds is not None or term.origin == "upper":
            raise CaseError("says itself where its pixels are: leave bounds and origin out")
        path = local_copy(Path(term.file))
        own = None if system is None else system_of(path)
        if system is not None and own is not None and not same_system(system, own):
            raise CaseError(f"is in another system than crs.from: take it there by gdalwarp -t_srs {system}")
        return read_grid(path, term.name, box)


def _complete(term: RasterTerm, grid: Grid, *, signed: bool = True) -> tuple[Raster, list[str]]:
    """A raster of values around a box, where some may be missing, and notes on what is missing or left out."""
    with prefixed(term.file):
        values, missing = filled_from_nearest(grid.values)
        notes = []
        if missing:
            notes.append(f"{term.file}: {missing:.1%} of the values around the domain are missing: nearest ones count")
        if grid.step > 1:
            notes.append(f"{term.file}: of {grid.step} pixels in each direction one is read: it has very many")
        with prefixed(grid.name):
            return Raster.of(grid.x, grid.y, values, signed=signed).scaled(term.scale), notes


def _image(term: ImageTerm, box: Box, system: str | None) -> Read:
    with prefixed(term.file):
        grey = read_grey(Path(term.file))
        return Raster.within(term.bounds, term.finest + (term.coarsest - term.finest) * grey, upper=True), []


def _scattered(term: ScatteredTerm, box: Box, system: str | None) -> Read:
    with nullcontext() if term.file is None else prefixed(term.file):
        given = np.array(term.points, float) if term.file is None else read_columns(Path(term.file), ("x", "y", "d"))
        return scattered(given[:, :2], given[:, 2]).scaled(term.scale), []


def _function(term: FunctionTerm, box: Box, system: str | None) -> Read:
    """A function of a program; what is made of data, such as a `MeshField`, is known already."""
    if isinstance(term.function, MeshField | Raster):
        return term.function, []
    return CheckedFunction(term.function, term.key), []


FUNCTIONS: dict[type[DataTerm], Callable[[Any, Box, str | None], Read]] = {
    FieldTerm: _field,
    RasterTerm: _raster,
    ImageTerm: _image,
    ScatteredTerm: _scattered,
    FunctionTerm: _function,
}
