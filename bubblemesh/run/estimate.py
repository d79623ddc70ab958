"""Figures of what a case asks for, before any packing: for its estimate and for the report of its run."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from bubblemesh.geometry.arrangement.regions import RestPart
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.periodic import side_motion
from bubblemesh.meshfiles.text import json_ready
from bubblemesh.problem.problem import Problem
from bubblemesh.records import record
from bubblemesh.run.warnings import jumps_at_layers
from bubblemesh.spacing.metric.metric import MetricSpacing

if TYPE_CHECKING:
    from bubblemesh.layers.figures import LabelLayers


@record
class SpacingChange:
    """Share of the area on which rules made a spacing finer, the largest ratio by which they did, and where that is."""

    share: float
    ratio: float
    ratio_at: tuple[float, float] | None


class RepairRow(NamedTuple):
    """A change of the rings that the case asks for: what it was, where, by how much it made the area larger."""

    what: str
    at: tuple[float, float]
    area: float


def repair_rows(domain: Domain) -> tuple[RepairRow, ...] | None:
    """Changes of the rings of a domain; None if there are none."""
    return tuple(RepairRow(change.what, change.at, change.area) for change in domain.changes) or None


class RestRow(NamedTuple):
    """Parts of a domain that no point of a region names: the region's name, their number, of many not all of them."""

    region: str
    number: int
    parts: tuple[RestPart, ...]


def rest_row(domain: Domain) -> RestRow | None:
    """The parts that points of regions leave of a domain; None if there are not several."""
    rest = domain.parts.rest_parts
    return RestRow(domain.parts.rest, *rest) if rest.number > 1 else None


def spacing_changes(problem: Problem) -> dict[str, SpacingChange]:
    """Changes of the requested spacing by its rules and by its periodic sides, as far as there are any."""
    changes = problem.changes.items()
    return {key: SpacingChange(changed.share, changed.ratio, changed.ratio_at) for key, changed in changes}


def side_motions(domain: Domain) -> tuple[Mapping[str, Any], ...] | None:
    """How the first of each pair of periodic sides comes to lie on the second; None if there are no pairs."""
    pairs = zip(domain.parts.periodic, domain.motions, strict=True)
    return tuple(side_motion(*names, motion.matrix, domain.size) for names, motion in pairs) or None


def _layers(problem: Problem) -> "tuple[LabelLayers, ...] | None":
    """Figures of the layers on each label, if there are any, with those across their fronts as they are expected."""
    if problem.rest is None:
        return None
    from bubblemesh.layers.figures import expected_beyond_fronts, layer_figures

    strips = problem.rest.strips
    return layer_figures(strips, expected_beyond_fronts(strips, problem.packing_spacing))


def estimate(problem: Problem, complete: bool = True) -> dict[str, Any]:
    """Figures of what a case asks for, before any packing, as plain data; unless ``complete``, without parameters."""
    domain, survey, target = problem.domain, problem.survey, problem.node_target
    layers = _layers(problem)
    told = {
        "case": problem.task.name,
        "method": problem.task.method_name,
        **({"parameters": problem.task.parameters} if complete else {}),
        "bounds": domain.bounds,
        "area": domain.polygon.area,
        "pieces": domain.piece_count,
        "holes": domain.hole_count,
        "regions": [{"name": name, "area": area} for name, area in domain.region_areas.items()],
        **({} if (rest := rest_row(domain)) is None else {"rest": rest}),
        "labels": domain.labels,
        **({} if (repairs := repair_rows(domain)) is None else {"repairs": repairs}),
        **({} if (motions := side_motions(domain)) is None else {"periodic_sides": motions}),
        "spacing": survey.extremes,
        **({"metric": {"aspect": problem.spacing.aspect}} if isinstance(problem.spacing, MetricSpacing) else {}),
        **({"packed_spacing": problem.packing_extremes} if problem.packed_finer else {}),
        **spacing_changes(problem),
        **({} if target is None else {"node_target": {"nodes": target.nodes, "scale": target.scale}}),
        **({} if layers is None else {"layers": layers}),
        "ideal_nodes": survey.ideal_nodes,
        "expected_nodes": problem.expected_nodes,
        "warnings": (*problem.warnings, *jumps_at_layers(layers)),
    }
    return dict(json_ready(told))
