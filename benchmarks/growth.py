"""What a limit of growth does to the meshes of configs/peers, beside the plain expressions.

``python -m benchmarks.growth`` runs all of it and renews the table in docs/spacing.md.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

from benchmarks.ablation import ROOT
from bubblemesh.case import Case, load_case
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.run.pipeline import mesh_case

PAGE = ROOT / "docs" / "spacing.md"
BEGIN, END = "<!-- growth: begin -->", "<!-- growth: end -->"
CASES = ("example-1", "example-2", "example-3", "dense", "example-4", "example-3-9000")
GROWTHS = (None, 0.15, 0.1)
COLUMNS = ("growth", "nodes", "N / N_id", "mean q", "1 % q", "least q", "l/d spread", "finer on", "at most")


def main() -> None:
    """Run the cases and renew the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.growth", description=__doc__)
    parser.add_argument("--repeats", type=int, default=5, help="seeds of each run [%(default)s]")
    content = table(parser.parse_args().repeats)
    before, _, rest = PAGE.read_text().partition(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}\n\n{content}\n{END}{rest.partition(END)[2]}")


def limited(name: str, growth: float | None, seed: int = 0) -> Case:
    """A case whose spacing grows by at most so much per length, if that is given."""
    case = load_case(ROOT / "configs" / "peers" / f"{name}.yaml", seed=seed)
    assert not isinstance(case.spacing, SpacingTerms)
    if growth is None:
        return case
    return case.model_copy(update={"spacing": SpacingTerms(value=case.spacing, growth=growth)})


def table(repeats: int, cases: Sequence[str] = CASES, growths: Sequence[float | None] = GROWTHS) -> str:
    """Medians over the seeds, and the range of the least q."""
    lines = ["| case | " + " | ".join(COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
    for name in cases:
        for growth in growths:
            print(name, growth, file=sys.stderr)
            reports = [mesh_case(limited(name, growth, seed)).report for seed in range(repeats)]
            lines.append(f"| {name} | " + " | ".join(_cells(growth, reports)) + " |")
    return "\n".join(lines) + "\n"


def _cells(growth: float | None, reports: Sequence[Mapping[str, Any]]) -> list[str]:
    least = [report["quality"]["min"] for report in reports]
    rules = reports[0].get("rules", {"share": 0.0, "ratio": 1.0})
    return [
        "-" if growth is None else f"{growth:g}",
        f"{median(report['nodes'] for report in reports):.0f}",
        f"{median(report['nodes'] / report['ideal_nodes'] for report in reports):.3f}",
        f"{median(report['quality']['mean'] for report in reports):.4f}",
        f"{median(report['quality']['p01'] for report in reports):.3f}",
        f"{median(least):.3f} ({min(least):.3f} to {max(least):.3f})",
        f"{median(report['spacing']['std'] for report in reports):.4f}",
        f"{rules['share']:.0%}",
        f"{rules['ratio']:.2f}",
    ]


if __name__ == "__main__":
    main()
