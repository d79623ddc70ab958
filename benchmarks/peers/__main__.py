"""Run all tools on the cases of configs/peers and write docs/peers.md with its plots."""

import argparse
import shlex
import sys
from functools import partial
from pathlib import Path

from benchmarks.peers.figures import draw
from benchmarks.peers.page import page
from benchmarks.peers.rows import row
from benchmarks.peers.runs import CASES, SIZES, problems, ran
from benchmarks.peers.tools import TOOLS

DOCS = Path(__file__).parents[2] / "docs"


def main() -> None:
    """Measure, draw, write."""
    options = _options()
    tell = partial(print, file=sys.stderr, flush=True)
    results = {
        name: ran(problem, options.tool, options.method, options.repeats, tell)
        for name, problem in problems(options.case, options.largest).items()
    }
    rows = {name: {tool: row(case, tool) for tool in case.tools} for name, case in results.items()}
    command = shlex.join(["python", "-m", "benchmarks.peers", *sys.argv[1:]])
    text = page(results, rows, command, options.method, options.repeats)
    draw(rows, [name for name in SIZES if name in rows], options.output.parent / "figures")
    options.output.write_text(text, encoding="utf-8")
    tell(f"{options.output} written")


def _options() -> argparse.Namespace:
    tools = [name for name, tool in TOOLS.items() if tool.installed()]
    parser = argparse.ArgumentParser("python -m benchmarks.peers", description=__doc__)
    parser.add_argument("--case", nargs="+", choices=CASES, default=CASES, metavar="NAME", help=", ".join(CASES))
    parser.add_argument("--tool", nargs="+", choices=TOOLS, default=tools, metavar="NAME", help=", ".join(TOOLS))
    parser.add_argument("--method", default="multilevel", help="bubblemesh's method [%(default)s]")
    parser.add_argument("--repeats", type=int, default=3, metavar="N", help="runs of each tool [%(default)s]")
    parser.add_argument(
        "--largest", type=float, default=1e5, metavar="N", help="leave out cases with more nodes [%(default)g]"
    )
    parser.add_argument("-o", "--output", type=Path, default=DOCS / "peers.md", metavar="PAGE", help="[docs/peers.md]")
    return parser.parse_args()


if __name__ == "__main__":
    main()
