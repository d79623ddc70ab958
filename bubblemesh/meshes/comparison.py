"""Two meshes side by side."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError
from bubblemesh.meshes.histograms import Histogram, lowest_shown, quality_histogram, spacing_histogram
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import (
    TARGET_SPACING,
    Measures,
    SpacingBetween,
    edge_means,
    edge_ratios,
    mesh_figures,
    spacing_fit,
)
from bubblemesh.records import record

BINS = 10
NOTHING = "-"
ROWS: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("nodes", ("nodes",), "d"),
    ("boundary nodes", ("boundary_nodes",), "d"),
    ("triangles", ("triangles",), "d"),
    ("area", ("area",), ".6g"),
    ("mean q", ("quality", "mean"), ".4f"),
    ("1 % of q below", ("quality", "p01"), ".3f"),
    ("least q", ("quality", "min"), ".3f"),
    ("least angle", ("quality", "angle_min"), ".1f"),
    ("largest angle", ("quality", "angle_max"), ".1f"),
    ("irregular nodes", ("quality", "irregular_fraction"), ".1%"),
    ("mean l/d", ("spacing", "mean"), ".3f"),
    ("spread of l/d", ("spacing", "std"), ".3f"),
    ("1 % of l/d below", ("spacing", "p01"), ".2f"),
    ("1 % of l/d above", ("spacing", "p99"), ".2f"),
)


@record
class Compared:
    """Figures of a mesh file, and the ratios for its histograms."""

    path: Path
    figures: dict[str, Any]  # as in `mesh_figures`
    quality: Floats  # (t,) radius ratios of the triangles
    spacing: Floats | None  # (e,) lengths of the edges over the target spacing; None if that is not known


def compared(
    path: Path,
    mesh: Mesh,
    cell_data: Mapping[str, Floats],
    spacing_between: SpacingBetween | None,
) -> Compared:
    """Measure a mesh that was read from a file.

    Parameters
    ----------
    path
        Name of the file, for messages.
    mesh
        The mesh.
    cell_data
        Data (t,) or (t, k) of its triangles; ``target_spacing`` is used if there is no function.
    spacing_between
        Function that returns the target spacing (e,) for the ends (e, 2, 2) of edges, if any.

    Raises
    ------
    CaseError
        If the target spacing is not positive somewhere.
    """
    of_triangles = cell_data.get(TARGET_SPACING)
    measures = Measures(mesh.points, mesh.triangles)
    edges, _ = measures.edges
    figures = mesh_figures(measures, spacing_between)
    target = None
    if spacing_between is not None:
        target = spacing_between(mesh.points, edges)
    elif of_triangles is not None and of_triangles.ndim == 1:
        if not (of_triangles > 0).all():
            raise CaseError(f"{path}: {TARGET_SPACING} is not positive at some triangle: give a spacing")
        target = edge_means(mesh.triangles, of_triangles)
        figures["spacing"] = asdict(spacing_fit(mesh.points, edges, target))
    ratios = None if target is None else edge_ratios(mesh.points, edges, target)
    return Compared(path, figures, measures.radius_ratios, ratios)


def histograms(first: Compared, second: Compared) -> dict[str, list[Histogram | None]]:
    """Histograms of ``quality`` and ``spacing`` of both meshes in the same bins; None if the spacing is not known."""
    both = first, second
    low = lowest_shown(np.concatenate([mesh.quality for mesh in both]))
    return {
        "quality": [quality_histogram(mesh.quality, BINS, low) for mesh in both],
        "spacing": [None if mesh.spacing is None else spacing_histogram(mesh.spacing, BINS) for mesh in both],
    }


def report(first: Compared, second: Compared) -> dict[str, Any]:
    """Figures and histograms of both meshes, and the differences of the figures, second minus first."""
    bins = histograms(first, second)
    meshes = [
        {"mesh": mesh.path, **mesh.figures, "histograms": {name: both[k] for name, both in bins.items()}}
        for k, mesh in enumerate((first, second))
    ]
    return {"meshes": meshes, "differences": _differences(first.figures, second.figures)}


def _differences(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """Differences, second mesh minus first, for each figure that is a number in both."""
    found: dict[str, Any] = {}
    for key in [key for key in first if key in second]:
        a, b = first[key], second[key]
        if isinstance(a, Mapping) and isinstance(b, Mapping):
            found[key] = _differences(a, b)
        elif isinstance(a, int | float) and isinstance(b, int | float):
            found[key] = b - a
    return found


def rows(first: Mapping[str, Any], second: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
    """Name, text of both values and of their difference, for each figure that either mesh has."""
    for name, keys, form in ROWS:
        a, b = (_figure(figures, keys) for figures in (first, second))
        if a is not None or b is not None:
            difference = None if a is None or b is None else b - a
            yield name, _text(a, form), _text(b, form), _text(difference, f"+{form}")


def _text(value: Any, form: str) -> str:
    return NOTHING if value is None else format(value, form)


def _figure(figures: Mapping[str, Any], keys: Sequence[str]) -> Any:
    value: Any = figures
    for key in keys:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value
