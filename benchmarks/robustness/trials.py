"""What trials share: findings are told as they come, rows go to a file from which a later run goes on."""

import argparse
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from benchmarks.robustness.capped import Call, called

OUTCOMES = Path(__file__).with_name("outcomes.json")  # of which the page tells

Row = dict[str, Any]
Trials = Iterable[tuple[str, list[str]]]  # the name of each trial, and what is wrong after it


def tell(groups: Iterable[tuple[str, Trials]], outcomes: Path = OUTCOMES) -> None:
    """Print what is wrong in each group of trials, note how many there were, and exit with 1 if anything is."""
    bad = 0
    for group, trials in groups:
        begun, count, wrong = perf_counter(), 0, 0
        for name, problems in trials:
            count, wrong = count + 1, wrong + bool(problems)
            for problem in problems:
                print(f"{group}, {name}: {problem}", flush=True)
        note(group, {"trials": count, "wrong": wrong}, outcomes)
        print(f"{group}: {count} trials in {perf_counter() - begun:.0f} s, {wrong} with something wrong", flush=True)
        bad += wrong
    raise SystemExit(bad > 0)


def note(group: str, figures: Row, outcomes: Path = OUTCOMES) -> None:
    """Keep the figures of a group of trials in place of those of an earlier run."""
    outcomes.write_text(json.dumps(noted(outcomes) | {group: figures}, indent=1, sort_keys=True) + "\n")


def noted(outcomes: Path = OUTCOMES) -> dict[str, Row]:
    """Figures of each group of trials that has been run."""
    return dict(json.loads(outcomes.read_text())) if outcomes.exists() else {}


def row_options(name: str, seconds: float, megabytes: int, description: str | None) -> argparse.ArgumentParser:
    """Parser of the options of a trial whose rows go to a file."""
    parser = argparse.ArgumentParser(prog=f"python -m benchmarks.robustness {name}", description=description)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=seconds, help="time for each")
    parser.add_argument("--megabytes", type=int, default=megabytes, help="memory for each process")
    parser.add_argument("--rows", type=Path, default=Path(f"robustness-{name}.jsonl"))
    return parser


def completed(
    function: Callable[[Row], Row], row_of: Callable[[Call], Row], tasks: Sequence[Row], options: argparse.Namespace
) -> list[Row]:
    """Rows of all tasks, by their names: those that the file has, and those of calls, added to it as these end."""
    done = {row["name"] for row in read_rows(options.rows)}
    left = [task for task in tasks if task["name"] not in done]
    with options.rows.open("a") as file:
        for call in called(function, left, options.jobs, options.seconds, options.megabytes):
            file.write(json.dumps(row_of(call)) + "\n")
            file.flush()
    names = {task["name"] for task in tasks}
    return [row for row in read_rows(options.rows) if row["name"] in names]


def read_rows(path: Path) -> list[Row]:
    """Rows that an earlier run has left."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def counted_outcomes(rows: Iterable[Row]) -> Iterator[str]:
    """Lines with the number of rows of each outcome."""
    for outcome, count in sorted(Counter(row["outcome"] for row in rows).items()):
        yield f"{count:6} {outcome}"
