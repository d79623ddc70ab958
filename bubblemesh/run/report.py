"""The report of a run: figures of the start, of each round and of the mesh, as a frozen record."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from bubblemesh.geometry.following import Deviation
from bubblemesh.geometry.plane import Plane
from bubblemesh.meshes.areas_and_lengths import LabelLength, RegionArea
from bubblemesh.meshfiles.text import json_ready
from bubblemesh.packing.demands import Demands
from bubblemesh.packing.refinement import Refined
from bubblemesh.packing.rounds import Figures, Record
from bubblemesh.records import record
from bubblemesh.run.estimate import RepairRow, RestRow, SpacingChange
from bubblemesh.run.metric import MetricRow
from bubblemesh.run.water import WaterRow

if TYPE_CHECKING:
    from bubblemesh.layers.figures import LabelLayers


@record
class RoundRow:
    """Figures of a round; ``mean_speed`` is that of the last step, ``seconds`` the time the round took."""

    round: int
    iterations: int
    nodes_before: int
    nodes_after: int
    deleted: int
    inserted: int
    mean_speed: float
    quality_mean: float
    quality_min: float
    force_evaluations: int
    seconds: float

    @classmethod
    def of(cls, number: int, done: Record) -> Self:
        """Figures of a round, or of several as one: those of a part, or of all strips of a pass over the seams."""
        return cls(
            round=number,
            iterations=len(done.speeds),
            nodes_before=done.before,
            nodes_after=done.after.nodes,
            deleted=done.deleted,
            inserted=done.inserted,
            mean_speed=float(done.speeds[-1]) if len(done.speeds) else 0.0,
            quality_mean=done.after.quality_mean,
            quality_min=done.after.quality_min,
            force_evaluations=done.evaluations,
            seconds=done.seconds,
        )


@record
class PartsRow:
    """Parts that were packed side by side: their number and nodes, the nodes along the cuts and of the seams.

    And what of the case asked for all triangles at once, so that the mesh is in one piece.
    """

    number: int
    least_nodes: int
    most_nodes: int
    on_cuts: int
    in_seams: int
    joined_for: tuple[str, ...]


@record
class NodeTargetRow:
    """A number of ``nodes`` that was asked for, the ``scale`` of the spacing, and scale and nodes of each attempt."""

    nodes: int
    scale: float
    attempts: tuple[Mapping[str, Any], ...]


@record
class RefinementRow:
    """Nodes that demands on triangles took, what was reached, and the sharper corners that are excused."""

    angle_min: float
    nodes_added: int
    least_angle: float  # of the triangles that no corner excuses
    largest_excess: float  # of an area in terms of the largest one allowed; 0 if any is
    overconstrained: int | None  # triangles without a node inside, if none is allowed
    excused: tuple[Mapping[str, Any], ...]  # places of corners, and the least angle of triangles due to each
    stopped: str | None

    @classmethod
    def of(cls, refined: Refined, demands: Demands) -> Self:
        """Figures of a refinement."""
        excused = tuple(corner._asdict() for corner in refined.excused)
        left = refined.overconstrained if demands.inner_node else None
        return cls(demands.angle, refined.added, refined.angle, refined.excess, left, excused, refined.stopped)


@record
class PlaneRow:
    """Systems of coordinates: those given, those of the plane that figures are of, and those that are written.

    ``scale`` is the least and the largest length in the plane of a metre on the ground, which the spacing accounts for.
    """

    source: str
    plane: str
    target: str
    scale: tuple[float, float]

    @classmethod
    def of(cls, plane: Plane, bounds: tuple[float, float, float, float]) -> Self:
        """Figures of a plane, for a domain within bounds (x0, y0, x1, y1)."""
        x0, y0, x1, y1 = bounds
        x, y = np.array([x0, x0, x1, x1, min(max(0.0, x0), x1)]), np.array([y0, y1, y0, y1, min(max(0.0, y0), y1)])
        scale = plane.scale(x, y)
        return cls(plane.source, plane.definition, plane.target or "auto", (float(scale.min()), float(scale.max())))


@record(kw_only=True)
class Report(Mapping[str, Any]):
    """Everything that is known of a run.

    It is a mapping as well, as its JSON is: ``report["quality"]["mean"]``. A field whose default is None has a key only
    if the case asks for it.
    """

    case: str
    method: str
    version: str
    engine: str  # that ran the kernels: compiled or numpy
    seed: int
    parameters: Mapping[str, Any]
    initial: Figures  # of the initial placement
    rounds: tuple[RoundRow, ...]
    stop_reason: str | None
    finished: bool
    rules: SpacingChange | None = None
    periodic: SpacingChange | None = None
    periodic_sides: tuple[Mapping[str, Any], ...] | None = None
    ideal_nodes: float
    force_evaluations: int
    nodes: int
    triangles: int
    boundary_nodes: int
    bounds: tuple[float, float, float, float]
    quality: Mapping[str, Any]
    area: float
    regions: tuple[RegionArea, ...]
    labels: tuple[LabelLength, ...]
    spacing: Mapping[str, Any]
    area_error: float
    deviation: Deviation | None = None
    seconds: Mapping[str, float]
    peak_memory_mb: float | None
    warnings: tuple[str, ...]
    repairs: tuple[RepairRow, ...] | None = None
    rest: RestRow | None = None
    node_target: NodeTargetRow | None = None
    refinement: RefinementRow | None = None
    adaptation: Mapping[str, Any] | None = None
    parts: PartsRow | None = None
    partition: Mapping[str, Any] | None = None
    crs: PlaneRow | None = None
    water: WaterRow | None = None
    layers: "tuple[LabelLayers, ...] | None" = None  # on each label; quality and spacing then are of all but these
    metric: MetricRow | None = None  # in which quality and spacing are measured

    @cached_property
    def data(self) -> dict[str, Any]:
        """The report as plain data, in the order of its JSON."""
        values = ((field, getattr(self, field.name)) for field in fields(self))
        told = {field.name: value for field, value in values if value is not None or field.default is not None}
        return dict(json_ready(told))

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        return len(self.data)
