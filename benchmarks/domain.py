"""Seconds for questions about a million points: ``python -m benchmarks.domain`` prints a table."""

import platform
from collections.abc import Callable
from time import perf_counter

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import polygon

VERTICES = 20_000
POINTS = 1_000_000
CLEARANCE = 0.01
TURN = np.linspace(0, 2 * np.pi, VERTICES, endpoint=False)
CHECKED = 300  # points whose distance is compared with that from every chord


def rings() -> dict[str, Floats]:
    """Rings of that many vertices about a unit disc, smooth and rough."""
    walk = np.cumsum(np.random.default_rng(0).normal(size=VERTICES))
    walk -= np.linspace(0, walk[-1], VERTICES)
    circle = np.column_stack([np.cos(TURN), np.sin(TURN)])
    return {
        "circle": circle,
        "gear": (1 + 0.05 * np.clip(5 * np.sin(60 * TURN), -1, 1))[:, None] * circle,
        "coast": (1 + 0.1 * walk / np.abs(walk).max())[:, None] * circle,
    }


def seconds(question: Callable[[], object]) -> float:
    """Shortest time of three."""
    times = []
    for _ in range(3):
        begun = perf_counter()
        question()
        times.append(perf_counter() - begun)
    return min(times)


def main() -> None:
    """Measure all questions, and compare distances with brute force."""
    points = np.random.default_rng(1).uniform(-1.1, 1.1, (POINTS, 2))
    print(f"Python {platform.python_version()} on {platform.system()} {platform.machine()}: {POINTS:,} points, ")
    print(f"rings of {VERTICES:,} vertices, seconds")
    print(f"{'ring':8} {'domain':>8} {'inside':>8} {'inside and clear':>18} {'distances':>10} {'error':>9}")
    for name, vertices in rings().items():
        begun = perf_counter()
        domain = Domain.of(polygon(vertices))
        made = perf_counter() - begun
        times = [
            seconds(lambda: domain.contains(points)),  # noqa: B023 - called at once
            seconds(lambda: domain.clear(points, np.full(POINTS, CLEARANCE))),  # noqa: B023
            seconds(lambda: domain.nearest(points)),  # noqa: B023
        ]
        chords = shapely.linestrings(np.stack([vertices, np.roll(vertices, -1, axis=0)], axis=1))
        true = [shapely.distance(chords, shapely.Point(point)).min() for point in points[:CHECKED]]
        error = np.abs(domain.nearest(points[:CHECKED]).distance - true).max()
        print(f"{name:8} {made:8.2f} {times[0]:8.2f} {times[1]:18.2f} {times[2]:10.2f} {error:9.1e}")


if __name__ == "__main__":
    main()
