"""A problem whose warnings are still to be made: a search for a number of nodes checks many, and tells of one."""

from dataclasses import replace
from typing import TYPE_CHECKING

from bubblemesh.messages import once_each
from bubblemesh.problem import warnings
from bubblemesh.problem.fitting import Fitted, RequestedSpacing, beside_no_detail
from bubblemesh.problem.lines_and_points import has_followable
from bubblemesh.problem.open_ends import missed_contacts
from bubblemesh.problem.problem import Problem
from bubblemesh.problem.spacing import SpacingRequest
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.records import record

if TYPE_CHECKING:
    from bubblemesh.layers.rest import Rest
    from bubblemesh.problem.metric_spacing import InMetric


@record(eq=False)
class CheckedProblem:
    """A problem without its warnings, and what these are made of."""

    problem: Problem
    request: SpacingRequest
    scale: float | None  # of the request, if it was scaled for a number of nodes
    requested: RequestedSpacing
    fitted: Fitted
    metric: "InMetric | None"

    def told(self, stopwatch: Stopwatch) -> Problem:
        """The problem with its warnings."""
        with stopwatch.stage("spacing"):
            texts = once_each(self._of_spacing())
            if self.metric is not None:
                texts = once_each((*texts, *self.metric.warnings))
            if self.problem.rest is not None:
                texts = once_each((*texts, *_of_layers(self.problem.rest)))
            parts = warnings.small_parts(self.problem.task.parts, self.problem.packed_nodes)
        return replace(self.problem, warnings=(*texts, *parts), seconds=stopwatch.seconds)

    def _of_spacing(self) -> tuple[str, ...]:
        """Warnings of the domain and the spacing of circles in it."""
        domain, rules, fitted = self.problem.domain, self.request.rules, self.fitted
        filled = fitted.filled
        return (
            *domain.notes,
            *self.request.warnings,
            *missed_contacts(domain, fitted.requested),
            *warnings.sharp_angles(domain),
            *self._of_detail(),
            *warnings.far_shorter_edges(domain, self.requested.before_rules, rules, self.requested.hidden),
            *warnings.limited_growth(fitted.before_narrow_parts, rules.growth, self.scale),
            *warnings.narrow_parts(fitted.walls, filled.spacing.spacing, filled.left_out, fitted.requested, rules),
        )

    def _of_detail(self) -> list[str]:
        """Warnings of short edges, tight curves and narrow parts that make the spacing finer."""
        domain, task, fitted = self.problem.domain, self.problem.task, self.fitted
        edges = warnings.RefiningEdges.of(domain, fitted.short)
        few = fitted.filled.expected_nodes < warnings.MANY_TIMES * self.requested.survey.ideal_nodes
        if few or self.request.metrics:  # how many nodes detail takes is known for circles only
            return warnings.refined_boundary(fitted.short, fitted.coarse, edges)
        regions = domain.parts.regions
        rings_followable = not (domain.given_outlines or any(region.area.outer.origin for region in regions))
        detail = warnings.FinerSpacing(
            fitted.short,
            fitted.coarse,
            edges,
            fitted.filled.gaps,
            *beside_no_detail(domain, self.requested, self.request.rules, fitted.filled, task.max_nodes),
            fitted.filled.expected_nodes,
            task.corners if rings_followable else None,
            has_followable(domain.parts.lines),
            task.file_length,
        )
        return warnings.detail(detail)


def _of_layers(rest: "Rest") -> list[str]:
    """Warnings of the boundary layers that have a rest of the domain beside them."""
    # Imported here since few meshes have layers.
    from bubblemesh.layers.figures import layer_figures

    return warnings.low_layers(layer_figures(rest.strips))
