"""A case made ready for packing: geometry and spacing checked, the method bound."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.methods import Method
from bubblemesh.spacing.rules.grading import LimitedSpacing
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Extremes, Survey, extremes

if TYPE_CHECKING:
    from bubblemesh.problem.node_target import NodeTarget


@dataclass(frozen=True)
class Task:
    """Method, limits and requirements of a mesh.

    Attributes
    ----------
    name : str
        Name of the case.
    method_name : str
    method : Method
    max_nodes : int
        Largest number of nodes that the mesh may need.
    time_limit : float or None
        Seconds after which the packing ends as it is.
    parameters : dict
        All parameters, defaults included, as reports tell them.
    order : int
        Order of the triangles, 1 or 2.
    requirements : mapping of str to float
        Least ``quality_min``, ``quality_mean`` and ``angle_min`` of the mesh, as far as they are required.
    """

    name: str
    method_name: str
    method: Method
    max_nodes: int
    time_limit: float | None
    parameters: dict[str, Any]
    order: int = 1
    requirements: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Problem:
    """Geometry and spacing checked and ready for packing.

    Attributes
    ----------
    task : Task
    domain : Domain
    spacing, packing_spacing : Spacing
        What the case asks for, and what the packing goes by: finer where the boundary needs it.
    survey : Survey
        Extremes of the spacing and the ideal number of nodes.
    expected_nodes : float
        Ideal number of nodes for the packing spacing.
    after_rules, after_periodic : LimitedSpacing
        How the rules of the spacing changed it, and then the counterparts of periodic sides, if they did.
    warnings : tuple of str
    seconds : dict
        Time taken, by stage.
    node_target : NodeTarget or None
        The number of nodes that the mesh is to have, if the spacing was scaled for one.
    """

    task: Task
    domain: Domain
    spacing: Spacing
    packing_spacing: Spacing
    survey: Survey
    expected_nodes: float
    after_rules: LimitedSpacing
    after_periodic: LimitedSpacing
    warnings: tuple[str, ...]
    seconds: dict[str, float]
    node_target: "NodeTarget | None" = None

    @property
    def method(self) -> Method:
        """The packing method."""
        return self.task.method

    @property
    def refined(self) -> bool:
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
        if not self.refined:
            return self.survey.extremes
        return extremes(self.domain, self.packing_spacing)
