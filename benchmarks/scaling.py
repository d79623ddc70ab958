"""CPU seconds to read and check cases of n, 2 n and 4 n parts: ``python -m benchmarks.scaling`` prints a table.

The last column is the power of n by which the time grows, from the last doubling; 1 is linear.
"""

import argparse
import sys
from collections.abc import Callable, Iterable
from math import log2
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from bubblemesh.batch.plan import BatchOptions, plan_cases
from bubblemesh.case import load_case
from bubblemesh.problem.prepare import prepare

SQUARE = "domain: {outer: {rectangle: [0, 0, 1, 1]}"
SPACING = 0.05


def polygon(points: np.ndarray) -> str:
    """A case with the polygon through ``points`` (n, 2)."""
    return f"domain: {{outer: {{polygon: {points.tolist()}}}}}\nspacing: {SPACING}\n"


def star(n: int) -> str:
    """A star of n points, every other one half-way in."""
    turn, radius = 2 * np.pi * np.arange(n) / n, np.where(np.arange(n) % 2, 1.0, 0.5)
    return polygon(np.column_stack([radius * np.cos(turn), radius * np.sin(turn)]))


def circle(n: int) -> str:
    """A polygon with n points on a circle."""
    return polygon(_circle(n))


def zigzag(n: int) -> str:
    """A strip whose long sides are zigzags of n points together."""
    k = np.arange(n // 2)
    lower = np.column_stack([2 * k / n, 10 * (k % 2) / n])
    return polygon(np.vstack([lower, lower[::-1] + np.array([0, 1])]))


def parameters(n: int) -> str:
    """A square with n parameters, one of which the spacing names."""
    return "parameters:\n" + "".join(f"  p{k}: {k}.5\n" for k in range(n)) + f"{SQUARE}}}\nspacing: {SPACING} + 0*p3\n"


def holes(n: int) -> str:
    """A square with n holes in rows, squares themselves."""
    return f"{SQUARE}, holes: [{', '.join(_squares(n))}]}}\nspacing: {SPACING}\n"


def circular_holes(n: int) -> str:
    """A square with n circles as holes in rows."""
    circles = (f"{{circle: {{center: {center}, radius: {0.2 / np.sqrt(n)}}}}}" for center in _rows(n, 0.5).tolist())
    return f"{SQUARE}, holes: [{', '.join(circles)}]}}\nspacing: {SPACING}\n"


def points(n: int) -> str:
    """A square with n points that the mesh has to have."""
    places = np.random.default_rng(0).random((n, 2)).tolist()
    return f"{SQUARE}, points: [{', '.join(f'{{at: {place}}}' for place in places)}]}}\nspacing: {SPACING}\n"


def lines(n: int) -> str:
    """A polygon with n points on a circle, each on a line of its own."""
    return _outer(f"      - [{x}, {y}]\n" for x, y in _circle(n).tolist())


def dashes(n: int) -> str:
    """A polygon with n points on a circle, each number on a line of its own."""
    return _outer(f"      - - {x}\n        - {y}\n" for x, y in _circle(n).tolist())


def regions(n: int) -> str:
    """A square with n regions in rows, squares themselves."""
    named = (f"{{name: r{k}, ring: {ring}}}" for k, ring in enumerate(_squares(n)))
    return f"{SQUARE}, regions: [{', '.join(named)}]}}\nspacing: {SPACING}\n"


def near(n: int) -> str:
    """A square whose spacing is fine near n points."""
    places = np.random.default_rng(0).random((n, 2)).tolist()
    terms = (f"{{point: {place}, size: {SPACING / 2}, growth: 0.3}}" for place in places)
    return f"{SQUARE}}}\nspacing: {{value: {SPACING}, near: [{', '.join(terms)}]}}\n"


def sweep(n: int) -> str:
    """A case that is swept over n seeds."""
    return f"{SQUARE}}}\nspacing: 0.3\nsweep: {{packing.seed: {[*range(n)]}}}\n"


def _squares(n: int) -> list[str]:
    side = 0.2 / np.ceil(np.sqrt(n))
    return [f"{{rectangle: [{x}, {y}, {x + side}, {y + side}]}}" for x, y in _rows(n, 0.4).tolist()]


def _rows(n: int, share: float) -> np.ndarray:
    """Places (n, 2) in rows that fill a square, a share of the width of a column from the column's left and low end."""
    across = int(np.ceil(np.sqrt(n)))
    return (np.column_stack([np.arange(n) % across, np.arange(n) // across]) + share) / across


def _circle(n: int) -> np.ndarray:
    turn = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(turn), np.sin(turn)])


def _outer(rows: Iterable[str]) -> str:
    return f"domain:\n  outer:\n    polygon:\n{''.join(rows)}spacing: {SPACING}\n"


CASES: dict[str, tuple[Callable[[int], str], int]] = {  # with the least number of parts
    "star": (star, 1000),
    "circle": (circle, 5000),
    "zigzag": (zigzag, 10_000),
    "parameters": (parameters, 50_000),
    "holes": (holes, 1250),
    "circular holes": (circular_holes, 1250),
    "points": (points, 1250),
    "lines": (lines, 5000),
    "dashes": (dashes, 5000),
    "regions": (regions, 1250),
    "near": (near, 1250),
    "sweep": (sweep, 1000),
}


def seconds(text: str, swept: bool) -> float:
    """CPU seconds to read and check a case, or to plan a batch of one that is swept."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "case.yaml")
        path.write_text(text)
        begun = process_time()
        if swept:
            plan_cases([str(path)], BatchOptions(folder=folder))
        else:
            prepare(load_case(path))
        return process_time() - begun


def main() -> None:
    """Measure the cases that are named, or all of them."""
    parser = argparse.ArgumentParser("python -m benchmarks.scaling", description=__doc__)
    parser.add_argument("cases", nargs="*", choices=[[], *CASES], help="all if none is named")
    seconds(star(10), swept=False)  # whatever is to be loaded is
    print(f"{'':14} {'n':>8} {'n':>8} {'2 n':>8} {'4 n':>8} {'power':>6}")
    for name in parser.parse_args().cases or CASES:
        make, n = CASES[name]
        times = [seconds(make(factor * n), make is sweep) for factor in (1, 2, 4)]
        print(f"{name:14} {n:8,} {' '.join(f'{time:8.2f}' for time in times)} {log2(times[2] / times[1]):6.2f}")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
