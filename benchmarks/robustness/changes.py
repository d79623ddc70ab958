"""Files that change in the middle of a batch: ``python -m benchmarks.robustness changes``.

Case files, their bases and the geometry that they name are edited, deleted, or replaced by links, pipes and folders
over and over while a batch reads them. Each case that it finds gets its row: an error, or the mesh of files each of
which is as it was before or after a change. Cases whose files stay have their meshes, nothing hangs, and when all is as
before ``--resume`` finishes the batch with the meshes of the old files only.
"""

import argparse
import json
import os
import random
import shutil
import time
from collections.abc import Callable, Iterator
from functools import cache
from itertools import product
from pathlib import Path
from subprocess import Popen
from tempfile import TemporaryDirectory

from benchmarks.robustness.commands import begun, command, damage, ended
from benchmarks.robustness.trials import tell

CASES = 8  # of which every other one is left in peace
PAUSE = 0.003  # seconds between changes, at most
REFUSALS = 2, 3, 5  # exit codes
MODES = {"trusted": (), "untrusted": ("--untrusted",)}
CASE = """\
base: NAME.base
domain: {file: NAME.csv}
spacing: 0.25
schedule: {rounds: 1, iterations: 5}
output: {formats: [msh]}
"""
FILES = {  # what each file of a case has, before a change and after it
    ".yaml": (CASE, CASE.replace("0.25", "0.2")),
    ".csv": ("x, y\n0, 0\n1, 0\n1, 1\n0, 1\n", "x, y\n0, 0\n2, 0\n2, 1\n0, 1\n"),
    ".base": ("method: accelerated\n", "method: bpm\n"),
}


def _replace(path: Path, text: str) -> None:
    new = path.with_name(f"{path.name}-new")
    new.write_text(text)
    _clear(path, folders_only=True)
    new.replace(path)


def _edit(path: Path, text: str) -> None:
    path.write_text(text)


def _clear(path: Path, *, folders_only: bool = False) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    elif not folders_only:
        path.unlink(missing_ok=True)


def _link(to: str) -> Callable[[Path, str], None]:
    return lambda path, _: os.symlink(to.format(ending=path.suffix, name=path.name), path)  # noqa: PTH211


def _delete(path: Path, _: str) -> None:
    """Leave nothing in the place of the file."""


CHANGES: dict[str, Callable[[Path, str], None]] = {  # given a place where nothing is, but for the first two
    "replaced": _replace,
    "edited in place": _edit,
    "deleted": _delete,
    "link to another case": _link("c1{ending}"),
    "link to nowhere": _link("nowhere"),
    "link to itself": _link("{name}"),
    "link to elsewhere": _link("/etc/passwd"),
    "link to a device": _link("/dev/zero"),
    "pipe": lambda path, _: os.mkfifo(path),
    "folder": lambda path, _: path.mkdir(),
}


def trial(change: str, options: tuple[str, ...], seed: int) -> list[str]:
    """What is wrong with a batch in which every other case is changed in this way and changed back over and over."""
    with TemporaryDirectory(prefix="changes-") as name:
        folder = Path(name).resolve()
        _write(folder / "cases", {f"c{k}": tuple(old for old, _ in FILES.values()) for k in range(CASES)})
        batch = ("batch", "cases", "-o", "out", "-j", "2", "-q", *options)
        process = begun(folder, *batch)
        _change(folder / "cases", change, random.Random(seed), process)
        done = ended(process)
        problems = done.problems + ([] if done.code in (0, *REFUSALS) else [f"exit code {done.code}: {done.message}"])
        problems += damage(folder, strict=True) + _wrong_rows(folder, peaceful=False)
        _write(folder / "cases", {f"c{k}": tuple(old for old, _ in FILES.values()) for k in range(0, CASES, 2)})
        again = command(folder, *batch, "--resume")
        problems += [] if again.code == 0 else [f"going on ends with {again.code}: {again.message}"]
        return problems + damage(folder, strict=True) + _wrong_rows(folder, peaceful=True)


def _write(folder: Path, cases: dict[str, tuple[str, ...]]) -> None:
    """Write the files of cases, each a text for each ending, over whatever is there."""
    folder.mkdir(exist_ok=True)
    for name, texts in cases.items():
        for ending, text in zip(FILES, texts, strict=True):
            path = folder / f"{name}{ending}"
            _clear(path)
            path.write_text(text.replace("NAME", name))


@cache
def _known_meshes() -> dict[str, int]:
    """How many of a case's files are new in each of all the meshes that there can be, by the mesh's digest."""
    with TemporaryDirectory(prefix="changes-") as name:
        folder = Path(name)
        _write(folder / "all", {f"k{k}": texts for k, texts in enumerate(product(*FILES.values()))})
        done = command(folder, "batch", "all", "-o", "known", "-j", "2", "-q")
        if done.code:
            raise RuntimeError(done.message)
        digests = [_mesh(row) for row in sorted(_rows(folder / "known"), key=lambda row: int(row["case"][1:]))]
    return {digest: k.bit_count() for k, digest in enumerate(digests)}


def _change(cases: Path, change: str, chance: random.Random, process: "Popen[str]") -> None:
    """Change files of every other case, and change them back, until a process ends."""
    while process.poll() is None:
        path = cases / f"c{chance.randrange(0, CASES, 2)}{chance.choice([*FILES])}"
        old, new = (text.replace("NAME", path.stem) for text in FILES[path.suffix])
        if chance.random() < 0.5:
            _clear(path) if change not in ("replaced", "edited in place") else None
            CHANGES[change](path, new)
        elif change == "edited in place":
            _edit(path, old)
        else:
            _replace(path, old)
        time.sleep(PAUSE * chance.random())


def _wrong_rows(folder: Path, peaceful: bool) -> list[str]:
    """What is wrong with the rows of a batch; if it was ``peaceful``, each has to have the mesh of its old files."""
    known, rows = _known_meshes(), {row["case"]: row for row in _rows(folder / "out")}
    expected = {f"c{k}" for k in range(CASES) if peaceful or k % 2}  # others may be no files when they are looked for
    problems = [f"{name} has no row" for name in expected - rows.keys()]
    for name, row in rows.items():
        place = f"{name} ({row['source']})"
        if row["exit_code"] != 0 and (peaceful or int(name[1:]) % 2):
            problems.append(f"{place} was left in peace and fails: {row['error']}")
        elif row["exit_code"] != 0 and (row["exit_code"] not in REFUSALS or f"cases/{name}." not in row["error"]):
            problems.append(f"{place} ends with {row['exit_code']}: {row['error']}")
        elif row["exit_code"] == 0 and _mesh(row) not in known:
            problems.append(f"{place} has a mesh of none of its files")
        elif row["exit_code"] == 0 and known[_mesh(row)] and (peaceful or int(name[1:]) % 2):
            problems.append(f"{place} was left in peace and has another mesh")
    return problems


def _rows(folder: Path) -> list[dict[str, str]]:
    return [json.loads(line) for line in (folder / "summary.jsonl").read_text().splitlines()]


def _mesh(row: dict[str, dict[str, str]]) -> str:
    return next(iter(row["files"].values()))


def trials(mode: str, times: int) -> Iterator[tuple[str, list[str]]]:
    """Each kind of change, so many times, and what is wrong then."""
    for change in CHANGES:
        for seed in range(times):
            yield f"{change} ({seed})", trial(change, MODES[mode], seed)


def main(arguments: list[str]) -> None:
    """Change files in all ways, and tell what is wrong afterwards."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robustness changes", description=__doc__)
    parser.add_argument("--modes", default=",".join(MODES))
    parser.add_argument("--times", type=int, default=1, help="how often each kind of change is tried")
    options = parser.parse_args(arguments)
    tell((f"changes, {mode}", trials(mode, options.times)) for mode in options.modes.split(","))
