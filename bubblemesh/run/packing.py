"""The packing of a problem, in one piece or in parts, as long as the run's time limit leaves time to finish it."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import starmap
from typing import TYPE_CHECKING

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, at_key
from bubblemesh.packing.net import Net
from bubblemesh.packing.refinement import Refined, Refinement
from bubblemesh.packing.rounds import Figures, Record, all_rounds
from bubblemesh.parts.store import IN_MEMORY, Keeping
from bubblemesh.parts.work import Crew, Deadline, Terms, alone
from bubblemesh.problem.problem import Problem
from bubblemesh.process.resources import WorkClock
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.records import record
from bubblemesh.run.report import PartsRow, RoundRow
from bubblemesh.run.time_limit import CutShort, TimeLimit
from bubblemesh.spacing.grid.table import tabulated

if TYPE_CHECKING:
    from bubblemesh.parts.pipeline import Parted

# Seconds for each node, with room for slow computers: to refine a coarse packing to the end, to measure and write it.
FINISHING = 2e-5

OnRound = Callable[[RoundRow], None]
OnShare = Callable[[float], None]


@record(eq=False)
class RunOptions:
    """Who does the work of a run, and who follows it.

    Attributes
    ----------
    on_round : callable
        Called with each round as it ends.
    on_share : callable
        Called again and again with the share of the packing that is done.
    crew : Crew
        Packs the parts, if the case asks for any.
    keeping : Keeping
        Where parts are kept; if that is in files, the mesh may stay in them.
    """

    on_round: OnRound = lambda row: None
    on_share: OnShare = lambda share: None
    crew: Crew = alone
    keeping: Keeping = IN_MEMORY

    def __post_init__(self) -> None:
        for name, given, of in (("on_round", self.on_round, "round"), ("on_share", self.on_share, "share")):
            if not callable(given):
                raise CaseError(f"{name}: must be a function of the {of} that is done (found {given!r})")


@record
class PackedProblem:
    """A problem with the rounds that packed it, and the time that each stage took.

    What was packed in parts, and is to stay there, is in parts; all else is one net.
    """

    problem: Problem
    start: Figures
    records: tuple[Record, ...]  # of rounds; in parts, of each part and each pass over the seams
    packed: "Net | Parted"
    stop_reason: str | None
    cut_short: CutShort | None  # if the time limit ended it
    seconds: Mapping[str, float]
    refined: Refined | None = None  # if there are demands on each triangle
    parts: PartsRow | None = None  # if it was packed in parts

    @property
    def rounds(self) -> tuple[RoundRow, ...]:
        """Figures of each record."""
        return tuple(starmap(RoundRow.of, enumerate(self.records, 1)))

    @property
    def speeds(self) -> tuple[Floats, ...]:
        """Mean speeds after the steps of each record."""
        return tuple(record.speeds for record in self.records)

    @property
    def nodes(self) -> int:
        """Number of bubbles in the end, and of nodes in layers."""
        packed = len(self.packed.bubbles) if isinstance(self.packed, Net) else self.packed.nodes
        return packed + (0 if self.problem.rest is None else self.problem.rest.own_nodes)

    @property
    def scale(self) -> float:
        """Factor of the spacing, which a number of nodes may ask for."""
        return scale_of(self.problem)


def scale_of(problem: Problem) -> float:
    """Factor of a problem's spacing, which a number of nodes may ask for."""
    return 1.0 if problem.node_target is None else problem.node_target.scale


def pack(problem: Problem, options: RunOptions) -> PackedProblem:
    """Pack a problem, in parts if the task asks for them, which stay where they are kept if they may."""
    packing, limit = _whole(problem, options) if problem.task.parts == 1 else _in_parts(problem, options)
    return _refined(packing, replace(limit, over=False)) if problem.task.demanded else packing


def _refined(packing: PackedProblem, limit: TimeLimit) -> PackedProblem:
    """The packing with the nodes that the demands on each triangle take."""
    problem, stopwatch, cut_short = packing.problem, Stopwatch(packing.seconds), packing.cut_short
    assert isinstance(packing.packed, Net)  # demands need all of it at once
    with stopwatch.stage("refinement"):
        refinement = Refinement(problem.packed_domain, problem.packing_spacing, problem.demands)
        refined = refinement(packing.packed, limit)
    if cut_short is None and limit.over:
        cut_short = limit.cut_short(refining=True)
    return replace(
        packing,
        packed=refined.net,
        refined=refined,
        stop_reason=packing.stop_reason if cut_short is None else cut_short.reason,
        cut_short=cut_short,
        seconds=stopwatch.seconds,
    )


def _whole(problem: Problem, options: RunOptions) -> tuple[PackedProblem, TimeLimit]:
    """Place bubbles and run the rounds of the method; and the limit that watched them."""
    task, domain, method, stopwatch = problem.task, problem.packed_domain, problem.method, Stopwatch(problem.seconds)
    work = WorkClock()
    with stopwatch.stage("placement"):
        table = tabulated(domain, problem.packing_spacing)
        levels, start = method.started(domain, table, problem.packed_nodes, task.max_nodes)
    limit = TimeLimit(task.time_limit, FINISHING * problem.expected_nodes, options.on_share, work.slowness())
    with stopwatch.stage("packing"):
        done = all_rounds(start, domain, levels, method, problem.spacing, limit, _teller([], options))
    late = done.rounds[-1].late  # not where the time was over as the packing was finished
    cut_short = limit.cut_short() if late else None
    seconds = stopwatch.seconds
    packing = PackedProblem(problem, done.start, done.rounds, done.net, done.stop_reason, cut_short, seconds)
    return packing, limit


def _teller(records: list[Record], options: RunOptions) -> Callable[[Record], None]:
    """Listener that appends records to others, and hands on their figures."""

    def tell(record: Record) -> None:
        records.append(record)
        options.on_round(RoundRow.of(len(records), record))

    return tell


def _in_parts(problem: Problem, options: RunOptions) -> tuple[PackedProblem, TimeLimit]:
    """Pack parts side by side, if it is worth several; and the limit that watched them.

    Each part, and each pass over the seams, is reported as a round.
    """
    # Imported here since few meshes have parts.
    from bubblemesh.parts.pipeline import enough_parts, packed_in_parts
    from bubblemesh.parts.workshop import Workshop

    parts = problem.task.parts or enough_parts(problem.packed_nodes)
    if parts == 1:
        return _whole(problem, options)
    if parts > problem.packed_nodes:
        with at_key("parts"):
            raise CaseError(f"about {problem.packed_nodes:.0f} nodes are too few for {parts} parts: ask for fewer")
    task, stopwatch, keeping = problem.task, Stopwatch(problem.seconds), options.keeping
    stay = keeping.in_slices and not problem.needs_all_at_once
    records, work = list[Record](), WorkClock()
    limit = TimeLimit(task.time_limit, FINISHING * problem.expected_nodes, options.on_share)
    method = problem.method
    placement = method.placement.shared(problem.packed_domain, problem.packing_spacing, problem.packed_nodes)
    terms = Terms(
        problem.packing_spacing,
        target=problem.spacing if stay else None,
        method=replace(method, placement=placement),
        max_nodes=task.max_nodes,
    )

    def deadline() -> Deadline:
        limit.slowness = work.slowness()
        return Deadline.within(limit.left)

    name = f"{scale_of(problem)!r}-{type(method.placement).__name__}"  # for a number of nodes these may change
    workshop = Workshop(options.crew, keeping.store(name), _teller(records, options), limit.tell)
    with stopwatch.stage("packing"):
        parted = packed_in_parts(problem.packed_domain, problem.packed_nodes, parts, terms, workshop, deadline)
        packed = parted if stay else parted.whole(problem.packing_spacing)
    cut_short = limit.cut_short() if any(record.late for record in records) else None
    why = "all parts and the seams between are packed" if cut_short is None else cut_short.reason
    nodes = [record.after.nodes for record in records[:parts]]
    row = PartsRow(parts, min(nodes), max(nodes), parted.on_cuts, parted.in_seams, problem.needs_all_at_once)
    seconds = stopwatch.seconds
    packing = PackedProblem(problem, parted.start, tuple(records), packed, why, cut_short, seconds, parts=row)
    return packing, limit
