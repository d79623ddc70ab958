"""What each part of the multilevel method contributes: the method with one part replaced, side by side.

``python -m benchmarks.ablation`` runs all of it and renews the tables in docs/multilevel.md.
"""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

from bubblemesh.case import load_case
from bubblemesh.run.pipeline import mesh_case

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "multilevel.md"
BEGIN, END = "<!-- ablation: begin -->", "<!-- ablation: end -->"
CASES = {
    "dense": "Dense variant of Example 3",
    "example-4": "Example 4",
    "example-3-9000": "Example 3, 8,700 nodes",
    "even": "Even plate, 24,000 nodes",
}

VARIANTS: Mapping[str, list[str]] = {
    "the method": [],
    "effort: fast": ["packing.effort=fast"],
    "effort: best": ["packing.effort=best"],
    "no annealing": ["packing.shaking=none"],
    "one level only": ["packing.levels=single"],
    "no mending": ["packing.mending=none"],
    "smoothing without weight on spacing": ["packing.spacing_weight=0"],
    "triangles at defects counted once": ["packing.defect_weight=1"],
    "no smoothing, no mending": ["packing.polish=none", "packing.mending=none"],
    "neighbours by distance": ["packing.relaxation=nearby"],
    "initial error diffusion": ["packing.placement=diffusion"],
    "initial subdivision": ["packing.placement=subdivision"],
    "control by thresholds": ["packing.population=thresholds"],
}


def main() -> None:
    """Run the variants and renew the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ablation", description=__doc__)
    parser.add_argument("--repeats", type=int, default=3, help="seeds of each variant")
    repeats = parser.parse_args().repeats
    PAGE.write_text(renewed(PAGE.read_text(), tables(repeats)))


def renewed(page: str, content: str, begin: str = BEGIN, end: str = END) -> str:
    """The page with other content between its marks."""
    before, _, rest = page.partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n\n{content}\n{end}{after}"


def tables(repeats: int) -> str:
    """A table for each case: medians over the seeds, and the range of the least q."""
    found: dict[tuple[str, str], list[tuple[dict[str, Any], float]]] = {}
    for seed in range(repeats):  # the outer loop, so that a busy moment of the machine does not meet one variant alone
        for case in CASES:
            for variant, changes in VARIANTS.items():
                print(f"{case}, {variant}, seed {seed}", file=sys.stderr)
                found.setdefault((case, variant), []).append(_measured(case, seed, changes))
    return "\n".join(_table(case, {variant: found[case, variant] for variant in VARIANTS}) for case in CASES)


def _measured(name: str, seed: int, changes: list[str]) -> tuple[dict[str, Any], float]:
    case = load_case(ROOT / "configs" / "peers" / f"{name}.yaml", method="multilevel", seed=seed, overrides=changes)
    begun = process_time()
    report = mesh_case(case).report
    return report, process_time() - begun


def _table(case: str, rows: Mapping[str, list[tuple[dict[str, Any], float]]]) -> str:
    lines = [
        f"### {CASES[case]}\n",
        "| | N / N_id | mean q | 1 % q | least q | irregular | l/d spread | time |",
        "|---|---|---|---|---|---|---|---|",
    ]
    whole = median(seconds for _, seconds in rows["the method"])
    for variant, runs in rows.items():
        reports = [report for report, _ in runs]
        least = [report["quality"]["min"] for report in reports]
        cells = [
            variant,
            f"{median(report['nodes'] / report['ideal_nodes'] for report in reports):.3f}",
            f"{median(report['quality']['mean'] for report in reports):.4f}",
            f"{median(report['quality']['p01'] for report in reports):.3f}",
            f"{median(least):.3f} ({min(least):.3f} to {max(least):.3f})",
            f"{median(report['quality']['irregular_fraction'] for report in reports):.3f}",
            f"{median(report['spacing']['std'] for report in reports):.3f}",
            f"{median(seconds for _, seconds in runs) / whole:.2f}",
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
