"""Metrics in files: of meshes, and of rasters."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bubblemesh.case.metric import FieldMetric
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.files import local_copy
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.meshes.tensors import area_sizes, require_positive_definite
from bubblemesh.meshfiles.metric import read_metric
from bubblemesh.messages import given_coordinates, place
from bubblemesh.problem.crs import given_bounds, given_system, require_given
from bubblemesh.problem.data_terms import rasters_in
from bubblemesh.problem.ellipses import Entries
from bubblemesh.readers.grids.grids import Box, is_grid
from bubblemesh.readers.grids.netcdf import netcdf
from bubblemesh.spacing.cover import Cover
from bubblemesh.spacing.metric.field import TensorField
from bubblemesh.spacing.metric.metric import EllipsesAt
from bubblemesh.spacing.terms.raster import Raster

ENTRIES = "m11", "m12", "m22"  # names of the rasters in a file
NEGLIGIBLE_AREA = 0.01  # of the domain: what polygons in place of curves leave out


@given_coordinates()
def read_ellipses(model: FieldMetric, domain: Domain) -> tuple[EllipsesAt, tuple[str, ...]]:
    """The metric in a file, and notes on what was chosen of it; CaseError or FileError if it holds none."""
    if _has_rasters(Path(model.file)):
        return _read_rasters(model, domain)
    if model.bounds is not None:
        raise CaseError(f"bounds: {model.file} is no file of arrays, whose pixels they are for: leave bounds out")
    read = read_metric(Path(model.file), model.name, chosen_by="name")
    with prefixed(model.file):
        _require_meeting("mesh", (*read.points.min(axis=0).tolist(), *read.points.max(axis=0).tolist()), domain)
    field = TensorField.of(read.points, read.triangles, read.values)
    notes = tuple(f"{model.file}: {note}" for note in (*read.notes, *_left_out("mesh", field, domain)))
    return field, notes


def _has_rasters(path: Path) -> bool:
    """Whether a file has rasters; a NetCDF file has, if it has a grid m11: others may be of meshes."""
    if path.suffix.lower() != ".nc":
        return path.suffix.lower() == ".npz" or is_grid(path)
    with prefixed(path), netcdf(local_copy(path)) as variables:
        return ENTRIES[0] in variables and len(variables[ENTRIES[0]].shape) >= 2


def _read_rasters(model: FieldMetric, domain: Domain) -> tuple[EllipsesAt, tuple[str, ...]]:
    """The metric in three rasters of a file, with notes; the same errors as `_read`."""
    if model.name is not None:
        raise CaseError(f"name: the rasters of {model.file} are m11, m12 and m22: leave name out")
    box, system = given_bounds(domain), given_system(domain)
    found, notes = rasters_in(model.file, model.bounds, ENTRIES, box, system)
    first = found[0]
    with prefixed(model.file):
        _require_meeting("grid", first.bounds, domain)
        if any(not (np.array_equal(one.x, first.x) and np.array_equal(one.y, first.y)) for one in found):
            raise CaseError("m11, m12 and m22 have pixels at other places: write them on one grid")
        if all(np.array_equal(one.values, first.values) for one in found):
            raise CaseError(
                "has one grid, and a metric takes three: write m11, m12 and m22 as bands of these names, or give each "
                "grid a name under spacing.raster and set m11: raster.NAME, m12 and m22 likewise"
            )
        tensors = np.column_stack([one.values.ravel() for one in found])
        columns = len(first.x)
        require_positive_definite(area_sizes(tensors), lambda k: (first.x[k % columns], first.y[k // columns]))
    return Entries(*found), (*notes, *(f"{model.file}: {note}" for note in _left_out("grid", first, domain)))


def _left_out(what: str, data: TensorField | Raster, domain: Domain) -> Iterator[str]:
    """Note on the part of a domain that data does not reach."""
    corners = Cover(domain).corners
    middles, areas = corners.mean(axis=1), np.abs(doubled_areas(corners))
    outside = ~data.holds(middles if domain.plane is None else domain.plane.given(middles))
    share = areas[outside].sum() / areas.sum()
    if share > NEGLIGIBLE_AREA:
        yield f"its {what} leaves out about {share:.0%} of the domain: there the tensors at its nearest places count"


def _require_meeting(what: str, bounds: Box, domain: Domain) -> None:
    """CaseError if the box (x0, y0, x1, y1) of data lies beside a domain, or cannot be one of its coordinates."""
    require_given(bounds, domain)
    (left, low, right, high), (x0, y0, x1, y1) = bounds, given_bounds(domain)
    if left > x1 or right < x0 or low > y1 or high < y0:
        raise CaseError(
            f"its {what}, from {place((left, low))} to {place((right, high))}, lies beside the domain, which is from "
            f"{place((x0, y0))} to {place((x1, y1))}"
        )
