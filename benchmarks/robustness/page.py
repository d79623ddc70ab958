"""The page of what the trials found: ``python -m benchmarks.robustness page --rows FILE``.

It writes ``docs/robustness.md``, from the rows of the trial of meshes and what the other trials have noted, and a
picture of the worst meshes.
"""

import argparse
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.robustness.corpus import FAMILIES
from benchmarks.robustness.meshes import tasks
from benchmarks.robustness.trials import Row, noted, read_rows

DOCS = Path(__file__).parent.parent.parent / "docs"
PICTURE = Path("figures", "worst-meshes.png")
WORST = 6
OUTCOMES = ("sound", "refused, and invalid", "refused", "unsound", "crash", "no end")

HEAD = """# Robustness: meshes of what breaks meshers

Made by `python -m benchmarks.robustness meshes` and `python -m benchmarks.robustness page`: glyphs of the fonts that
come with Matplotlib, and random domains of eleven families, each with three spacings (a fifth of the size, a
fourteenth, and graded to a sixtieth at a corner) and two methods. Every case is meshed in a process with a cap on
memory (3 GB) and time, and the mesh is checked by code of its own: all triangles counter-clockwise, no node unused or
double, the free edges of the triangles are the boundary edges, none of which cross, and the area is that of the domain
to 1e-12. Nine of ten packings are short ones (`effort: fast`, or 2 rounds of 30 steps), whose triangles are poorer than
the methods' own.

Of {all} cases, {done} have been meshed here. The trial went on while the program grew: its rows are of several states
of it. Where a case showed a fault, that was mended, and the case and those like it were meshed anew. Most of it ran
beside other work, and pauses count: a time tells what was enough, not what is needed.
"""

OTHERS = {  # what each of the other trials does and demands, and what it has found so far
    "fuzz": (
        "Files of every kind that a case can name, and cases, with bytes, numbers and parts changed: each is read or "
        "refused with a documented error, within 20 s and 4 GB.",
        "Readers of meshes that waited for a line beyond the end, numbers too large for the geometry, points that are "
        "none, and errors of GDAL of an unknown class; all mended.",
    ),
    "kills": (
        "SIGKILL, SIGTERM and SIGINT at random moments of a run, a batch, a shard and a batch on a cluster: no half "
        "file, no process left, every row true, and the same command finishes what is left.",
        "Nothing so far.",
    ),
    "disk": (
        "A disk that is full from the n-th write on, for every n: exit code 5, files as before, rows whole and true, "
        "and the command succeeds when there is room.",
        "Nothing so far.",
    ),
    "clock": (
        "The wall clock jumps by 2 hours or 10 years, on or back, while a run has a time limit and while a batch has "
        "workers here or on a cluster: limits and times are as without it, and `--resume` meshes nothing anew.",
        "Nothing: durations are those of a clock that never jumps, and nothing is decided by the age of a file.",
    ),
    "changes": (
        "Case files, bases and geometry are replaced, edited, deleted, or become links, pipes and folders over and "
        "over while a batch reads them: each case has an error or the mesh of whole files, the others are unharmed, "
        "and `--resume` finishes when all is as before.",
        "Nothing so far.",
    ),
    "batches": (
        "10,000 cases end to end: their rate, the memory, and the time of `--resume` when all is done, at most 10 s on "
        "cores without other work.",
        "Its figures are those of the last run.",
    ),
    "limits": (
        "Circles of 300,000 points, zigzags of 100,000, a star of 4,000, 20,000 circles as holes, 100,000 points, "
        "200,000 parameters, checked and run with a time limit: each names the stage that was too slow, and ends at "
        "most 1 s after the limit on cores without other work.",
        "Lists of points that were read one by one, now at once. The spacing of a star still takes more than its share "
        "with more points.",
    ),
}


def family_of(row: Row) -> str:
    """Family of a case; glyphs of all fonts are one."""
    stem = str(row["name"]).partition(".")[0].rpartition("-")[0]
    return stem if stem in FAMILIES else "glyphs"


def table(rows: Iterable[Row]) -> Iterator[str]:
    """Lines of a table of outcomes, with a line for each family and method."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((family_of(row), str(row["name"]).rpartition(".")[2]), []).append(row)
    yield (
        "| domains | method | cases | "
        + " | ".join(OUTCOMES)
        + " | nodes, median | least q: median, lowest | s, longest |"
    )
    yield "|---" * (len(OUTCOMES) + 6) + "|"
    for (family, method), found in sorted(groups.items()):
        counts = Counter(row["outcome"] for row in found)
        meshed = [row for row in found if "least" in row]
        least = np.array([row["least"] for row in meshed] or [np.nan])
        nodes = np.median([row["nodes"] for row in meshed]) if meshed else np.nan
        figures = (
            f"{nodes:.0f} | {np.median(least):.2f}, {least.min():.1e} | {max(row['seconds'] for row in found):.0f}"
        )
        yield f"| {family} | {method} | {len(found)} | {' | '.join(str(counts[o]) for o in OUTCOMES)} | {figures} |"


def faulty(rows: Iterable[Row]) -> Iterator[str]:
    """Lines that name every case that is neither sound nor rightly refused."""
    for row in rows:
        if row["outcome"] not in OUTCOMES[:2]:
            yield f"- `{row['name']}`: {row['outcome']}: {row['why']}"


def others(outcomes: Mapping[str, Row]) -> Iterator[str]:
    """Lines of a table of the other trials, with the figures of their last runs by group."""
    yield "| trial | what it does and demands | found | last run |"
    yield "|---|---|---|---|"
    for name, (demand, found) in OTHERS.items():
        runs = [_figures(group, outcomes[group]) for group in sorted(outcomes) if group.partition(",")[0] == name]
        yield f"| `python -m benchmarks.robustness {name}` | {demand} | {found} | {'; '.join(runs) or 'none noted'} |"


def _figures(group: str, figures: Row) -> str:
    kind = group.partition(", ")[2]
    return f"{kind}: " * bool(kind) + ", ".join(f"{value} {key}" for key, value in figures.items())


def draw_worst(rows: list[Row], path: Path) -> list[Row]:
    """Draw the meshes with the least quality, of each family at most one, and give their rows."""
    from matplotlib import pyplot as plt

    worst: dict[str, Row] = {}
    for row in sorted((row for row in rows if "least" in row), key=lambda row: float(row["least"])):
        worst.setdefault(family_of(row), row)
    chosen = list(worst.values())[:WORST]
    cases = {case["name"]: case for case in tasks(3000, 2000)}
    figure, axes = plt.subplots(2, WORST // 2, figsize=(9, 5))
    for row, axis in zip(chosen, axes.flat, strict=False):
        mesh = _mesh(cases[row["name"]])
        axis.triplot(*mesh.points.T, mesh.triangles, lw=0.4)
        axis.set(aspect="equal", xticks=[], yticks=[])
        axis.set_title(row["name"], fontsize=6)
    figure.tight_layout()
    figure.savefig(path, dpi=44)
    return chosen


def _mesh(case: Any) -> Any:
    from bubblemesh.case import load_case
    from bubblemesh.run.pipeline import mesh_case

    return mesh_case(load_case("case.yaml", text=json.dumps(case))).mesh


def main(arguments: list[str]) -> None:
    """Write the page and its picture."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.robustness page", description=__doc__)
    parser.add_argument("--rows", type=Path, default=Path("robustness-meshes.jsonl"))
    options = parser.parse_args(arguments)
    rows = read_rows(options.rows)
    chosen = draw_worst(rows, DOCS / PICTURE)
    faults = list(faulty(rows)) or ["None."]
    lines = [
        HEAD.format(all=len(list(tasks(3000, 2000))), done=len(rows)),
        *table(rows),
        "\n## Cases that are neither sound nor rightly refused\n",
        *faults,
        "\n## The worst triangles\n",
        "Least quality of each family's worst mesh, all of them sound. Slits, slivers and walls at a thousandth of the",
        "spacing have no better triangles: the domain's own angles and widths force them.\n",
        *(f"- `{row['name']}`: {row['least']:.1e}, {row['nodes']} nodes" for row in chosen),
        f"\n![The worst meshes]({PICTURE.as_posix()})",
        "\n## Other trials\n",
        "A sample of each is among the tests. The figures are those of the last run that was noted.\n",
        *others(noted()),
    ]
    (DOCS / "robustness.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
