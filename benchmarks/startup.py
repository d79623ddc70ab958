"""Wall time of whole processes: ``python -m benchmarks.startup`` prints the median of several runs of each."""

import argparse
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

CONFIGS = Path(__file__).parent.parent / "configs"
COMMANDS = {
    "bubblemesh --help": ["--help"],
    "bubblemesh check configs/quickstart.yaml": ["check", str(CONFIGS / "quickstart.yaml")],
    **{
        f"bubblemesh run {case.relative_to(CONFIGS.parent)}": ["run", str(case), "--quiet"]
        for case in [
            CONFIGS / "quickstart.yaml",
            *sorted((CONFIGS / "paper").glob("example-*.yaml")),
            CONFIGS / "paper" / "dense.yaml",
        ]
    },
}


def seconds(arguments: list[str]) -> float:
    """Wall time of one process."""
    with tempfile.TemporaryDirectory() as folder:
        begun = perf_counter()
        subprocess.run([sys.executable, "-m", "bubblemesh", *arguments], check=True, capture_output=True, cwd=folder)
        return perf_counter() - begun


def main() -> None:
    """Measure all commands, round by round, so that a busy moment of the machine meets all of them."""
    parser = argparse.ArgumentParser("python -m benchmarks.startup", description=__doc__)
    parser.add_argument("--repeats", type=int, default=5, metavar="N", help="runs of each command [%(default)s]")
    repeats = parser.parse_args().repeats
    times: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for _ in range(repeats):
        for name, arguments in COMMANDS.items():
            times[name].append(seconds(arguments))
    print(f"Python {platform.python_version()} on {platform.system()} {platform.machine()}, median of {repeats} runs")
    for name, values in times.items():
        print(f"{median(values):6.2f} s  {name}")


if __name__ == "__main__":
    main()
