"""From a case to a mesh, within a time limit: the whole story on one screen."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

from bubblemesh import __version__
from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.errors import BubblemeshError, CaseError, LimitError, RequirementError, at_key
from bubblemesh.kernels.library import engine
from bubblemesh.limits import time_left, timed
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.sliced import SlicedMesh
from bubblemesh.messages import counted
from bubblemesh.packing.demands import Demands
from bubblemesh.packing.refinement import Refined
from bubblemesh.parts.store import IN_MEMORY, Keeping
from bubblemesh.parts.work import Crew, alone
from bubblemesh.problem import warnings
from bubblemesh.problem.node_target import NodeTarget, correct
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import SEA_REQUIREMENTS, Problem
from bubblemesh.resources import peak_memory_mb
from bubblemesh.run.estimate import repair_rows, spacing_changes
from bubblemesh.run.measured import measured
from bubblemesh.run.metric import unsteady_ellipses
from bubblemesh.run.packings import OnRound, OnShare, Packing, pack
from bubblemesh.run.report import NodeTargetRow, PlaneRow, RefinementRow, Report
from bubblemesh.run.water import WaterRow, depths_of, sea_figures
from bubblemesh.spacing.metric.metric import MetricSpacing

MOST_MESHES = 8  # until one has the wanted number of nodes


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


@dataclass(frozen=True)
class SlicedResult:
    """Mesh of a problem that was packed in parts, which stays where they are kept; else as `Result`."""

    problem: Problem
    mesh: SlicedMesh
    report: Report
    speeds: tuple[Floats, ...]
    verdict: BubblemeshError | None = None


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


def mesh_case_in_slices(
    case: Case, keeping: Keeping, on_round: OnRound, on_share: OnShare, crew: Crew
) -> Result | SlicedResult:
    """Mesh a case as `mesh_case` does; what is packed in parts stays where it is kept, if nothing needs all of it."""
    return case.within_limits(lambda: _meshed(prepare(case), on_round, on_share, None, crew, keeping))


def mesh_problem(
    problem: Problem,
    on_round: OnRound = lambda row: None,
    on_share: OnShare = lambda share: None,
    adaptation: Mapping[str, Any] | None = None,
    crew: Crew = alone,
) -> Result:
    """Mesh a problem; ``adaptation`` is what the report tells of the solution that the sizes come from."""
    result = _meshed(problem, on_round, on_share, adaptation, crew, IN_MEMORY)
    assert isinstance(result, Result)  # what is kept in memory does not stay in parts
    return result


def _meshed(
    problem: Problem,
    on_round: OnRound,
    on_share: OnShare,
    adaptation: Mapping[str, Any] | None,
    crew: Crew,
    keeping: Keeping,
) -> Result | SlicedResult:
    begun = perf_counter() - sum(problem.seconds.values())
    packings = [pack(problem, on_round, on_share, crew, keeping)]
    while (target := problem.node_target) and len(packings) < MOST_MESHES and _misses(packings[-1], target):
        if time_left() < sum(packings[-1].seconds.get(stage, 0.0) for stage in ("placement", "packing")):
            break
        found = [(packing.problem.expected_nodes, packing.nodes) for packing in packings]
        problem = correct(problem, target, found)
        if problem.node_target is None or problem.node_target.scale in [packing.scale for packing in packings]:
            break
        packings.append(pack(problem, on_round, on_share, crew, keeping))
    return _finish(packings, begun, adaptation)


def _finish(packings: Sequence[Packing], begun: float, adaptation: Mapping[str, Any] | None) -> Result | SlicedResult:
    """Make the mesh of the best packing, measure it and report: the nearest one to the wanted number of nodes."""
    target = packings[0].problem.node_target
    wanted = packings[0].nodes if target is None else target.nodes
    best = min(packings, key=lambda packing: (packing.clock.over, abs(packing.nodes - wanted)))
    problem, task, seconds = best.problem, best.problem.task, dict(best.seconds)
    ideal_nodes = problem.survey.ideal_nodes
    with timed(seconds, "quality"):
        found = measured(best.packed, problem)
        mesh, figures, straight = found.mesh, found.figures, 0
        if isinstance(mesh, Mesh) and task.order == 2:
            mesh, straight = mesh.second_order()
    water = None
    if isinstance(mesh, Mesh) and task.open_labels:
        mesh = replace(mesh, open_labels=task.open_labels)
    if isinstance(mesh, Mesh) and task.depth is not None:
        mesh = replace(mesh, depth=depths_of(mesh, task.depth))
        water = WaterRow.of(mesh, mesh.depth)
    plane = problem.domain.plane
    if isinstance(mesh, Mesh) and isinstance(problem.spacing, MetricSpacing) and (plane is None or not plane.target):
        mesh = replace(mesh, metric=problem.spacing.at(mesh.points))
    if isinstance(mesh, Mesh) and plane is not None:
        mesh = mesh.mapped(plane.written)
    if isinstance(mesh, Mesh) and task.partition is not None:
        with timed(seconds, "partition"), at_key("output", "partition"):
            mesh = mesh.partitioned(task.partition)
    partition = mesh.partition if isinstance(mesh, Mesh) else None
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
        stop_reason=best.stop_reason,
        finished=not best.clock.over,
        rules=changes.get("rules"),
        periodic=changes.get("periodic"),
        ideal_nodes=ideal_nodes,
        force_evaluations=sum(row.force_evaluations for row in best.rounds),
        **figures,
        area_error=found.area_error,
        deviation=found.deviation,
        seconds=seconds,
        peak_memory_mb=peak_memory_mb(),
        warnings=(
            *problem.warnings,
            *best.clock.warnings,
            *warnings.poor_result(figures, None if problem.refined or problem.rest else ideal_nodes),
            *warnings.jumps_at_layers(found.layers),
            *unsteady_ellipses(found.metric),
            *(() if target is None else warnings.missed_node_target(target.nodes, best.nodes)),
            *warnings.straight_facets(straight),
            *([] if best.refined is None else warnings.sharper_corners(best.refined, problem.demands)),
            *([] if partition is None else warnings.divided_by_geometry(partition)),
        ),
        repairs=repair_rows(problem.domain),
        refinement=None if best.refined is None else RefinementRow.of(best.refined, problem.demands),
        budget=None if target is None else NodeTargetRow(target.nodes, best.scale, attempts),
        adaptation=adaptation,
        parts=best.parts,
        partition=None if partition is None else partition.figures(),
        layers=found.layers,
        water=water,
        crs=None if plane is None else PlaneRow.of(plane, figures["bounds"]),
        metric=found.metric,
    )
    of_sea = sea_figures(mesh) if isinstance(mesh, Mesh) and SEA_REQUIREMENTS & task.requirements.keys() else {}
    verdict = _verdict(best, figures, of_sea)
    if isinstance(mesh, Mesh):
        return Result(mesh, found.fields, report, best.speeds, verdict)
    return SlicedResult(problem, mesh, report, best.speeds, verdict)


def _misses(packing: Packing, target: NodeTarget) -> bool:
    """Whether another scale may come nearer to the target."""
    return not packing.clock.over and bool(warnings.missed_node_target(target.nodes, packing.nodes))


def _verdict(packing: Packing, figures: Mapping[str, Any], of_sea: Mapping[str, int]) -> BubblemeshError | None:
    """Why the mesh is not what the case requires, if it is not."""
    if packing.clock.over:
        return LimitError(f"limits.seconds: stopped by {packing.stop_reason}: the mesh is written as it was then")
    if packing.refined is not None and packing.refined.stopped is not None:
        return _unrefined(packing.refined, packing.problem.demands)
    quality = figures["quality"]
    required = packing.problem.task.requirements
    least = {"quality_min": quality["min"], "quality_mean": quality["mean"], "angle_min": quality["angle_min"]}
    largest = {"valence_max": quality["valence_max"]} | {f"{name}_max": count for name, count in of_sea.items()}
    low = {key: value for key, value in least.items() if value < required.get(key, value)}
    high = {key: value for key, value in largest.items() if value > required.get(key, value)}
    missed = [f"{key} is {value:.4g}, below {required[key]:.4g}" for key, value in low.items()]
    missed += [f"{key} is {value:.4g}, above {required[key]:.4g}" for key, value in high.items()]
    if missed:
        return RequirementError(f"the mesh is written, but misses what the case requires: {'; '.join(missed)}")
    return None


def _unrefined(refined: Refined, demands: Demands) -> BubblemeshError:
    """Why a refinement ended before its demands were met."""
    told = list[str]()
    if demands.angle > refined.angle:
        told.append(f"the least angle is {refined.angle:.4g} degrees")
    if refined.excess > 1:
        told.append(f"a triangle has {refined.excess:.3g} times the largest area")
    if refined.overconstrained:
        told.append(f"{counted(refined.overconstrained, 'triangle')} with all nodes on the boundary are left")
    kind = LimitError if refined.out_of_nodes else RequirementError
    return kind(
        f"the refinement for angle_min, largest or overconstrained was stopped {refined.stopped}: the mesh is written, "
        f"but {' and '.join(told)}"
    )
