"""The sea in a box as a spacing can show it: without narrow channels, with no more detail than is of use."""

import shapely

from bubblemesh.case.domain import ShoreDomain
from bubblemesh.problem.shoreline.box import Sea
from bubblemesh.problem.shoreline.channels import without_narrow
from bubblemesh.problem.shoreline.simplification import simplified
from bubblemesh.problem.shoreline.thinning import ShoreDetail, SpacingAt


def fitted_sea(sea: Sea, keys: ShoreDomain, spacing: SpacingAt) -> Sea:
    """The sea without narrow channels and with the detail that a spacing can show."""
    shore = keys.shoreline
    if shore.narrowest is not None:
        given = shapely.get_coordinates(sea.parts)
        sea = without_narrow(sea, spacing, shore.narrowest, shore.smallest or 0.0)
        # Of the arcs that close channels no more points stay than the spacing can show.
        sea = sea._replace(parts=[simplified(part, sea.sides, ShoreDetail(spacing), given) for part in sea.parts])
    if shore.detail is None:
        return sea
    detail = ShoreDetail(spacing) if shore.detail == "auto" else ShoreDetail.of_length(shore.detail)
    parts = [simplified(part, sea.sides, detail) for part in sea.parts]
    before, after = (len(shapely.get_coordinates(which)) for which in (sea.parts, parts))
    if after == before:
        return sea
    note = f"{before - after:,} of {before:,} points of the shore left out, which its detail does not need"
    return sea._replace(parts=parts, notes=(*sea.notes, note))
