"""Damaged files of every kind that a case can name, and damaged cases: each is read, or refused by an error of ours.

Rows go to a file as they come; a run that is begun again goes on after the last one.
"""

import random
import re
import struct
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.robustness.capped import Call
from benchmarks.robustness.seeds import Seed, seeds
from benchmarks.robustness.trials import Row, completed, counted_outcomes, note, row_options
from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.problem.prepare import prepare

TOKEN = re.compile(rb"[\w.+-]+|\s+|.", re.DOTALL)
NUMBERS = b"nan inf -inf 1e308 -1e308 1e-308 -0 0 -1 1 2147483648 9223372036854775807 1e400 0x1f".split()
WORDS = (
    b"'",
    b'"',
    b"(" * 50,
    b"[" * 50,
    b"{" * 50,
    b"\0",
    b"\xff",
    b"9" * 500,
    b"a" * 5000,
    b"\n" * 50,
    b"-",
    b"<a>",
    b"&a;",
)


# How they are damaged.


def _with_bytes_changed(content: bytes, random_: random.Random) -> bytes:
    at = random_.randrange(len(content) + 1)
    return content[:at] + random_.randbytes(random_.choice([1, 1, 2, 4])) + content[at + random_.randint(0, 4) :]


def _cut(content: bytes, random_: random.Random) -> bytes:
    return content[: random_.randrange(len(content) + 1)]


def _with_part_moved(content: bytes, random_: random.Random) -> bytes:
    begin, end, to = sorted(random_.randrange(len(content) + 1) for _ in range(3))
    part = content[begin:end][:2000]
    kept = content if random_.random() < 0.5 else content[:begin] + content[begin + len(part) :]
    return kept[:to] + part * random_.choice([1, 1, 2, 30]) + kept[to:]


def _with_binary_number(content: bytes, random_: random.Random) -> bytes:
    form = random_.choice(["<i", ">i", "<q", "<d", ">d", "<f"])
    whole = form[1] in "iq"
    value = random_.choice(
        [-1, 0, 2**31 - 1, 1000] if whole else [np.nan, np.inf, 1e300 if form[1] == "d" else 1e38, -0.0]
    )
    number = struct.pack(form, value)
    at = random_.randrange(max(len(content) - len(number), 0) + 1)
    return content[:at] + number + content[at + len(number) :]


def _with_tokens_changed(content: bytes, random_: random.Random) -> bytes:
    tokens = TOKEN.findall(content)
    if not tokens:
        return content
    for _ in range(random_.choice([1, 1, 2, 5])):
        k, other = random_.randrange(len(tokens)), random_.randrange(len(tokens))
        match random_.randrange(6):
            case 0:
                tokens[k] = b""
            case 1:
                tokens[k], tokens[other] = tokens[other], tokens[k]
            case 2:
                tokens[k] = tokens[k] * random_.choice([2, 3, 100])
            case 3:
                tokens[k] = random_.choice(WORDS)
            case _:
                numbers = [j for j, token in enumerate(tokens) if token.strip(b"+-.e0123456789") == b"" and token]
                tokens[random_.choice(numbers or [k])] = random_.choice(NUMBERS)
    return b"".join(tokens)


def _nested(content: bytes, random_: random.Random) -> bytes:
    begin, end = sorted(random_.randrange(len(content) + 1) for _ in range(2))
    left, right = random_.choice([(b"[", b"]"), (b"{", b"}"), (b"(", b")"), (b"<g>", b"</g>")])
    times = random_.choice([1, 20, 2000])
    return content[:begin] + left * times + content[begin:end] + right * times + content[end:]


CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    _with_bytes_changed,
    _cut,
    _with_part_moved,
    _with_binary_number,
    _with_tokens_changed,
    _with_tokens_changed,
    _with_tokens_changed,
    _nested,
)


def damaged(seed: Seed, random_: random.Random) -> Seed:
    """A case of which one file is damaged in one way or several; without files, the case itself."""

    def changed(content: bytes) -> bytes:
        for _ in range(random_.choice([1, 1, 1, 2, 4])):
            content = random_.choice(CHANGES)(content, random_)
        return content

    if not seed.files:
        return seed._replace(case=changed(seed.case))
    name = random_.choice([*[next(iter(seed.files))] * 3, *seed.files])
    return seed._replace(files=seed.files | {name: changed(seed.files[name])})


# The trial.


def tasks(each: int) -> Iterator[Row]:
    """So many tasks for each kind, in an order in which any first part is a fair sample."""
    for number in range(each):
        for kind in seeds():
            yield {"name": f"{kind}-{number}", "kind": kind, "number": number}


def read_one(known: dict[str, Seed], task: Row) -> Row:
    """Row of a task, on one of the known seeds: whether the damaged case is read or refused."""
    seed = damaged(known[task["kind"]], random.Random(task["name"]))
    with TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        write(seed, Path(name))
        try:
            prepare(load_case(Path(name, "case.yaml")))
        except BubblemeshError as error:
            return {"outcome": f"refused ({error.exit_code})", "why": str(error)[:300]}
        except MemoryError:
            return {"outcome": "refused (6)", "why": "out of memory"}
    return {"outcome": "read"}


def write(seed: Seed, folder: Path) -> None:
    """Write a case and its files into a folder, to look at what a finding is about."""
    (folder / "case.yaml").write_bytes(seed.case)
    for name, content in seed.files.items():
        (folder / name).write_bytes(content)


def row_of(call: Call) -> Row:
    """Row of a call; a crash, or no end in time, is a finding."""
    row = {**call.task, "seconds": round(call.seconds, 3)}
    if call.crash is None:
        return row | call.value
    lines = call.crash.strip().splitlines()
    return row | {"outcome": "finding", "why": lines[-1], "traceback": call.crash}


def main(arguments: list[str]) -> None:
    """Read what is not read yet, and tell the outcomes and the findings."""
    parser = row_options("fuzz", 20, 4000, __doc__)
    parser.add_argument("--each", type=int, default=200, help="how many of each kind")
    parser.add_argument("--kind", default="", help="what the kinds begin with")
    options = parser.parse_args(arguments)
    chosen = [task for task in tasks(options.each) if task["kind"].startswith(options.kind)]
    rows = completed(partial(read_one, seeds()), row_of, chosen, options)
    findings = [row for row in rows if row["outcome"] == "finding"]
    print(*counted_outcomes(rows), *(f"{row['name']}: {row['why']}" for row in findings), sep="\n")
    note("fuzz, " + options.kind if options.kind else "fuzz", {"trials": len(rows), "wrong": len(findings)})
