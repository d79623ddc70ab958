"""A wall clock that jumps in the middle of a command: ``python -m benchmarks.robustness clock``.

A small library, compiled here and put before the system's, moves the time of day that programs see, by hours or years
forwards or backwards, in all processes at the same moment. A time limit is kept as if nothing had happened, the times
that a report or a row tells are those that have passed, and ``--resume`` meshes nothing anew.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import nullcontext
from pathlib import Path

from benchmarks.robustness.commands import Ended, begun, command, compiled, damage, ended, square_case
from benchmarks.robustness.kills import cluster
from benchmarks.robustness.trials import tell
from bubblemesh.errors import LimitError

LIBRARY = r"""
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/time.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static time_t shift(void) {
    char text[32] = "";
    const char *name = getenv("CLOCK_FILE");
    int before = errno, file = name ? open(name, O_RDONLY) : -1;
    if (file >= 0) read(file, text, sizeof text - 1), close(file);
    errno = before;
    return atol(text);
}

int clock_gettime(clockid_t id, struct timespec *now) {
    int failed = syscall(SYS_clock_gettime, id, now);
    if (!failed && (id == CLOCK_REALTIME || id == CLOCK_REALTIME_COARSE)) now->tv_sec += shift();
    return failed;
}

int gettimeofday(struct timeval *now, void *zone) {
    struct timespec exact;
    int failed = clock_gettime(CLOCK_REALTIME, &exact);
    now->tv_sec = exact.tv_sec, now->tv_usec = exact.tv_nsec / 1000;
    return failed;
}

time_t time(time_t *to) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (to) *to = now.tv_sec;
    return now.tv_sec;
}
"""
HOUR, YEAR = 3600, 365 * 24 * 3600
JUMPS = {"2 hours on": 2 * HOUR, "2 hours back": -2 * HOUR, "10 years on": 10 * YEAR, "10 years back": -10 * YEAR}
LIMIT = 6  # seconds of a time limit, of which some are kept for the end of a run: the more, the busier the machine is
MOMENTS = 0.2, 2.5  # seconds after the beginning of a command
START = 30.0  # seconds that a process may take to begin and to end
LONG = square_case(0.05, "rounds: 1000, iterations: 1000, termination: fixed", "bpm")
SHORT = f"{square_case(0.1, 'rounds: 2, iterations: 20')}sweep: {{packing.seed: [1, 2, 3, 4]}}\n"
Jumping = Callable[..., Ended]  # makes a command, given a folder and arguments, in which the clock jumps

BATCH = ("batch", "a.yaml", "-q", "-o", "out", "--resume")


def _run(folder: Path, jumping: Jumping, _: str | None) -> list[str]:
    """What is wrong with a run to a time limit in which the clock jumps."""
    (folder / "a.yaml").write_text(LONG)
    done = jumping(folder, "run", "a.yaml", "-o", "out/", "-q", "--time-limit", f"{LIMIT}")
    problems = _problems(done, LIMIT + START, {0, LimitError.exit_code})
    problems += [f"it ends after {done.seconds:.1f} s"] if done.seconds < LIMIT / 2 else []
    for path in folder.glob("out/*.report.json"):
        seconds = json.loads(path.read_text())["seconds"]
        problems += _wrong_times(seconds, done)
    return problems + damage(folder, strict=True)


def _batch(folder: Path, jumping: Jumping, address: str | None) -> list[str]:
    """What is wrong with a batch in which the clock jumps, and with another one that goes on after it."""
    (folder / "a.yaml").write_text(SHORT)
    done = jumping(folder, *BATCH, *(("-j", "2") if address is None else ("--cluster", address)))
    problems = _problems(done, 10 * START) + damage(folder, strict=True)
    meshes = {path: path.stat().st_mtime_ns for path in folder.glob("out/*.msh")}
    problems += [] if len(meshes) == 4 else [f"{len(meshes)} meshes of 4"]
    for path in folder.glob("out/summary.jsonl"):
        for line in path.read_text().splitlines():
            problems += _wrong_times({"all": json.loads(line)["seconds"]}, done)
    problems += _problems(command(folder, *BATCH), 2 * START)  # by the right clock
    again = [path.name for path, changed in meshes.items() if path.stat().st_mtime_ns != changed]
    return problems + [f"{name} is meshed again" for name in again]


def _problems(done: Ended, most: float, codes: Collection[int] = (0,)) -> list[str]:
    problems = done.problems if done.code in codes else [*done.problems, f"exit code {done.code}: {done.message}"]
    return problems + ([f"it takes {done.seconds:.0f} s"] if done.seconds > most else [])


def _wrong_times(seconds: dict[str, float], done: Ended) -> list[str]:
    return [f"{name} takes {value} s" for name, value in seconds.items() if not 0 <= value <= done.seconds]


KINDS: dict[str, Callable[[Path, Jumping, str | None], list[str]]] = {"run": _run, "batch": _batch, "cluster": _batch}


def trials(kind: str, library: Path) -> Iterator[tuple[str, list[str]]]:
    """Each jump, some moments after the beginning of a command, and what is wrong then."""
    with cluster(_preloaded(library)) if kind == "cluster" else nullcontext() as address:
        for name, seconds in JUMPS.items():
            for moment in MOMENTS:
                yield f"{name} after {moment:g} s", trial(kind, library, seconds, moment, address)


def trial(kind: str, library: Path, seconds: int, moment: float, address: str | None = None) -> list[str]:
    """What is wrong after a jump of the clock by so many seconds, at some moment after a command's beginning."""
    environment = _preloaded(library)
    clock = Path(environment["CLOCK_FILE"])

    def jumping(folder: Path, *arguments: str) -> Ended:
        process = begun(folder, *arguments, environment=environment)
        time.sleep(moment)
        clock.write_text(f"{seconds}")
        done = ended(process)
        return done._replace(seconds=done.seconds + moment)

    with tempfile.TemporaryDirectory(prefix="clock-") as name:
        try:
            return KINDS[kind](Path(name), jumping, address)
        finally:
            clock.unlink()  # back again


def _preloaded(library: Path) -> dict[str, str]:
    return {"LD_PRELOAD": str(library), "CLOCK_FILE": str(library.with_name("clock"))}


def main(arguments: list[str]) -> None:
    """Let the clock jump, and tell what is wrong afterwards."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robustness clock", description=__doc__)
    parser.add_argument("--kinds", default=",".join(KINDS))
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="clock-") as folder:
        library = compiled(Path(folder), LIBRARY)
        tell((f"clock, {kind}", trials(kind, library)) for kind in options.kinds.split(","))
