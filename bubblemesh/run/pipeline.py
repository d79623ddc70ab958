"""From a case to a mesh, within a time limit: the whole story on one screen."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter, thread_time
from typing import Any

import numpy as np

from bubblemesh import __version__
from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.errors import BubblemeshError, CaseError, LimitError, RequirementError, at_key
from bubblemesh.geometry.followed import deviation
from bubblemesh.kernels.library import engine
from bubblemesh.limits import enter, time_left, timed
from bubblemesh.meshes.conformity import area_error, require_conforming
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quality import Measures, mesh_figures
from bubblemesh.packing.demands import Demands
from bubblemesh.packing.net import connect
from bubblemesh.packing.progress import TimeUp
from bubblemesh.packing.refinement import Refined, Refinement
from bubblemesh.packing.rounds import Round, rounds
from bubblemesh.parts.work import Crew, Deadline, Figures, Record, alone
from bubblemesh.problem import warnings
from bubblemesh.problem.node_target import NodeTarget, correct
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem
from bubblemesh.resources import peak_memory_mb
from bubblemesh.run.assembly import mesh_of
from bubblemesh.run.estimate import repair_rows, spacing_changes
from bubblemesh.run.report import (
    NodeTargetRow,
    PartsRow,
    RefinementRow,
    Report,
    RoundRow,
    triangle_fields,
)
from bubblemesh.spacing.grid.table import tabulated

MOST_MESHES = 8  # until one has the wanted number of nodes
# Seconds for each node, with room for slow computers: to refine a coarse packing to the end, to measure and write it.
FINISHING = 6e-5
LEAST_WORK = 0.05  # seconds that tell how much of the processor a run gets

OnRound = Callable[[RoundRow], None]
OnShare = Callable[[float], None]


@dataclass(frozen=True)
class Result:
    """Mesh of a run, with its report.

    Attributes
    ----------
    mesh : Mesh
        Of the order that the case asks for, with its partition if it asks for one.
    fields : dict of str to (t,)
        ``quality`` and ``target_spacing`` of the triangles.
    report : Report
    speeds : tuple of (iterations,)
        Mean speeds of the bubbles after each step, for each round.
    verdict : BubblemeshError or None
        Why the mesh is not what the case requires: it is cut short by a time limit, or misses a quality.
    """

    mesh: Mesh
    fields: dict[str, Floats]
    report: Report
    speeds: tuple[Floats, ...]
    verdict: BubblemeshError | None = None


@dataclass
class Clock:
    """A watch that ends a packing while there is time to finish it, and hands on what share of it is done."""

    limit: float | None  # seconds
    reserve: float  # seconds that what follows takes
    on_share: OnShare
    share: float = 0.0
    over: bool = False

    def __call__(self, share: float) -> None:
        """Note the share that is done; TimeUp if the time is over."""
        self.share = share
        self.on_share(share)
        if time_left() < self.reserve:
            self.over = True
            raise TimeUp(self.reason)

    @property
    def reason(self) -> str:
        """Why a packing ends at its limit."""
        return f"the time limit of {self.limit:g} s"

    @property
    def warnings(self) -> list[str]:
        """Warning on what the limit did to the mesh, if it was met."""
        if not self.over:
            return []
        return [
            f"the time limit of {self.limit:g} s ended the packing at about {self.share:.0%}: the mesh is valid, but "
            "less good than it could be"
        ]


@dataclass(frozen=True)
class Packing:
    """A problem with the rounds that packed it, and the time that each stage took."""

    problem: Problem
    start: Figures
    rounds: tuple[RoundRow, ...]
    speeds: tuple[Floats, ...]
    last: Round
    clock: Clock
    seconds: dict[str, float]
    refined: Refined | None = None  # if there are demands on each triangle
    parts: PartsRow | None = None  # if it was packed in parts

    @property
    def nodes(self) -> int:
        """Number of bubbles in the end."""
        return len(self.last.bubbles)

    @property
    def scale(self) -> float:
        """Factor of the spacing, which a number of nodes may ask for."""
        target = self.problem.node_target
        return 1.0 if target is None else target.scale


def mesh_case(
    case: Case,
    on_round: OnRound = lambda row: None,
    on_share: OnShare = lambda share: None,
    crew: Crew = alone,
) -> Result:
    """Mesh a case.

    ``on_round`` is told of each round as it ends, ``on_share`` again and again what share of the packing is done. The
    ``crew`` packs the parts, if the case asks for any.

    Raises
    ------
    BubblemeshError
        One of its subclasses for a mistake of the user's, with the place and what to do.
    """
    if not isinstance(case, Case):
        raise CaseError(f"case: must be a Case (found {type(case).__name__}): load_case reads one from a file")
    return case.within_limits(lambda: mesh_problem(prepare(case), on_round, on_share, crew=crew))


def mesh_problem(
    problem: Problem,
    on_round: OnRound = lambda row: None,
    on_share: OnShare = lambda share: None,
    adaptation: Mapping[str, Any] | None = None,
    crew: Crew = alone,
) -> Result:
    """Mesh a problem; ``adaptation`` is what the report tells of the solution that the sizes come from."""
    begun = perf_counter() - sum(problem.seconds.values())
    packings = [pack(problem, on_round, on_share, crew)]
    while (target := problem.node_target) and len(packings) < MOST_MESHES and _misses(packings[-1], target):
        if time_left() < sum(packings[-1].seconds.get(stage, 0.0) for stage in ("placement", "packing")):
            break
        found = [(packing.problem.expected_nodes, packing.nodes) for packing in packings]
        problem = correct(problem, target, found)
        if problem.node_target is None or problem.node_target.scale in [packing.scale for packing in packings]:
            break
        packings.append(pack(problem, on_round, on_share, crew))
    return _finish(packings, begun, adaptation)


def pack(problem: Problem, on_round: OnRound, on_share: OnShare, crew: Crew) -> Packing:
    """Pack a problem, in parts if the task asks for them, as long as the run's time limit leaves time to finish."""
    whole = problem.task.parts == 1
    packing = _whole(problem, on_round, on_share) if whole else _in_parts(problem, on_round, on_share, crew)
    if not problem.demands:
        return packing
    enter("refinement")
    with timed(packing.seconds, "refinement"):
        refined = Refinement(problem.domain, problem.packing_spacing, problem.demands)(packing.last.net, packing.clock)
    return replace(packing, last=replace(packing.last, net=refined.net), refined=refined)


def _whole(problem: Problem, on_round: OnRound, on_share: OnShare) -> Packing:
    """Place bubbles and run the rounds of the method."""
    task, domain, method, seconds = problem.task, problem.domain, problem.method, dict(problem.seconds)
    begun, worked = perf_counter(), thread_time()
    with timed(seconds, "placement"):
        spacing = tabulated(domain, problem.packing_spacing)
        levels = method.levels(domain, spacing, problem.expected_nodes)
        start = method.placement(domain, levels[0], task.max_nodes)
        first = Figures.of(start, connect(start, domain).triangles)
    rows, speeds = list[RoundRow](), list[Floats]()
    # Where other programs take the processor, what follows takes longer as well.
    shared = max((perf_counter() - begun) / max(thread_time() - worked, LEAST_WORK), 1.0)
    clock = Clock(task.time_limit, FINISHING * problem.expected_nodes * shared, on_share)
    with timed(seconds, "packing"):
        last_end = perf_counter()
        last: Round | None = None
        for done in rounds(start, domain, levels, method, clock):
            rows.append(RoundRow.of(done, perf_counter() - last_end))
            speeds.append(done.speeds)
            on_round(rows[-1])
            last_end, last = perf_counter(), done if done.stop_reason is not None else None
            del done  # or its net, which takes most of the memory, stays while the next round makes its own
    assert last is not None  # the last round tells why it is
    return Packing(problem, first, tuple(rows), tuple(speeds), last, clock, seconds)


def _in_parts(problem: Problem, on_round: OnRound, on_share: OnShare, crew: Crew) -> Packing:
    """Pack parts side by side, if it is worth several; each, and each strip along the cuts, is told of as a round."""
    # Imported here since few meshes have parts.
    from bubblemesh.parts.parted import Together, enough_parts, packed_in_parts

    parts = problem.task.parts or enough_parts(problem.expected_nodes)
    if parts == 1:
        return _whole(problem, on_round, on_share)
    task, seconds = problem.task, dict(problem.seconds)
    rows, records = list[RoundRow](), list[Record]()

    def on_done(record: Record) -> None:
        records.append(record)
        rows.append(RoundRow.of_part(len(records), record))
        on_round(rows[-1])

    clock = Clock(task.time_limit, FINISHING * problem.expected_nodes, on_share)
    deadline = Deadline.within(time_left() - clock.reserve)
    together = Together(problem.packing_spacing, problem.method, task.max_nodes, deadline, crew, on_done, on_share)
    with timed(seconds, "packing"):
        parted = packed_in_parts(problem.domain, problem.expected_nodes, parts, together)
    clock.over = any(record.late for record in records)
    last = Round(
        number=len(rows),
        before=len(parted.net.bubbles),
        inserted=0,
        net=parted.net,
        speeds=np.zeros(0),
        evaluations=0,
        stop_reason=clock.reason if clock.over else "all parts and the seams between are packed",
    )
    start = Figures.together([record.start for record in records[:parts]])
    nodes, speeds = [record.end.nodes for record in records[:parts]], tuple(record.speeds for record in records)
    row = PartsRow(parts, min(nodes), max(nodes), parted.on_cuts, parted.in_seams)
    return Packing(problem, start, tuple(rows), speeds, last, clock, seconds, parts=row)


def _finish(packings: Sequence[Packing], begun: float, adaptation: Mapping[str, Any] | None) -> Result:
    """Make the mesh of the best packing, measure it and report: the nearest one to the wanted number of nodes."""
    target = packings[0].problem.node_target
    wanted = packings[0].nodes if target is None else target.nodes
    best = min(packings, key=lambda packing: (packing.clock.over, abs(packing.nodes - wanted)))
    problem, task, seconds = best.problem, best.problem.task, dict(best.seconds)
    domain, ideal_nodes, last = problem.domain, problem.survey.ideal_nodes, best.last
    with timed(seconds, "quality"):
        mesh = mesh_of(last.net, domain)
        measures = Measures(mesh.points, mesh.triangles)
        require_conforming(mesh, measures)
        departure = deviation(domain, mesh.points, *domain.boundary.edges(last.bubbles.piece, last.bubbles.s))
        figures = mesh_figures(measures, problem.spacing.between)
        error, fields = area_error(mesh, measures), triangle_fields(measures, problem.spacing)
        straight = 0
        if task.order == 2:
            mesh, straight = mesh.second_order()
    if task.partition is not None:
        with timed(seconds, "partition"), at_key("output", "partition"):
            mesh = mesh.partitioned(task.partition)
    seconds["total"] = sum(seconds.values())
    if target is not None:
        total = perf_counter() - begun
        seconds |= {"other_attempts": total - seconds["total"], "total": total}
    attempts = tuple({"scale": packing.scale, "nodes": packing.nodes} for packing in packings)
    changes = spacing_changes(problem)
    report = Report(
        case=task.name,
        method=task.method_name,
        version=__version__,
        engine=engine(),
        seed=problem.method.perturbation.seed,
        parameters=task.parameters,
        initial=best.start,
        rounds=best.rounds,
        stop_reason=last.stop_reason,
        finished=not best.clock.over,
        rules=changes.get("rules"),
        periodic=changes.get("periodic"),
        ideal_nodes=ideal_nodes,
        force_evaluations=sum(row.force_evaluations for row in best.rounds),
        **figures,
        area_error=error,
        deviation=departure,
        seconds=seconds,
        peak_memory_mb=peak_memory_mb(),
        warnings=(
            *problem.warnings,
            *best.clock.warnings,
            *warnings.poor_result(figures, None if problem.refined else ideal_nodes),
            *(() if target is None else warnings.missed_node_target(target.nodes, best.nodes)),
            *warnings.straight_facets(straight),
            *([] if best.refined is None else warnings.sharper_corners(best.refined, task.least_angle)),
            *([] if mesh.partition is None else warnings.divided_by_geometry(mesh.partition)),
        ),
        repairs=repair_rows(domain),
        refinement=None if best.refined is None else RefinementRow.of(best.refined, problem.demands),
        budget=None if target is None else NodeTargetRow(target.nodes, best.scale, attempts),
        adaptation=adaptation,
        parts=best.parts,
        partition=None if mesh.partition is None else mesh.partition.figures(),
    )
    return Result(mesh, fields, report, best.speeds, _verdict(best, figures))


def _misses(packing: Packing, target: NodeTarget) -> bool:
    """Whether another scale may come nearer to the target."""
    return not packing.clock.over and bool(warnings.missed_node_target(target.nodes, packing.nodes))


def _verdict(packing: Packing, figures: Mapping[str, Any]) -> BubblemeshError | None:
    """Why the mesh is not what the case requires, if it is not."""
    if packing.clock.over:
        return LimitError(f"limits.seconds: stopped by {packing.last.stop_reason}: the mesh is written as it was then")
    if packing.refined is not None and packing.refined.stopped is not None:
        return _unrefined(packing.refined, packing.problem.demands)
    quality = figures["quality"]
    reached = {"quality_min": quality["min"], "quality_mean": quality["mean"], "angle_min": quality["angle_min"]}
    missed = [
        f"{key} is {reached[key]:.4g}, below {bound:.4g}"
        for key, bound in packing.problem.task.requirements.items()
        if reached[key] < bound
    ]
    if missed:
        return RequirementError(f"the mesh is written, but misses what the case requires: {'; '.join(missed)}")
    return None


def _unrefined(refined: Refined, demands: Demands) -> BubblemeshError:
    """Why a refinement ended before its demands were met."""
    told = f"the least angle is {refined.angle:.4g} degrees" if demands.angle > refined.angle else ""
    if refined.excess > 1:
        told += f"{' and ' if told else ''}a triangle has {refined.excess:.3g} times the largest area"
    kind = LimitError if refined.out_of_nodes else RequirementError
    return kind(
        f"the refinement for angle_min or largest was stopped {refined.stopped}: the mesh is written, but {told}"
    )
