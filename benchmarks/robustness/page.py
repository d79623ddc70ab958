"""The page of what the trial of meshes found: ``python -m benchmarks.robustness page --rows FILE``.

It writes ``docs/robustness.md`` and a picture of the worst meshes.
"""

import argparse
import json
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.robustness.corpus import FAMILIES
from benchmarks.robustness.meshes import tasks
from benchmarks.robustness.trials import Row, read_rows

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
to 1e-12.

Of {all} cases in the order of the trial, in which any first part is a fair sample, {done} have been meshed here.
"""


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
    figure.savefig(path, dpi=60)
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
    ]
    (DOCS / "robustness.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
