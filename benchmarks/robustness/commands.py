"""Commands in folders of their own, and what must hold in a folder whatever has become of a command."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

LONGEST = 300.0  # seconds after which a command hangs, also on a machine that has much else to do


def square_case(spacing: float, schedule: str, method: str = "accelerated") -> str:
    """A case of a square whose mesh is one file."""
    return f"""\
domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}
spacing: {spacing:g}
method: {method}
schedule: {{{schedule}}}
output: {{formats: [msh]}}
"""


class Ended(NamedTuple):
    """How a command ended."""

    code: int
    message: str  # what it has said on the standard error
    seconds: float

    @property
    def problems(self) -> list[str]:
        """What no command may do: hang, or end with a traceback or an error of the program."""
        found = [f"it hangs: {self.message}"] if self.code == -signal.SIGKILL else []
        return found + ([f"a traceback: {self.message}"] if "Traceback" in self.message or self.code == 1 else [])


def begun(folder: Path, *arguments: str, environment: Mapping[str, str] = {}) -> "subprocess.Popen[str]":
    """A command of bubblemesh that has begun in a folder; nobody reads its standard output."""
    line = [sys.executable, "-m", "bubblemesh", *arguments]
    own = os.environ | {"OMP_NUM_THREADS": "1"} | environment
    return subprocess.Popen(line, cwd=folder, env=own, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def ended(process: "subprocess.Popen[str]", longest: float = LONGEST) -> Ended:
    """The end of a command, which is killed if it hangs."""
    since = perf_counter()
    try:
        message = process.communicate(timeout=longest)[1]
    except subprocess.TimeoutExpired:
        process.kill()
        message = process.communicate()[1]
    return Ended(process.returncode, message, perf_counter() - since)


def command(folder: Path, *arguments: str, environment: Mapping[str, str] = {}) -> Ended:
    """The end of a command of bubblemesh in a folder."""
    return ended(begun(folder, *arguments, environment=environment))


def compiled(folder: Path, source: str) -> Path:
    """A library, from its source in C, to be put before the system's by the variable ``LD_PRELOAD``."""
    text, library = folder / "library.c", folder / "library.so"
    text.write_text(source)
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-w", "-o", str(library), str(text), "-ldl"], check=True)
    return library


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


def _digest(path: Path) -> str | None:
    return sha256(path.read_bytes()).hexdigest() if path.exists() else None
