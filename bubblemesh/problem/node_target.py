"""Node target: the scale of a spacing at which it asks for a number of nodes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from bubblemesh.errors import NODE_LIMIT, CaseError, Key, LimitError, NodeLimitError, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.checked import CheckedProblem
from bubblemesh.problem.problem import Problem, Task
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.records import record
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import rough_nodes

TOLERANCE = 5e-3  # of the target, for the number that is expected
TOLERANCE_OF_MESHES = 0.02  # of the target, or one node if they are few
CLOSE = 0.01  # to a target, in terms of it: what is farther off is another number
MOST_TRIALS = 15
MOST_STEP = np.log(8.0)  # of the rough number, from one trial to the next
FLATTEST, STEEPEST = 0.1, 10.0  # slope of the true over the rough number; what is steeper jumps
WIDEST = 18 * np.log(10.0)  # natural logarithm of the extreme scales
NEAR_THE_END = 1e-3  # relative: where no scale changes the rough number any more

FLATTEST_OF_MESHES = 0.5  # slope of the nodes that are found over those that are expected, in logarithms
FEW = 100_000  # nodes that the search for a scale may count, whatever the target is
SAME = 0.1  # of a node: scales that differ by less lead to the same mesh, or to both sides of a jump in the number
TIMES_TOO_MANY = 4  # the target: more nodes need no counting

CountTrial = tuple[float, float]  # logarithms of the rough number and of the true one
Found = TypeVar("Found")


@record
class Scales:
    """Scales for rough numbers of nodes, in logarithms: ``rough`` falls with the scale."""

    rough: Callable[[float], float]

    @classmethod
    def of(cls, domain: Domain, scaled: Callable[[float], Spacing]) -> "Scales":
        """Scales of the spacing that ``scaled`` gives at a scale."""
        count = rough_nodes(domain)
        return cls(lambda u: float(np.log(count(scaled(float(np.exp(u)))))))

    @cached_property
    def ends(self) -> CountTrial:
        """The fewest and the most nodes that any scale leads to."""
        low, high = self.rough(WIDEST), self.rough(-WIDEST)
        margin = min(NEAR_THE_END, (high - low) / 4)
        return low + margin, high - margin

    def at(self, aim: float) -> float:
        """The scale for a number of nodes between the ends."""
        # Imported here since it takes longer than meshing a small case, and most cases request no number.
        from scipy.optimize import brentq

        guess = (self.rough(0.0) - aim) / 2  # where the number goes with the inverse square of the scale
        reach = 1.0
        while reach < 2 * WIDEST and not self.rough(guess + reach) <= aim <= self.rough(guess - reach):
            reach *= 4
        return float(np.exp(brentq(lambda u: self.rough(u) - aim, guess - reach, guess + reach, xtol=1e-9)))


@record
class ScaleSearch:
    """Search for scales of a spacing at which some numbers of nodes are expected."""

    nodes: int  # the target
    scales: Scales
    check: Callable[[Task, Stopwatch, float], CheckedProblem]  # gives the problem at a scale
    task: Task
    seconds: Mapping[str, float]  # taken before
    key: Key  # of the target in the case
    nearest: Callable[[int], str] | None = None  # if the nearest number will do, the warning of another one
    warnings: tuple[str, ...] = ()  # of each problem

    def problem(self, expected: float, start: float | None = None, known: Sequence[CountTrial] = ()) -> Problem:
        """The problem in which so many nodes are expected; from a rough number to start from, as nearly as can be.

        What is ``known`` of trials before shows where the number jumps.
        """
        exact = start is None and self.nearest is None
        spent = replace(self.task, max_nodes=max(FEW, TIMES_TOO_MANY * self.nodes))
        stopwatch = Stopwatch(self.seconds)

        def at(scale: float) -> tuple[float, CheckedProblem | None]:
            try:
                checked = self.check(spent, stopwatch, scale)
            except LimitError:
                return np.inf, None
            return checked.problem.expected_nodes, checked

        with stopwatch.stage("spacing"):
            scale, checked, trials = scaled_to(expected, self.scales, at, start, self.key if exact else None, known)
        if checked is None and self.nearest is not None:
            checked = self.check(self.task, stopwatch, scale)  # which has more than were to be counted
        if checked is None:
            with at_key(*self.key):
                raise out_of_reach(expected, np.inf)
        problem = checked.told(stopwatch)
        return self.of(replace(problem, task=self.task), scale, (*known, *trials))

    def of(self, problem: Problem, scale: float, trials: tuple[CountTrial, ...] = ()) -> Problem:
        """The problem at a scale that trials led to, which is made anew at others where its mesh misses the target."""
        target = NodeTarget(self.nodes, scale, self.scales.rough(np.log(scale)), self, trials)
        return replace(problem, node_target=target, warnings=(*problem.warnings, *self.warnings))

    def instead(self, nodes: int) -> "ScaleSearch":
        """The search for another number, with a warning that says so."""
        return self if self.nearest is None else replace(self, nodes=nodes, warnings=(self.nearest(nodes),))


@record
class NodeTarget:
    """A number of nodes, and a scale of the spacing at which about so many are expected."""

    nodes: int
    scale: float
    rough: float  # logarithm of the rough number of nodes at that scale
    search: ScaleSearch  # that finds other scales
    trials: tuple[CountTrial, ...] = ()  # that are known

    def is_missed_by(self, nodes: int) -> bool:
        """Whether a mesh of so many nodes has too many or too few."""
        return abs(nodes - self.nodes) > max(TOLERANCE_OF_MESHES * self.nodes, 1)

    def is_near(self, scale: float) -> bool:
        """Whether another scale would change the number, which goes with its inverse square, by next to nothing."""
        return bool(abs(np.log(scale / self.scale)) < SAME / (2 * self.nodes))


def fit_node_target(search: ScaleSearch, known: Sequence[CountTrial] = ()) -> Problem:
    """Make the problem in which the target is expected; a CaseError or LimitError says that no scale does it.

    Trials of a like search that are ``known`` may spare those of this one.
    If the nearest number will do, that is the target from then on.
    """
    nodes, limit = search.nodes, search.task.max_nodes
    if search.nearest is not None:
        return _nearest(search, known)
    if nodes > limit:
        raise NodeLimitError(
            f"{NODE_LIMIT}: {search.key} asks for {nodes}, more than the limit of {limit}: ask for "
            "fewer or raise the limit"
        )
    return search.problem(nodes, known=known)


def _nearest(search: ScaleSearch, known: Sequence[CountTrial]) -> Problem:
    """Make the problem in which the target is expected, or the nearest number; a LimitError if that is too much."""
    limit = search.task.max_nodes
    problem = search.problem(min(search.nodes, limit), known=known)
    expected, found = problem.expected_nodes, problem.node_target
    if found is None or abs(expected - search.nodes) <= CLOSE * search.nodes:
        return problem
    if expected > (1 + CLOSE) * limit:
        with at_key("limits", "max_nodes"):
            raise out_of_reach(limit, expected)
    return search.instead(round(expected)).of(problem, found.scale, found.trials)


def correct(problem: Problem, target: NodeTarget, found: Sequence[tuple[float, int]]) -> Problem:
    """Make the last problem that was meshed anew with a better scale, or the same one if it is the last.

    Pairs in ``found`` are the expected number and the number of nodes of each mesh so far.
    """
    trials = [(np.log(expected), np.log(meshed)) for expected, meshed in found]
    aim = next_aim(trials, np.log(target.nodes), FLATTEST_OF_MESHES)
    start = np.exp(target.rough + aim - np.log(problem.expected_nodes))
    return target.search.problem(np.exp(aim), start, target.trials)


def scaled_to(
    nodes: float,
    scales: Scales,
    at: Callable[[float], tuple[float, Found]],
    start: float | None = None,
    key: Key | None = None,
    known: Sequence[CountTrial] = (),
) -> tuple[float, Found, list[CountTrial]]:
    """Find the scale at which a spacing asks for so many nodes; ``at`` a scale are the true number and what has it.

    The secant method on logarithms, over the rough number, which is quickly known, instead of the scale: the true
    number, infinite where it is far too large, is nearly proportional to it. It begins at the rough number ``start``,
    else at the target. What was found at other scales is not kept, but for the numbers, which come out too.

    Where the number jumps across the target, as where layers get one column more, no scale comes nearer than both
    sides: the search ends. If trials ``known`` before have found that already, it looks at the nearer side only.

    If the number is out of reach, the result is the nearest scale, or with a ``key`` an error that names it:

    - CaseError if the limits of the spacing do not let it be that fine;
    - LimitError if they, or the boundary, do not let it be that coarse.
    """
    target, ends = np.log(nodes), scales.ends
    aim = target if start is None else np.log(start)
    trials, nearest = list[CountTrial](), np.inf
    last = np.inf  # the number with which it ends, if any
    if jumps_across(known, target):
        aim, last = min(known, key=lambda trial: abs(trial[1] - target))
    for _ in range(MOST_TRIALS):
        aim = float(np.clip(aim, *ends))
        scale = scales.at(aim)
        count, found = at(scale)
        trial = aim, float(np.log(count))
        trials.append(trial)
        if abs(trial[1] - target) <= nearest:
            nearest, best = abs(trial[1] - target), (scale, found)
        del found  # or what is not the best stays while the next one is made
        if nearest <= TOLERANCE:
            break
        if (trial[1] > target and aim == ends[0]) or (trial[1] < target and aim == ends[1]):
            if key is None:
                break
            with at_key(*key):
                raise out_of_reach(nodes, float(np.exp(trial[1])))
        if jumps_across(trials, target) or abs(trial[1] - last) <= TOLERANCE:
            break
        aim = next_aim(trials, target)
    return *best, trials


def jumps_across(trials: Sequence[CountTrial], target: float) -> bool:
    """Whether the true number jumps across the target between the trials on both sides of it."""
    below = max((trial for trial in trials if trial[1] < target), default=None)
    above = min((trial for trial in trials if target <= trial[1] < np.inf), default=None)
    if below is None or above is None:
        return False
    return abs(above[1] - below[1]) > STEEPEST * abs(above[0] - below[0])


def next_aim(trials: Sequence[CountTrial], target: float, flattest: float = FLATTEST) -> float:
    """Rough number to try next: by the secant through the two best trials, half-way between both sides, or beyond one.

    It is finite: where more was found by fewer on the one side that is known, it is a step from there.
    """
    finite = [trial for trial in trials[::-1] if np.isfinite(trial[1])]  # of equally good ones the last one leads on
    finite.sort(key=lambda trial: abs(trial[1] - target))
    below = max((x for x, y in trials if y < target), default=-np.inf)
    above = min((x for x, y in trials if y >= target), default=np.inf)
    if not finite:
        return above - MOST_STEP
    (x, y), *others = finite
    slope = 1.0
    if others and others[0][0] != x:
        slope = max((others[0][1] - y) / (others[0][0] - x), flattest)
    aim = x + float(np.clip((target - y) / slope, -MOST_STEP, MOST_STEP))
    if below < aim < above:
        return aim
    if not np.isfinite(above):
        return below + MOST_STEP
    return (below + above) / 2 if np.isfinite(below) else above - MOST_STEP


def out_of_reach(nodes: float, closest: float) -> CaseError | LimitError:
    """Error for a number of nodes that no scale reaches; ``closest`` is the nearest number that one does reach."""
    if closest < nodes:  # all terms go with the scale: only a minimum can stop them
        return CaseError(
            f"{nodes:.0f} nodes are more than the spacing allows where it is finest, which are at most about "
            f"{closest:.0f}: ask for fewer, or lower its minimum if it has one"
        )
    needed = f"at least about {closest:.0f}" if np.isfinite(closest) else "far more"
    return LimitError(
        f"{nodes:.0f} nodes are too few: the boundary and the other keys of the spacing need {needed}: "
        "ask for more, or for less detail"
    )
