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
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from hashlib import sha256
from pathlib import Path

from benchmarks.robustness.trials import tell

CASE = """\
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: 0.1
method: accelerated
schedule: {rounds: 2, iterations: 20}
output: {formats: [msh, vtu]}
"""
CASES = 6
SWEEP = f"sweep: {{packing.seed: {list(range(CASES))}}}\n"
KINDS = {  # arguments of each kind of command
    "run": ("run", "one.yaml", "-o", "out"),
    "batch": ("batch", "a.yaml", "-o", "out", "-j", "2", "--resume"),
    "shard": ("batch", "a.yaml", "-o", "out", "-j", "2", "--resume", "--shard", "1/2"),
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
        process = started(kind, folder, address)
        try:
            process.wait(share * whole)
        except subprocess.TimeoutExpired:
            process.send_signal(number)
        message = process.communicate(timeout=END)[1]
        expected = {0, INTERRUPTED} if number != signal.SIGKILL else {0, -signal.SIGKILL}
        problems = [] if process.returncode in expected else [f"exit code {process.returncode}: {message}"]
        problems += ["a traceback"] if "Traceback" in message else []
        problems += [f"processes are left: {left}" for left in [_left(folder)] if left]
        problems += damage(folder, strict=number != signal.SIGKILL)
        again = started(kind, folder, address)
        message = again.communicate(timeout=END)[1]
        problems += [] if again.returncode == 0 else [f"going on ends with {again.returncode}: {message}"]
        return problems + damage(folder, strict=True) + _missing(kind, folder)


def _write_cases(folder: Path) -> None:
    (folder / "one.yaml").write_text(CASE)
    (folder / "a.yaml").write_text(CASE + SWEEP)


def started(kind: str, folder: Path, address: str | None = None) -> "subprocess.Popen[str]":
    """A command that has begun in a folder."""
    line = [sys.executable, "-m", "bubblemesh", *KINDS[kind], *([address] if address else [])]
    environment = os.environ | {MARK: str(folder), "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(
        line, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )


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


def damage(folder: Path, strict: bool) -> list[str]:
    """Half files and rows whose files are not as they say; ``strict`` if nothing may be left over, either."""
    problems = []
    out = folder / "out"
    for path in out.glob("*.report.json"):
        try:
            names = json.loads(path.read_text())["files"]
        except ValueError:
            problems.append(f"{path.name} is not whole")
            continue
        problems += [f"{name} is missing" for name in names if not (out / name).exists()]
    for path in out.glob("summary*.jsonl"):
        *lines, rest = path.read_bytes().split(b"\n")
        # A kill may cut the last row, which is no row then.
        problems += [f"{path.name} ends within a row"] if rest and strict else []
        for line in lines:
            files = json.loads(line)["files"]
            problems += [f"{name} is not as its row says" for name in files if _digest(out / name) != files[name]]
    hidden = [path.name for path in out.glob(".*")] if strict else []
    return problems + [f"{name} is left over" for name in hidden]


def _missing(kind: str, folder: Path) -> list[str]:
    """Meshes that are not there after the command has gone on to its end."""
    count = {"run": 1, "shard": CASES // 2}.get(kind, CASES)
    found = len(list((folder / "out").glob("*.msh")))
    return [] if found == count else [f"{found} meshes of {count}"]


def _digest(path: Path) -> str | None:
    return sha256(path.read_bytes()).hexdigest() if path.exists() else None


@contextmanager
def cluster() -> Iterator[str]:
    """Address of a scheduler with two workers."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="kills-")))

        def start(*arguments: str) -> None:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", *arguments, "--no-dashboard"],
                cwd=folder,
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
        begun = time.monotonic()
        started(kind, Path(name), address).communicate()
        return time.monotonic() - begun


def main(arguments: list[str]) -> None:
    """Kill each kind of command so many times, and tell what is wrong afterwards."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robustness kills", description=__doc__)
    parser.add_argument("--kills", type=int, default=50, help="of each kind")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    tell((f"kills, {kind}", trials(kind, options.kills, options.seed)) for kind in options.kinds.split(","))
