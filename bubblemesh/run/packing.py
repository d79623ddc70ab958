"""The packing of a problem, in one piece or in parts, as long as the run's time limit leaves time to finish it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, at_key
from bubblemesh.packing.net import Net
from bubblemesh.packing.progress import TimeUp
from bubblemesh.packing.refinement import Refined, Refinement
from bubblemesh.packing.rounds import Figures, Record, all_rounds
from bubblemesh.parts.store import IN_MEMORY, Keeping
from bubblemesh.parts.work import Crew, Deadline, Terms, alone
from bubblemesh.problem.problem import Problem
from bubblemesh.process.limits import Stopwatch, enter, time_left
from bubblemesh.process.resources import WorkClock
from bubblemesh.records import record
from bubblemesh.run.report import PartsRow, RoundRow
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
class CutShort:
    """A packing, or its refinement, that was ended by the time limit."""

    limit: float | None  # seconds
    share: float  # of the packing that was done
    refining: bool = False  # whether the packing was at its end, and was refined

    @property
    def reason(self) -> str:
        """Why it ended."""
        return _reason(self.limit)

    @property
    def warning(self) -> str:
        """Warning on what the limit did to the mesh."""
        if self.refining:
            return f"{self.reason} ended the refinement for angle_min, largest or overconstrained: the mesh is valid"
        return (
            f"{self.reason} ended the packing at about {self.share:.0%}: the mesh is valid, but less good than it "
            "could be"
        )


@dataclass
class Clock:
    """A watch that ends a packing, or its refinement, while there is time to finish it, and hands on the share done."""

    limit: float | None  # seconds
    reserve: float  # seconds that what follows takes where no other program works
    on_share: OnShare
    slowness: float = 1.0  # how many times as long it takes beside other programs
    share: float = 0.0
    over: bool = False  # whether it has ended anything

    @property
    def left(self) -> float:
        """Seconds until the packing has to end, negative if its time is up; infinite without a limit."""
        return time_left() - self.reserve * self.slowness

    def __call__(self, share: float) -> None:
        """Note the share that is done; TimeUp if the time is over."""
        self.tell(share)
        if self.left < 0:
            self.over = True
            raise TimeUp(_reason(self.limit))

    def tell(self, share: float) -> None:
        """Hand on the share that is done, and note it while there is time: it is what a limit will have left."""
        if self.left >= 0 or self.share == 0:
            self.share = share
        self.on_share(share)

    def cut_short(self, *, refining: bool = False) -> CutShort:
        """What the limit has ended."""
        return CutShort(self.limit, self.share, refining)


def _reason(limit: float | None) -> str:
    return f"the time limit of {limit:g} s"


@record
class PackedProblem:
    """A problem with the rounds that packed it, and the time that each stage took.

    What was packed in parts, and is to stay there, is in parts; all else is one net.
    """

    problem: Problem
    start: Figures
    rounds: tuple[RoundRow, ...]
    speeds: tuple[Floats, ...]
    packed: "Net | Parted"
    stop_reason: str | None
    cut_short: CutShort | None  # if the time limit ended it
    seconds: Mapping[str, float]
    refined: Refined | None = None  # if there are demands on each triangle
    parts: PartsRow | None = None  # if it was packed in parts

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
    packing, clock = _whole(problem, options) if problem.task.parts == 1 else _in_parts(problem, options)
    return _refined(packing, replace(clock, over=False)) if problem.task.demanded else packing


def _refined(packing: PackedProblem, clock: Clock) -> PackedProblem:
    """The packing with the nodes that the demands on each triangle take."""
    problem, stopwatch, cut_short = packing.problem, Stopwatch(packing.seconds), packing.cut_short
    assert isinstance(packing.packed, Net)  # demands need all of it at once
    enter("refinement")
    with stopwatch.stage("refinement"):
        refinement = Refinement(problem.packed_domain, problem.packing_spacing, problem.demands)
        refined = refinement(packing.packed, clock)
    if cut_short is None and clock.over:
        cut_short = clock.cut_short(refining=True)
    return replace(
        packing,
        packed=refined.net,
        refined=refined,
        stop_reason=packing.stop_reason if cut_short is None else cut_short.reason,
        cut_short=cut_short,
        seconds=stopwatch.seconds,
    )


def _whole(problem: Problem, options: RunOptions) -> tuple[PackedProblem, Clock]:
    """Place bubbles and run the rounds of the method; and the clock that watched them."""
    task, domain, method, stopwatch = problem.task, problem.packed_domain, problem.method, Stopwatch(problem.seconds)
    work = WorkClock()
    with stopwatch.stage("placement"):
        table = tabulated(domain, problem.packing_spacing)
        levels, start = method.started(domain, table, problem.packed_nodes, task.max_nodes)
    clock = Clock(task.time_limit, FINISHING * problem.expected_nodes, options.on_share, work.slowness())
    rows = list[RoundRow]()
    with stopwatch.stage("packing"):
        done = all_rounds(start, domain, levels, method, problem.spacing, clock, _teller(rows, options))
    cut_short = (
        clock.cut_short() if done.rounds[-1].late else None
    )  # not where the time was over as the packing was finished
    speeds, seconds = tuple(record.speeds for record in done.rounds), stopwatch.seconds
    packing = PackedProblem(problem, done.start, tuple(rows), speeds, done.net, done.stop_reason, cut_short, seconds)
    return packing, clock


def _teller(rows: list[RoundRow], options: RunOptions) -> Callable[[Record], None]:
    """Listener that numbers records, and appends them to the rows."""

    def tell(record: Record) -> None:
        rows.append(RoundRow.of(len(rows) + 1, record))
        options.on_round(rows[-1])

    return tell


def _in_parts(problem: Problem, options: RunOptions) -> tuple[PackedProblem, Clock]:
    """Pack parts side by side, if it is worth several; and the clock that watched them.

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
    rows, records, work = list[RoundRow](), list[Record](), WorkClock()
    tell = _teller(rows, options)

    def on_done(record: Record) -> None:
        records.append(record)
        tell(record)

    clock = Clock(task.time_limit, FINISHING * problem.expected_nodes, options.on_share)
    method = problem.method
    placement = method.placement.shared(problem.packed_domain, problem.packing_spacing, problem.packed_nodes)
    terms = Terms(
        problem.packing_spacing,
        target=problem.spacing if stay else None,
        method=replace(method, placement=placement),
        max_nodes=task.max_nodes,
    )

    def deadline() -> Deadline:
        clock.slowness = work.slowness()
        return Deadline.within(clock.left)

    workshop = Workshop(options.crew, keeping.store(scale_of(problem)), on_done, clock.tell)
    with stopwatch.stage("packing"):
        parted = packed_in_parts(problem.packed_domain, problem.packed_nodes, parts, terms, workshop, deadline)
        packed = parted if stay else parted.whole(problem.packing_spacing)
    cut_short = clock.cut_short() if any(record.late for record in records) else None
    why = "all parts and the seams between are packed" if cut_short is None else cut_short.reason
    nodes, speeds = [record.after.nodes for record in records[:parts]], tuple(record.speeds for record in records)
    row = PartsRow(parts, min(nodes), max(nodes), parted.on_cuts, parted.in_seams, problem.needs_all_at_once)
    seconds = stopwatch.seconds
    packing = PackedProblem(problem, parted.start, tuple(rows), speeds, packed, why, cut_short, seconds, parts=row)
    return packing, clock
