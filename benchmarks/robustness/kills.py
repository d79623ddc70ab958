"""Kills at random moments: ``python -m benchmarks.robustness kills --kills 50`` of each kind.

A run, a batch, a shard of one and a batch on a cluster are ended by SIGKILL, SIGTERM or SIGINT while they are at work.
Afterwards there is no half file, no process is left, what the summary has is there with its digest, and the same
command (with ``--resume``) finishes what is left.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path

from benchmarks.robustness.commands import begun, damage, ended
from benchmarks.robustness.trials import tell

CASE = """\
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: 0.1
method: accelerated
schedule: {rounds: 2, iterations: 20}
output: {formats: [msh, vtu]}
"""
CASES = 4
SWEEP = f"sweep: {{packing.seed: {list(range(CASES))}}}\n"
KINDS = {  # arguments of each kind of command
    "run": ("run", "one.yaml", "-o", "out"),
    "batch": ("batch", "a.yaml", "-o", "out", "-j", "2", "--resume"),
    "shard": ("batch", "a.yaml", "-o", "out", "-j", "1", "--resume", "--shard", "1/2"),
    "cluster": ("batch", "a.yaml", "-o", "out", "--resume", "--cluster"),
}
SIGNALS = signal.SIGKILL, signal.SIGTERM, signal.SIGINT
INTERRUPTED = 130
END = 300.0  # seconds that a process has to end after a signal, and its workers after it
MARK = "BUBBLEMESH_TRIAL"  # variable that tells the processes of a trial


def trial(kind: str, number: int, share: float, whole: float, address: str | None = None) -> list[str]:
    """What is wrong after a command was ended by a signal, after a share of the seconds that it takes on the whole."""
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        folder = Path(name)
        _write_cases(folder)
        process = _started(kind, folder, address)
        try:
            process.wait(share * whole)
        except subprocess.TimeoutExpired:
            process.send_signal(number)
        first = ended(process, END)
        expected = {0, INTERRUPTED} if number != signal.SIGKILL else {0, -signal.SIGKILL}
        problems = [] if first.code in expected else [f"exit code {first.code}: {first.message}"]
        problems += ["a traceback"] if "Traceback" in first.message else []
        problems += [f"processes are left: {left}" for left in [_left(folder)] if left]
        problems += damage(folder, strict=number != signal.SIGKILL)
        again = ended(_started(kind, folder, address), END)
        problems += [] if again.code == 0 else [f"going on ends with {again.code}: {again.message}"]
        return problems + damage(folder, strict=True) + _missing(kind, folder)


def _write_cases(folder: Path) -> None:
    (folder / "one.yaml").write_text(CASE)
    (folder / "a.yaml").write_text(CASE + SWEEP)


def _started(kind: str, folder: Path, address: str | None) -> "subprocess.Popen[str]":
    return begun(folder, *KINDS[kind], *([address] if address else []), environment={MARK: str(folder)})


def _left(folder: Path) -> list[int]:
    """Processes of a trial that have not ended some time after it."""
    until = time.monotonic() + END
    while left := [*_processes(str(folder))]:
        if time.monotonic() > until:
            break
        time.sleep(0.05)
    return left


def _processes(mark: str) -> Iterator[int]:
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}\0".encode() in (path / "environ").read_bytes():
                yield int(path.name)
        except OSError:  # it has ended, or is not ours
            continue


def _missing(kind: str, folder: Path) -> list[str]:
    """Meshes that are not there after the command has gone on to its end."""
    count = {"run": 1, "shard": CASES // 2}.get(kind, CASES)
    found = len(list((folder / "out").glob("*.msh")))
    return [] if found == count else [f"{found} meshes of {count}"]


@contextmanager
def cluster(environment: Mapping[str, str] = {}) -> Iterator[str]:
    """Address of a scheduler with two workers; the variables are those of them all."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="kills-")))

        def start(*arguments: str) -> None:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", *arguments, "--no-dashboard"],
                cwd=folder,
                env=os.environ | environment,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            stack.callback(process.wait)
            stack.callback(process.kill)

        file = folder / "scheduler.json"
        start("scheduler", "--port", "0", "--scheduler-file", str(file))
        until = time.monotonic() + END
        while not (file.exists() and file.read_text().endswith("}")):
            if time.monotonic() > until:
                raise RuntimeError("no scheduler has begun")
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        for _ in range(2):
            start("worker", address, "--nthreads", "1", "--no-nanny")
        yield address


def trials(kind: str, count: int, seed: int) -> Iterator[tuple[str, list[str]]]:
    """The signal and the moment of each of so many kills of a kind of command, and what is wrong after it."""
    rng = random.Random(f"{kind} {seed}")
    with cluster() if kind == "cluster" else nullcontext() as address:
        whole = _seconds(kind, address)
        for _ in range(count):
            number, share = rng.choice(SIGNALS), rng.random()
            yield f"{number.name} at {share * whole:.1f} of {whole:.1f} s", trial(kind, number, share, whole, address)


def _seconds(kind: str, address: str | None) -> float:
    """How long a command takes that is not ended."""
    with tempfile.TemporaryDirectory(prefix="kills-") as name:
        _write_cases(Path(name))
        return ended(_started(kind, Path(name), address), END).seconds


def main(arguments: list[str]) -> None:
    """Kill each kind of command so many times, and tell what is wrong afterwards."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robustness kills", description=__doc__)
    parser.add_argument("--kills", type=int, default=50, help="of each kind")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    tell((f"kills, {kind}", trials(kind, options.kills, options.seed)) for kind in options.kinds.split(","))
