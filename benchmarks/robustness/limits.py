"""Cases of very many parts with a time limit: ``python -m benchmarks.robustness limits --seconds 2``.

Each is checked and run: it ends in time, or with the exit code of a limit and the stage that was too slow, at most a
second or a tenth of the limit after it. What a command takes that has nothing to do is not counted, nor is it wrong to
be late on a machine whose cores have other work: the load is told beside the times.
"""

import argparse
import os
import resource
import tempfile
from collections.abc import Iterable
from pathlib import Path
from statistics import mean

from benchmarks.robustness.commands import Ended, command
from benchmarks.robustness.trials import note
from benchmarks.scaling import CASES
from bubblemesh.errors import LimitError
from bubblemesh.process.watchdog import STAGES

PARTS = {  # numbers of parts that were too many once
    "circle": (300_000,),
    "star": (4_000,),
    "zigzag": (40_000, 100_000),
    "circular holes": (20_000,),
    "points": (100_000,),
    "parameters": (200_000,),
    "lines": (300_000,),
    "dashes": (100_000,),
}
COMMANDS = {"check": (), "run": ("-o", "out/")}


def timed(folder: Path, text: str, what: str) -> tuple[Ended, float]:
    """The end of a command with a case, and the seconds of processors that it took."""
    (folder / "a.yaml").write_text(text)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = command(folder, what, "a.yaml", "-q", *COMMANDS[what])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def problems(done: Ended, is_late: bool) -> list[str]:
    """What is wrong with the end of a command."""
    stages = [row.doing for row in STAGES.values() if row.doing in done.message]
    wrong = [] if done.code in (0, LimitError.exit_code) else [f"exit code {done.code}: {done.message}"]
    wrong += ["no stage is named"] if done.code == LimitError.exit_code and not stages else []
    return [*done.problems, *wrong, *(["too late"] if is_late else [])]


def main(arguments: Iterable[str]) -> None:
    """Measure all, print a line for each, and note the longest."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robustness limits", description=__doc__)
    parser.add_argument("--seconds", type=float, default=2.0)
    limit = parser.parse_args(arguments).seconds
    most, times, loads, bad = limit + max(1.0, limit / 10), [], [], 0
    with tempfile.TemporaryDirectory(prefix="limits-") as name:
        folder = Path(name)
        for kind, n in ((kind, n) for kind, numbers in PARTS.items() for n in numbers):
            text = f"{CASES[kind][0](n)}limits: {{seconds: {limit:g}}}\n"
            for what in COMMANDS:
                idle = timed(folder, "", what)[0].seconds
                done, worked = timed(folder, text, what)
                seconds = done.seconds - idle
                load = os.getloadavg()[0]
                found = problems(done, seconds > most and load < (os.cpu_count() or 1))
                times, loads, bad = [*times, seconds], [*loads, load], bad + bool(found)
                end = next((stage for stage, row in STAGES.items() if row.doing in done.message), "done")
                print(f"{n:8,} {kind:16} {what:6} {seconds:5.1f} s, processors {worked:5.1f} s, load {load:.1f}: {end}")
                print(*found, sep="\n", end="\n" * bool(found), flush=True)
    seconds, load = f"s at most for a limit of {limit:g} s", "mean load"
    note("limits", {"trials": len(times), "wrong": bad, seconds: round(max(times), 1), load: round(mean(loads), 1)})
    raise SystemExit(bad > 0)
