"""The trial of one file: read it, or do the one thing that the message says; then mesh it, and look at the mesh."""

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from time import process_time
from typing import Any

import yaml

from benchmarks.robustness.capped import Call
from benchmarks.robustness.soundness import faults
from benchmarks.robustness.trials import Row

PARTS = 30  # of the size: the spacing
# What messages name: a key with a value that can be taken as it stands. Values in capitals stand for others.
KEYS = "part|repair|join|open|simplify|smallest|layer|feature|regions|units"
VALUE = r"\{[^{}]*\}|\[[^\[\]]*\]|'[^']*'|\"[^\"]*\"|[^\s,;:)]+"
ADVICE = re.compile(rf"\b({KEYS}): ({VALUE})( and (?=({KEYS}): ))?")
AT_ONCE, WITH_KEY, REFUSED = "at once", "with the key", "refused"


def advised(message: str) -> dict[str, Any]:
    """The first key with its value that a message names, with those that it joins to it by "and"; there may be none."""
    found: dict[str, Any] = {}
    for key, text, more, _ in ADVICE.findall(message):
        try:
            value = yaml.safe_load(text)
        except yaml.YAMLError:
            continue
        if not (isinstance(value, str) and key != "layer" and value.isupper()):
            found[key] = value
            if not more:
                break
    return found


def cases(task: Row) -> Iterator[tuple[str, Callable[[str], Row]]]:
    """Names of the two attempts, and the case of each, for what the first one's message was."""
    file, spacing = str(Path(task["folder"], task["name"])), task["size"] / PARTS

    def plain(message: str) -> Row:
        return {"domain": {"file": file}, "spacing": spacing}

    def keyed(message: str) -> Row:
        key = advised(message)
        domain = {"regions": key["regions"] | {"file": file}} if "regions" in key else {"file": file} | key
        return {"domain": domain, "spacing": spacing} if key else {}

    yield AT_ONCE, plain
    yield WITH_KEY, keyed


def mesh_one(task: Row) -> Row:
    """Row of a file: how it got in and what its mesh is like, or why it did not."""
    from bubblemesh.case import load_case
    from bubblemesh.errors import BubblemeshError
    from bubblemesh.problem.prepare import prepare
    from bubblemesh.run.pipeline import mesh_case

    begun, row, message = process_time(), {"outcome": REFUSED}, ""
    for attempt, made in cases(task):
        keys = made(message)
        if not keys:
            break
        row |= {"attempt": attempt, "keys": {key: keys["domain"][key] for key in keys["domain"] if key != "file"}}
        try:
            case = load_case("intake.yaml", text=json.dumps(keys))
            if task.get("read"):
                found = {"area": prepare(case).domain.polygon.area}
            else:
                found = _looked_at(mesh_case(case), task)
        except BubblemeshError as error:
            message = str(error)
            row |= {"why" if attempt == AT_ONCE else "why then": message[:2000], "code": error.exit_code}
        else:
            row |= found | {"outcome": attempt}
            break
    seconds = process_time() - begun
    wrong = _area_wrong(row, task)
    return row | {"cpu": round(seconds, 3), "wrong": [*row.get("wrong", []), *wrong]}


def _looked_at(result: Any, task: Row) -> Row:
    """Figures of a mesh, and what is wrong with it."""
    mesh, quality = result.mesh, result.report["quality"]
    if task.get("meshes"):
        mesh.write(Path(task["meshes"], task["name"] + ".vtu"))
    found = faults(mesh.points, mesh.triangles, mesh.facets[mesh.outer], None)
    return {
        "wrong": found,
        "area": result.report["area"],
        "nodes": len(mesh.points),
        "least": quality["min"],
        "warnings": [str(one) for one in result.report["warnings"]],
    }


def _area_wrong(row: Row, task: Row) -> list[str]:
    """Whether the area is that of the file, where it is known what a mesh should cover."""
    areas, key = task["areas"], row.get("keys") or {}
    if row["outcome"] == REFUSED or areas is None or not key.keys() <= {"part", "regions"}:
        return []
    part = key.get("part", "all")
    expected = {"all": sum(areas), "largest": areas[0]}.get(part) if isinstance(part, str) else areas[part]
    error = row["area"] / expected - 1
    return [f"the area differs from the file's by {error:.1e}"] if abs(error) > task["tolerance"] else []


def row_of(call: Call) -> Row:
    """Row of a call, whatever became of it."""
    row = {key: call.task[key] for key in ("name", "kind", "holds_area")} | {"seconds": round(call.seconds, 3)}
    if call.crash is None:
        return row | call.value
    lines = call.crash.strip().splitlines()
    outcome = "no end" if lines[-1].startswith("no end") else "crash"
    return row | {"outcome": outcome, "why": lines[-1], "traceback": call.crash, "wrong": []}
