"""A case made ready for packing: geometry and spacing checked, the method bound."""

from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.demands import Demands
from bubblemesh.records import record
from bubblemesh.spacing.metric.metric import MetricSpacing
from bubblemesh.spacing.rules.grading import LimitedSpacing
from bubblemesh.spacing.rules.rules import Rules
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Extremes, Survey, extremes
from bubblemesh.spacing.terms.depth import NodeDepth

if TYPE_CHECKING:
    from bubblemesh.layers.ladder import Ladder
    from bubblemesh.layers.rest import Rest
    from bubblemesh.packing.method import Method
    from bubblemesh.packing.placement.warm_start import PreviousNodes
    from bubblemesh.problem.node_target import NodeTarget


SEA_REQUIREMENTS = {"dead_ends_max", "cut_off_max"}  # that need all triangles at once


@record
class Task:
    """Method, limits and requirements of a mesh; methods are loaded when one is asked for, as no estimate does."""

    name: str  # of the case
    method_name: str
    configured: "Callable[[], Method]"  # gives the method that the case asks for
    max_nodes: int  # the most that the mesh may need
    time_limit: float | None  # seconds after which the packing ends as it is
    settings: dict[str, Any]  # of the case beside those of the method, as reports hold them
    order: int = 1  # of the triangles, 1 or 2
    parts: int | None = 1  # that are packed side by side; as many as are worth it if None
    partition: int | None = None  # number of parts for a parallel solver
    requirements: Mapping[str, float] = field(default_factory=dict)  # by the names of their keys, if required
    least_angle: float = 0.0  # degrees, for which nodes are added
    largest: float = np.inf  # area of a triangle
    largest_in: Mapping[str, float] = field(default_factory=dict)  # the same in regions, by their names
    inner_node: bool = False  # whether each triangle needs a node that is not on the rings of the domain
    ladders: "tuple[Ladder, ...]" = ()  # of boundary layers
    adapted: bool = False  # whether a solution sets the spacing, which may be too fine for them: they are left out then
    previous: "PreviousNodes | None" = None  # nodes of a mesh to start from
    depth: NodeDepth | None = None  # that the mesh is written with
    open_labels: tuple[str, ...] = ()  # of the boundary, for formats of coasts
    ids: Mapping[str, int] = field(default_factory=dict)  # of groups in mesh files, by their names there
    file_length: float | None = None  # in the case, of 1 in a file with regions that could be simplified
    corners: str = "corners: 30 in the ring or file"  # how rings are followed as curves

    @cached_property
    def method(self) -> "Method":
        """The method to pack by."""
        method = self.configured()
        return method if self.previous is None else method.warm_started(self.previous)

    @property
    def demanded(self) -> tuple[str, ...]:
        """Keys of the demands on each triangle, for which nodes may be added."""
        asked = {
            "angle_min": self.least_angle > 0,
            "largest": bool(np.isfinite([self.largest, *self.largest_in.values()]).any()),
            "overconstrained": self.inner_node,
        }
        return tuple(key for key, needed in asked.items() if needed)

    @property
    def parameters(self) -> dict[str, Any]:
        """All settings, with defaults and those of the method, as reports hold them."""
        from bubblemesh.packing.configure import options

        return self.settings | options(self.configured())


@record
class Problem:
    """Geometry and spacing checked and ready for packing."""

    task: Task
    domain: Domain
    spacing: Spacing  # that the case asks for
    packing_spacing: Spacing  # that the packing goes by: finer where the boundary needs it
    survey: Survey
    expected_nodes: float  # the ideal number for the packing spacing, and those of layers
    before_rules: Spacing  # that of the terms and their limits
    extremes_before: Extremes  # of that, or of the metrics below it
    rules: Rules
    after_rules: LimitedSpacing
    after_periodic: LimitedSpacing  # the spacing after its rules, and after the counterparts of periodic sides
    warnings: tuple[str, ...]
    seconds: Mapping[str, float]  # that it took to make it, by stage
    rest: "Rest | None" = None  # of the domain beside boundary layers, if there are any
    node_target: "NodeTarget | None" = None  # if the spacing was scaled for a number of nodes

    @property
    def method(self) -> "Method":
        """The packing method."""
        return self.task.method

    def one_by_one(self) -> "Problem | None":
        """The problem with bubbles that are placed one by one, or None if they are already."""
        fitted = self.method.placement.fitted(self.packed_domain, self.packing_spacing, self.packed_nodes)
        placement = fitted.one_by_one()
        if placement is fitted:
            return None
        configured = partial(replace, self.method, placement=placement)
        return replace(self, task=replace(self.task, configured=configured))

    @property
    def packed_domain(self) -> Domain:
        """The domain that bubbles are packed in: all but boundary layers."""
        return self.domain if self.rest is None else self.rest.domain

    @property
    def packed_nodes(self) -> float:
        """The ideal number of nodes of the packing."""
        return self.expected_nodes - (0 if self.rest is None else self.rest.own_nodes)

    @property
    def demands(self) -> Demands:
        """Demands on each triangle."""
        task, parts = self.task, self.domain.parts
        by_name = [min(task.largest, task.largest_in.get(name, np.inf)) for name in parts.names]
        areas = tuple(by_name[k] for k in parts.name_indices.tolist()) if task.largest_in else (task.largest,)
        return Demands(task.least_angle, areas, task.inner_node, task.max_nodes)

    @property
    def written_metric(self) -> MetricSpacing | None:
        """The metric that is written with the mesh: it belongs to the plane of the packing, and to no other system."""
        plane = self.domain.plane
        return self.spacing if isinstance(self.spacing, MetricSpacing) and (plane is None or not plane.target) else None

    @property
    def needs_all_at_once(self) -> tuple[str, ...]:
        """What asks for all triangles at once, so that what is packed in parts may not stay in them."""
        task, plane = self.task, self.domain.plane
        asked = {
            "layers": self.rest is not None,
            "metric": self.spacing.in_metric,
            "output.order": task.order > 1,
            "output.partition": task.partition is not None,
            "crs.to": plane is not None and plane.target is not None,
        }
        named = [name for name, needed in asked.items() if needed]
        return *task.demanded, *named, *sorted(SEA_REQUIREMENTS & task.requirements.keys())

    @property
    def packed_finer(self) -> bool:
        """Whether the packing spacing is finer than the spacing somewhere."""
        return self.packing_spacing is not self.spacing

    @property
    def changes(self) -> dict[str, LimitedSpacing]:
        """Changes that made the spacing finer than its terms, as reports name them."""
        found = {"rules": self.after_rules, "periodic": self.after_periodic}
        if self.after_periodic is self.after_rules:
            del found["periodic"]
        return {name: changed for name, changed in found.items() if changed.ratio > 1}

    @cached_property
    def packing_extremes(self) -> Extremes:
        """Extremes of the packing spacing."""
        if not self.packed_finer:
            return self.survey.extremes
        return extremes(self.domain, self.packing_spacing, self.survey.cover)
