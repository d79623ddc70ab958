"""Run all tools on the cases of configs/peers and write docs/peers.md with its plots.

All cases take about an hour. With --results a part of them may be run at a time: the page is of all that were.
"""

import argparse
import json
import shlex
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path

from pydantic import TypeAdapter

from benchmarks.peers.figures import draw
from benchmarks.peers.page import page
from benchmarks.peers.rows import row
from benchmarks.peers.runs import CASES, SIZES, CaseRuns, problems, ran
from benchmarks.peers.tools import TOOLS

DOCS = Path(__file__).parents[2] / "docs"
RUNS = TypeAdapter(dict[str, CaseRuns])


def main() -> None:
    """Measure, draw, write."""
    options = _options()
    tell = partial(print, file=sys.stderr, flush=True)
    kept = options.results
    results = RUNS.validate_json(kept.read_bytes()) if kept and kept.exists() else {}
    for name, problem in problems(options.case, options.largest).items():
        results[name] = ran(problem, options.tool, options.method, options.repeats, tell)
        if kept:
            kept.write_text(json.dumps({name: asdict(case) for name, case in results.items()}))
    results = {name: results[name] for name in CASES if name in results}
    rows = {name: {tool: row(case, tool) for tool in case.tools} for name, case in results.items()}
    # With kept results the page is of all parts, whichever is run last.
    words = ["--largest", f"{options.largest:g}", "--repeats", f"{options.repeats}"] if kept else sys.argv[1:]
    command = shlex.join(["python", "-m", "benchmarks.peers", *words])
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
    parser.add_argument(
        "--results", type=Path, metavar="FILE", help="JSON of all runs: those of other cases stay, and are on the page"
    )
    parser.add_argument("-o", "--output", type=Path, default=DOCS / "peers.md", metavar="PAGE", help="[docs/peers.md]")
    return parser.parse_args()


if __name__ == "__main__":
    main()
