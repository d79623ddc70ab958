"""Run the cases of configs/paper and write docs/reproduction.md with its figures, or one table or figure alone."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.paper.figures import DRAWINGS, save_drawing
from benchmarks.paper.page import SECTIONS, STAGES_CASE, STAGES_NAME, page, stages
from benchmarks.paper.published import CASES
from benchmarks.paper.runs import CONFIGS, measured, profiled
from bubblemesh.case import load_case

DOCS = Path(__file__).parents[2] / "docs"
TABLES = sorted({STAGES_NAME, *(section.name for section in SECTIONS)})


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, draw, write what the arguments ask for."""
    options = parsed(arguments)
    if options.table:
        text = one_table(options.table)
        if options.output is None:
            print(text, end="")
        else:
            written(options.output, text)
    elif options.figure:
        drawing = DRAWINGS[options.figure]
        path = options.output or DOCS / "figures" / drawing.file
        save_drawing(drawing, measured(drawing.cases, tell), path)
        tell(f"{path} written")
    else:
        whole_page(options.output or DOCS / "reproduction.md")


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """What the command's arguments ask for."""
    parser = argparse.ArgumentParser("python -m benchmarks.paper", description=__doc__)
    alone = parser.add_mutually_exclusive_group()
    alone.add_argument("--table", choices=TABLES, metavar="NAME", help=f"this table alone: {', '.join(TABLES)}")
    numbers = ", ".join(map(str, DRAWINGS))
    alone.add_argument("--figure", type=int, choices=DRAWINGS, metavar="N", help=f"this figure alone: {numbers}")
    parser.add_argument(
        *("-o", "--output"),
        type=Path,
        metavar="FILE",
        help="file of the page [docs/reproduction.md, figures beside it], of the table [standard output], or of "
        "the figure, .svg or .png [docs/figures/fig-N]",
    )
    return parser.parse_args(arguments)


def one_table(name: str) -> str:
    """The sections of the page that make up a table, from runs of the cases that they need."""
    if name == STAGES_NAME:
        return stages(shares())
    sections = [section for section in SECTIONS if section.name == name]
    runs = measured([case for section in sections for case in section.cases], tell)
    return "\n".join(section.text(runs) for section in sections)


def shares() -> dict[str, float]:
    """Shares of the stages of Table 1, in per cent."""
    tell(f"profile of {STAGES_CASE}")
    return profiled(load_case(CONFIGS / f"{STAGES_CASE}.yaml"))


def whole_page(path: Path) -> None:
    """Write the page, and all figures into the folder ``figures`` beside it."""
    runs = measured(CASES, tell)
    for drawing in DRAWINGS.values():
        save_drawing(drawing, runs, path.parent / "figures" / drawing.file)
    written(path, page(runs, shares(), DRAWINGS.values()))


def written(path: Path, text: str) -> None:
    """Write a text, and say so."""
    path.write_text(text, encoding="utf-8")
    tell(f"{path} written")


def tell(message: str) -> None:
    """Tell how far the work is, on the error stream."""
    print(message, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
