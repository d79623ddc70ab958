"""Boundary layers in figures: ``python -m benchmarks.layers`` makes the page docs/layer-figures.md."""

import argparse
import sys

from benchmarks.layers.gradients import FLOWS, isotropic, needed, with_layers
from benchmarks.layers.page import PAGE, page
from benchmarks.layers.runs import run_all
from benchmarks.layers.section import section
from benchmarks.layers.shapes import shapes
from benchmarks.peers.machine import versions


def main() -> None:
    """Run both tools on all shapes, solve, write, and make the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.layers", description=__doc__)
    parser.add_argument("--repeats", type=int, default=3, help="runs of each tool [%(default)s]")
    repeats = parser.parse_args().repeats
    runs = run_all(shapes(), repeats, tell)
    gradients = {flow.name: (needed(flow, with_layers), needed(flow, isotropic)) for flow in FLOWS}
    sections = {cells: section(cells) for cells in ("triangles", "quads")}
    PAGE.write_text(page(runs, gradients, sections, versions(), repeats))


def tell(line: str) -> None:
    """Print a line of progress."""
    print(line, file=sys.stderr)


if __name__ == "__main__":
    main()
