"""Runs the cases of configs/paper, three starts each, and keeps what the page and the figures need."""

import cProfile
import pstats
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

from bubblemesh.case import Case, load_case
from bubblemesh.meshfiles.report_json import json_text
from bubblemesh.run.pipeline import Result, mesh_case

__all__ = ["CONFIGS", "SEEDS", "Runs", "measured", "profiled"]

CONFIGS = Path(__file__).parents[2] / "configs" / "paper"
SEEDS = (0, 1, 2)

# Functions whose time makes up a stage of Table 1, by the end of their file's name and their own name.
STAGES = {
    "initialization": [("placement.py", "__call__")],
    "adjacency": [("adjacency.py", "of")],
    "forces": [("forces.py", "__call__")],
    "new positions": [("relaxation.py", "__call__")],  # with the two before, which are taken off
    "population control": [("population.py", "__call__")],
}


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


def measured(names: Iterable[str], on_run: Callable[[str, int], None]) -> dict[str, Runs]:
    """Runs of the cases; those that differ by name only are run once.

    The seeds are the outer loop, so that a busy moment of the machine does not meet one case alone.
    """
    names = list(dict.fromkeys(names))
    cases = {name: load_case(CONFIGS / f"{name}.yaml") for name in names}
    first_of: dict[str, str] = {}
    same_as = {name: first_of.setdefault(_key(case), name) for name, case in cases.items()}
    results: dict[str, list[tuple[Result, float]]] = {name: [] for name in first_of.values()}
    for seed in SEEDS:
        for name, found in results.items():
            on_run(name, seed)
            case = load_case(CONFIGS / f"{name}.yaml", seed=seed)
            begun = process_time()
            result = mesh_case(case)
            found.append((result, process_time() - begun))
    return {name: _runs(cases[name], results[same_as[name]]) for name in names}


def _runs(case: Case, found: list[tuple[Result, float]]) -> Runs:
    return Runs(case, tuple(result for result, _ in found), tuple(seconds for _, seconds in found))


def _key(case: Case) -> str:
    return json_text(case.model_dump(mode="json", exclude={"name"}))


def profiled(name: str) -> dict[str, float]:
    """Share of each stage in the time of a run, in per cent."""
    profile = cProfile.Profile()
    case = load_case(CONFIGS / f"{name}.yaml")
    profile.runcall(mesh_case, case)
    stats: Any = pstats.Stats(profile)
    spent = {stage: sum(_cumulative(stats.stats, *where) for where in places) for stage, places in STAGES.items()}
    spent["new positions"] -= spent["forces"] + spent["adjacency"]
    return {stage: 100 * seconds / sum(spent.values()) for stage, seconds in spent.items()}


def _cumulative(stats: Mapping[tuple[str, int, str], tuple[Any, ...]], ending: str, function: str) -> float:
    return sum(row[3] for (file, _, name), row in stats.items() if Path(file).name == ending and name == function)
