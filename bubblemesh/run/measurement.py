"""The mesh of a packing, with its figures: whole, or in slices where it was packed in parts and stays so."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.following import Deviation, deviation
from bubblemesh.meshes.areas_and_lengths import areas_and_lengths, label_lengths
from bubblemesh.meshes.census import Census
from bubblemesh.meshes.conformity import (
    area_error,
    enclosed_area,
    require_area,
    require_conforming,
    require_matching_nodes,
    require_piece,
)
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import ENTRIES, MeasuresInMetric
from bubblemesh.meshes.quality import LAYER, TARGET_SPACING, Measures, mesh_figures
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.packing.net import Net
from bubblemesh.problem.problem import Problem
from bubblemesh.records import record
from bubblemesh.run.assembly import layered_mesh, mesh_of, sliced_mesh
from bubblemesh.run.metric import MetricRow, metric_row

if TYPE_CHECKING:
    from bubblemesh.layers.figures import LabelLayers
    from bubblemesh.layers.rest import Rest
    from bubblemesh.parts.pipeline import Parted


@record
class Measured:
    """A mesh that holds what every mesh has to, with its figures."""

    mesh: Mesh | SlicedMesh
    fields: dict[str, Floats]  # (t,) of the triangles; in slices, none
    figures: Mapping[str, Any]
    area_error: float
    deviation: Deviation | None
    layers: "tuple[LabelLayers, ...] | None" = None  # if the problem has any
    metric: MetricRow | None = None  # if the problem has one


def measured(packed: "Net | Parted", problem: Problem) -> Measured:
    """The mesh of a problem's packing with its figures."""
    if not isinstance(packed, Net):
        return _in_slices(packed, problem)
    return _whole(packed, problem) if problem.rest is None else _beside_layers(packed, problem, problem.rest)


def _beside_layers(net: Net, problem: Problem, rest: "Rest") -> Measured:
    """The mesh of layers and of what was packed beside them, to which quality and edge lengths belong."""
    # Imported here since few meshes have layers.
    from bubblemesh.layers.figures import beyond_fronts, layer_figures
    from bubblemesh.layers.joining import join_layers

    whole = join_layers(rest, net)
    mesh, layer = layered_mesh(whole, problem.domain, rest.strips)
    measures = problem.spacing.measures(mesh.points, mesh.triangles)
    require_conforming(mesh, measures)
    departure = deviation(problem.domain, mesh.points, whole.net.facets, whole.net.facet_piece)
    packed = problem.spacing.measures(net.bubbles.x, net.triangles)
    of_packed = mesh_figures(packed, problem.spacing.between)
    found = mesh_figures(measures, None) | {name: of_packed[name] for name in ("quality", "spacing")}
    found |= areas_and_lengths(mesh, measures.signed_areas)
    layers = layer_figures(rest.strips, beyond_fronts(rest, net), whole)
    fields = _fields(measures, problem) | {LAYER: layer}
    metric = metric_row(packed, problem)
    return Measured(mesh, fields, found, area_error(mesh, measures), departure, layers, metric)


def _whole(net: Net, problem: Problem) -> Measured:
    mesh = mesh_of(net, problem.domain)
    measures = problem.spacing.measures(mesh.points, mesh.triangles)
    require_conforming(mesh, measures)
    departure = deviation(problem.domain, mesh.points, net.facets, net.facet_piece)
    figures = mesh_figures(measures, problem.spacing.between) | areas_and_lengths(mesh, measures.signed_areas)
    error, metric = area_error(mesh, measures), metric_row(measures, problem)
    return Measured(mesh, _fields(measures, problem), figures, error, departure, metric=metric)


def _fields(measures: Measures, problem: Problem) -> dict[str, Floats]:
    """Data (t,) of the triangles: quality, and at their centroids the target spacing and the metric that is written."""
    metric = {}
    if isinstance(measures, MeasuresInMetric) and problem.written_metric is not None:
        metric = dict(zip(ENTRIES, measures.tensors.T, strict=True))
    return {
        "quality": measures.radius_ratios,
        TARGET_SPACING: problem.spacing.between(measures.points, measures.triangles),
        **metric,
    }


def _in_slices(parted: "Parted", problem: Problem) -> Measured:
    """Figures merged from those of the parts and of the seams between them."""
    net, x = parted.net, parted.net.bubbles.x
    measures, used = Measures(x, net.triangles), parted.valence > 0
    with ThreadPoolExecutor(1) as beside:  # to sort the edges takes as long as what is done meanwhile
        sorted_ = beside.submit(lambda: measures.edges)
        mesh, region = sliced_mesh(parted, problem.domain, _fields(measures, problem))
        edges, _ = sorted_.result()
    on_rings = np.zeros(len(x), bool)
    on_rings[mesh.frame.facets[mesh.outer]] = True
    census = list(parted.census)
    if len(net.triangles):  # there are none where cuts run between areas only
        require_piece(measures, net.facets, parted.rim, ~used)
        # Edges between band and core count here, all others of the core there.
        valence = np.bincount(edges.ravel(), minlength=len(x)) + parted.valence
        every = np.ones(len(edges), bool)
        census.append(Census.of(measures, region, problem.spacing.between, every, ~on_rings, valence))
    total = Census.together(census)
    error = total.area / enclosed_area(x, mesh.frame.facets[mesh.outer]) - 1
    require_matching_nodes(mesh.frame)
    require_area(x, total.area, error)
    departure = deviation(problem.domain, x, net.facets, net.facet_piece)
    regions = total.regions.named(problem.domain.parts.names, problem.domain.parts.name_indices)
    named = {"regions": regions, "labels": label_lengths(mesh.frame)}
    return Measured(mesh, {}, total.figures(mesh.nodes, int(on_rings.sum())) | named, error, departure)
