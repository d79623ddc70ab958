"""Runs the cases of configs/paper, three starts each, and keeps what the page and the figures need."""

import cProfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

from bubblemesh.case import Case, load_case
from bubblemesh.meshfiles.text import json_text
from bubblemesh.packing.forces import BoundForce
from bubblemesh.packing.neighbours import Neighbours
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.pipeline import Result, mesh_case

CONFIGS = Path(__file__).parents[2] / "configs" / "paper"
SEEDS = (0, 1, 2)


@dataclass(frozen=True)
class Runs:
    """A case with the results for each seed, and the processor seconds of packing."""

    case: Case
    results: tuple[Result, ...]
    seconds: tuple[float, ...]

    @property
    def first(self) -> Result:
        """The run with the seed 0."""
        return self.results[0]

    def figures(self, key: Callable[[Mapping[str, Any]], float]) -> list[float]:
        """A figure of the reports, for each seed."""
        return [key(result.report) for result in self.results]

    def by_round(self, key: str) -> list[list[float]]:
        """A figure after each round, for each seed, where all seeds have as many rounds."""
        reports = [result.report["rounds"] for result in self.results]
        return [[row[key] for row in rows] for rows in zip(*reports, strict=True)]

    @property
    def cost(self) -> float:
        """Median number of force evaluations on a bubble."""
        return median(self.figures(lambda report: report["force_evaluations"]))

    @property
    def time(self) -> float:
        """Median seconds."""
        return median(self.seconds)


def measured(names: Iterable[str], tell: Callable[[str], None]) -> dict[str, Runs]:
    """Runs of the cases; those that differ by name only are run once. ``tell`` hears of each run as it begins.

    The seeds are the outer loop, so that a busy moment of the machine does not meet one case alone.
    """
    names = list(dict.fromkeys(names))
    cases = {name: load_case(CONFIGS / f"{name}.yaml") for name in names}
    first_of: dict[str, str] = {}
    same_as = {name: first_of.setdefault(_key(case), name) for name, case in cases.items()}
    results: dict[str, list[tuple[Result, float]]] = {name: [] for name in first_of.values()}
    turns = [(seed, name) for seed in SEEDS for name in results]
    for number, (seed, name) in enumerate(turns, start=1):
        tell(f"[{number}/{len(turns)}] {name}, seed {seed}")
        case = load_case(CONFIGS / f"{name}.yaml", seed=seed)
        begun = process_time()
        result = mesh_case(case)
        results[name].append((result, process_time() - begun))
    return {name: _runs(cases[name], results[same_as[name]]) for name in names}


def _runs(case: Case, found: list[tuple[Result, float]]) -> Runs:
    return Runs(case, tuple(result for result, _ in found), tuple(seconds for _, seconds in found))


def _key(case: Case) -> str:
    return json_text(case.model_dump(mode="json", exclude={"name"}))


def profiled(case: Case) -> dict[str, float]:
    """Share of each stage of Table 1 in the time of a run, in per cent."""
    method = prepare(case).method
    functions = {
        "initialization": type(method.placement).__call__,
        "adjacency": Neighbours.of.__func__,
        "forces": BoundForce.__call__,
        "new positions": type(method.relaxation).__call__,  # with the two before, which are taken off
        "population control": type(method.population).__call__,
    }
    profile = cProfile.Profile()
    profile.runcall(mesh_case, case)
    cumulative = {entry.code: entry.totaltime for entry in profile.getstats()}
    spent = {stage: cumulative[function.__code__] for stage, function in functions.items()}
    spent["new positions"] -= spent["forces"] + spent["adjacency"]
    return {stage: 100 * seconds / sum(spent.values()) for stage, seconds in spent.items()}
