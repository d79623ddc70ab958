"""CPU seconds for questions about a million points: ``python -m benchmarks.domain`` prints tables."""

import argparse
import platform
from collections.abc import Callable
from time import process_time

import numpy as np
import shapely

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import circle, polygon, rectangle
from bubblemesh.packing.boundary_edges import drop_strays
from bubblemesh.packing.placement.subdivision import HierarchicalSubdivision
from bubblemesh.spacing.spacing import Spacing

VERTICES = 20_000
POINTS = 1_000_000
CLEARANCE = 0.01
SPACING = 0.0028  # of what is placed
TURN = np.linspace(0, 2 * np.pi, VERTICES, endpoint=False)
CHECKED = 300  # points whose distance is compared with that from every chord


def domains() -> dict[str, Domain]:
    """Domains of the size of a unit disc whose boundaries have about that many chords, all called rim."""
    walk = np.cumsum(np.random.default_rng(0).normal(size=VERTICES))
    walk -= np.linspace(0, walk[-1], VERTICES)
    around = np.column_stack([np.cos(TURN), np.sin(TURN)])
    rings = {
        "circle": around,
        "gear": (1 + 0.05 * np.clip(5 * np.sin(60 * TURN), -1, 1))[:, None] * around,
        "coast": (1 + 0.1 * walk / np.abs(walk).max())[:, None] * around,
    }
    bores = [circle((0.2 * i - 0.8, 0.2 * j - 0.8), 0.05, label="rim") for i, j in np.ndindex(9, 9)]
    plate = Domain.of(rectangle(-1, -1, 1, 1, label="rim"), bores)
    return {**{name: Domain.of(polygon(ring, label="rim")) for name, ring in rings.items()}, "bores": plate}


def clouds(domain: Domain) -> dict[str, Floats]:
    """Points all over the domain, next to its boundary, and in its middle, where much may be equally near."""
    rng = np.random.default_rng(1)
    on = domain.polygonal_copy.points[rng.integers(0, len(domain.polygonal_copy.points), POINTS)]
    return {
        "all over": rng.uniform(-1.1, 1.1, (POINTS, 2)),
        "next to it": on + 10.0 ** rng.uniform(-6, -2, (POINTS, 1)) * rng.normal(size=(POINTS, 2)),
        "middle": 0.05 * rng.normal(size=(POINTS, 2)),
    }


def seconds(question: Callable[[], object]) -> float:
    """Shortest time of three."""
    times = []
    for _ in range(3):
        begun = process_time()
        question()
        times.append(process_time() - begun)
    return min(times)


def error(domain: Domain, points: Floats) -> float:
    """Largest difference of distances from those by brute force, to the chords."""
    chords = shapely.linestrings(np.stack(domain.polygonal_copy.chords[3:], axis=1))
    true = [shapely.distance(chords, point).min() for point in shapely.points(points[:CHECKED])]
    return float(np.abs(domain.nearest(points[:CHECKED]).distance - true).max())


def asked(name: str, domain: Domain) -> None:
    """Print how long questions about the points take."""
    for where, points in clouds(domain).items():
        times = [
            seconds(lambda: domain.contains(points)),  # noqa: B023 - called at once
            seconds(lambda: domain.surely_inside(points, np.full(POINTS, CLEARANCE))),  # noqa: B023
            seconds(lambda: domain.signed_distance(points)),  # noqa: B023
            seconds(lambda: domain.distance_to(points, "rim")),  # noqa: B023
        ]
        row = f"{times[0]:8.2f} {times[1]:18.2f} {times[2]:18.2f} {times[3]:18.2f}"
        print(f"{name:8} {where:12} {row} {error(domain, points):9.1e}")


def placed(name: str, domain: Domain) -> None:
    """Print how long it takes to place bubbles, and to check that they are inside the boundary's edges."""
    placement, spacing = HierarchicalSubdivision(), Spacing(lambda x, _: np.full(len(x), SPACING))
    bubbles = placement(domain, spacing, POINTS)
    times = seconds(lambda: placement(domain, spacing, POINTS)), seconds(lambda: drop_strays(bubbles, domain))
    print(f"{name:8} {len(bubbles):10,} {times[0]:8.2f} {times[1]:8.2f}")


def main() -> None:
    """Measure all questions, and compare distances with brute force."""
    argparse.ArgumentParser("python -m benchmarks.domain", description=__doc__).parse_args()
    print(f"Python {platform.python_version()} on {platform.system()} {platform.machine()}: {POINTS:,} points, ")
    print(f"boundaries of about {VERTICES:,} chords, CPU seconds")
    print(
        f"{'':8} {'points':12} {'inside':>8} {'inside and clear':>18} {'signed distance':>18} {'of a label':>18} error"
    )
    cases = domains()
    for name, domain in cases.items():
        asked(name, domain)
    print(f"\n{'':8} {'bubbles':>10} {'placed':>8} {'checked':>8}")
    for name, domain in cases.items():
        placed(name, domain)


if __name__ == "__main__":
    main()
