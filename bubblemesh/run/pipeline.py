"""From a case to a mesh, within its limits: `_run` has the steps in their order."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from types import MappingProxyType
from typing import Any, ClassVar

from bubblemesh import __version__
from bubblemesh.arrays import Floats
from bubblemesh.case import Case
from bubblemesh.errors import BubblemeshError, CaseError
from bubblemesh.kernels.library import engine
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.messages import own_places
from bubblemesh.parts.work import Crew, alone
from bubblemesh.problem.node_target import NodeTarget, correct
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.problem import Problem
from bubblemesh.process.resources import peak_memory_mb
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.process.watchdog import time_left
from bubblemesh.records import record
from bubblemesh.run import warnings
from bubblemesh.run.completion import Completed, completed
from bubblemesh.run.estimate import repair_rows, rest_row, side_motions, spacing_changes
from bubblemesh.run.limits import within_limits
from bubblemesh.run.measurement import Measured, measured
from bubblemesh.run.packing import OnRound, OnShare, PackedProblem, RunOptions, pack
from bubblemesh.run.report import NodeTargetRow, PlaneRow, RefinementRow, Report
from bubblemesh.run.verdict import verdict

MOST_MESHES = 8  # until one has the requested number of nodes
MOST_BY_ROWS = 4  # of them with whole rows of nodes, if there are any
IN_THIS_PROCESS = RunOptions()


@record(eq=False)
class Result:
    """Mesh of a run, with its report.

    Attributes
    ----------
    mesh : Mesh
        Of the order that the case asks for, with its partition if it asks for one.
    fields : dict of str to (t,)
        Data of the triangles, which the mesh has as well: ``quality`` and ``target_spacing``; ``layer``, the number of
        the boundary layer, 0 for none, if the case asks for any; in a metric its tensors ``metric_11``, ``metric_12``
        and ``metric_22``, unless coordinates are written in another system than that of the plane.
    report : Report
        A mapping with the keys of the JSON that a run writes; ``dict(report)`` is a dictionary of them for `json`.
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

    def __repr__(self) -> str:
        return f"<Result: {self.mesh!r}, mean quality {self.report['quality']['mean']:.3f}>"


@record(eq=False)
class SlicedResult:
    """Mesh of a problem that was packed in parts, which stays where they are kept; else as `Result`."""

    fields: ClassVar[Mapping[str, Floats]] = MappingProxyType({})  # those of the triangles stay in the slices

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

    ``on_round`` is called with each round as it ends, ``on_share`` again and again with the share of the packing that
    is done. The ``crew`` packs the parts, if the case asks for any.

    Raises
    ------
    BubblemeshError
        One of its subclasses for a mistake of the user's, with the place and what to do.
    """
    require_case(case)
    options = RunOptions(on_round, on_share, crew)
    with own_places():
        return within_limits(case, lambda: mesh_problem(prepare(case), options))


def require_case(case: object) -> None:
    """Check that a program gives a case; else it is a CaseError."""
    if not isinstance(case, Case):
        raise CaseError(f"case: must be a Case (found {type(case).__name__}): load_case reads one from a file")


def run_case(case: Case, options: RunOptions) -> Result | SlicedResult:
    """Mesh a case as `mesh_case` does; what is packed in parts stays where it is kept, if nothing needs all of it."""
    return within_limits(case, lambda: _run(prepare(case), options))


def mesh_problem(
    problem: Problem, options: RunOptions = IN_THIS_PROCESS, adaptation: Mapping[str, Any] | None = None
) -> Result:
    """Mesh a problem, whose parts are kept in memory.

    ``adaptation`` is what the report says of the solution that the sizes come from.
    """
    result = _run(problem, options, adaptation)
    assert isinstance(result, Result)  # what is kept in memory does not stay in parts
    return result


def _run(problem: Problem, options: RunOptions, adaptation: Mapping[str, Any] | None = None) -> Result | SlicedResult:
    """Mesh a problem: pack it, measure the mesh, complete it, and report."""
    begun = perf_counter() - sum(problem.seconds.values())
    # 1. Pack, again and again if a number of nodes is asked for.
    packings = _packings(problem, options)
    best = _best(packings)
    problem, stopwatch = best.problem, Stopwatch(best.seconds)
    # 2. Make the mesh, measure it, and give it what its files hold beside nodes and triangles.
    with stopwatch.stage("quality"):
        found = measured(best.packed, problem)
        done = completed(found, problem)
    # 3. Divide it for a parallel solver.
    if problem.task.partition is not None:
        with stopwatch.stage("partition"):
            done = done.divided(problem.task.partition)
    # 4. Report, and say whether it is what the case requires.
    seconds = stopwatch.seconds
    if problem.node_target is not None:
        seconds["other_attempts"] = perf_counter() - begun - sum(seconds.values())
    seconds["total"] = sum(seconds.values())
    report = _report(best, found, done, seconds, _node_target_row(best, packings), adaptation)
    why_not = verdict(best, found.figures, done.mesh)
    if isinstance(done.mesh, Mesh):
        return Result(done.mesh, found.fields, report, best.speeds, why_not)
    return SlicedResult(problem, done.mesh, report, best.speeds, why_not)


def _packings(problem: Problem, options: RunOptions) -> Sequence[PackedProblem]:
    """Packings of a problem: one, or several until one has the requested number of nodes, while there is time."""
    packings = [pack(problem, options)]
    while (target := problem.node_target) and len(packings) < MOST_MESHES and _misses(packings[-1], target):
        if time_left() < sum(packings[-1].seconds.get(stage, 0.0) for stage in ("placement", "packing")):
            break
        following = _corrected(problem, target, packings)
        if following is None:
            break
        problem = following
        packings.append(pack(problem, options))
    return packings


def _best(packings: Sequence[PackedProblem]) -> PackedProblem:
    """The packing that is nearest to the requested number of nodes, of those that were not cut short if any."""
    target = packings[0].problem.node_target
    requested = packings[0].nodes if target is None else target.nodes
    return min(packings, key=lambda packing: (packing.cut_short is not None, abs(packing.nodes - requested)))


def _node_target_row(best: PackedProblem, packings: Sequence[PackedProblem]) -> NodeTargetRow | None:
    """Row of the report on the requested number of nodes; None if none was requested."""
    target = best.problem.node_target
    attempts = tuple({"scale": packing.scale, "nodes": packing.nodes} for packing in packings)
    return None if target is None else NodeTargetRow(target.nodes, best.scale, attempts)


def _report(
    best: PackedProblem,
    found: Measured,
    done: Completed,
    seconds: Mapping[str, float],
    node_target: NodeTargetRow | None,
    adaptation: Mapping[str, Any] | None,
) -> Report:
    """The report of a packing and its mesh."""
    problem, task, plane = best.problem, best.problem.task, best.problem.domain.plane
    changes = spacing_changes(problem)
    return Report(
        case=task.name,
        method=task.method_name,
        version=__version__,
        engine=engine(),
        seed=problem.method.perturbation.seed,
        parameters=task.parameters,
        initial=best.start,
        rounds=best.rounds,
        stop_reason=best.stop_reason,
        finished=best.cut_short is None,
        rules=changes.get("rules"),
        periodic=changes.get("periodic"),
        periodic_sides=side_motions(problem.domain),
        ideal_nodes=problem.survey.ideal_nodes,
        force_evaluations=sum(row.force_evaluations for row in best.rounds),
        **found.figures,
        area_error=found.area_error,
        deviation=found.deviation,
        seconds=seconds,
        peak_memory_mb=peak_memory_mb(),
        warnings=_report_warnings(best, found, done),
        repairs=repair_rows(problem.domain),
        rest=rest_row(problem.domain),
        refinement=None if best.refined is None else RefinementRow.of(best.refined, problem.demands),
        node_target=node_target,
        adaptation=adaptation,
        parts=best.parts,
        partition=None if done.partition is None else done.partition.figures(),
        layers=found.layers,
        water=done.water,
        crs=None if plane is None else PlaneRow.of(plane, found.figures["bounds"]),
        metric=found.metric,
    )


def _report_warnings(best: PackedProblem, found: Measured, done: Completed) -> tuple[str, ...]:
    """Warnings of the report: of the case, of its packing, and of the mesh."""
    problem, target, layers = best.problem, best.problem.node_target, best.problem.rest
    adapted = problem.task.adapted
    as_many = None if layers else problem.survey.ideal_nodes
    return (
        *problem.warnings,
        *(() if best.cut_short is None else (best.cut_short.warning,)),
        *warnings.poor_result(found.figures, as_many, packed_finer=problem.packed_finer),
        *warnings.jumps_at_layers(found.layers),
        *warnings.unsteady_ellipses(found.metric, adapted=adapted),
        *warnings.dry_water(done.water),
        *(() if target is None else warnings.missed_node_target(target, best.nodes)),
        *(
            warnings.nodes_of_layers(target.nodes, layers.own_nodes, best.scale)
            if adapted and target and layers
            else ()
        ),
        *warnings.straight_facets(done.straight),
        *([] if best.refined is None else warnings.sharper_corners(best.refined, problem.demands)),
        *([] if done.partition is None else warnings.divided_by_geometry(done.partition)),
    )


def _corrected(problem: Problem, target: NodeTarget, packings: Sequence[PackedProblem]) -> Problem | None:
    """The problem with another scale, which may come nearer to the target; None if no scale may.

    Where lattices have missed it, since they have whole rows of nodes, these are placed one by one.
    """
    task = problem.task
    found = [(packing.problem.expected_nodes, packing.nodes) for packing in packings]
    problem = correct(problem, target, found)
    if problem.node_target is None:
        return None
    known = any(problem.node_target.is_near(packing.scale) for packing in packings)
    if task is problem.task and (known or len(packings) >= MOST_BY_ROWS):
        other = problem.one_by_one()
        if other is not None:
            return other
    return None if known else replace(problem, task=task)


def _misses(packing: PackedProblem, target: NodeTarget) -> bool:
    """Whether another scale may come nearer to the target."""
    return packing.cut_short is None and target.is_missed_by(packing.nodes)
