"""Run all cases of configs/paper and write docs/reproduction.md with its figures."""

from pathlib import Path

import matplotlib as mpl
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from benchmarks.paper.figures import CAPTIONS, draw
from benchmarks.paper.page import page
from benchmarks.paper.published import CASES
from benchmarks.paper.runs import SEEDS, measured, profiled

DOCS = Path(__file__).parents[2] / "docs"


def main() -> None:
    """Measure, draw, write."""
    mpl.rcParams["svg.hashsalt"] = "bubblemesh"
    columns = (TextColumn("{task.description:32}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns) as progress:
        task = progress.add_task("", total=None)

        def on_run(name: str, seed: int) -> None:
            progress.update(task, description=f"{name}, seed {seed}", advance=1)

        runs = measured(CASES, on_run)
        progress.update(task, description="profile and figures")
        shares = profiled("table-1")
        draw(runs, DOCS / "figures")
    (DOCS / "reproduction.md").write_text(page(runs, shares, CAPTIONS), encoding="utf-8")
    print(f"docs/reproduction.md written, {len(runs)} cases with {len(SEEDS)} starts each")


if __name__ == "__main__":
    main()
