import numpy as np
import pytest
import shapely

from bubblemesh.geometry.arrangement.clipping import length_inside
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.rings import ArcTo, LineTo, SplineTo, circle, open_path, rectangle

DOMAIN = Domain.of(rectangle(0, 0, 10, 10), [circle((5, 5), 2)])


def lengths(curves):
    """Length of curves inside the domain as `length_inside` gives it, and of all their chords without a preparation."""
    _, _, _, start, end = curves.chords()
    chords = shapely.linestrings(np.stack([start, end], axis=1))
    polygon = shapely.from_wkb(shapely.to_wkb(DOMAIN.polygon))
    return length_inside(curves, DOMAIN.polygon), shapely.length(shapely.intersection(chords, polygon)).sum()


@pytest.mark.parametrize("seed", range(5))
def test_length_inside_is_that_of_all_chords_cut(seed):
    start, *others = np.random.default_rng(seed).uniform(-3, 13, (9, 2))
    line = open_path(start, [*map(LineTo, others[:5]), SplineTo(others[5:])], "a")
    found, expected = lengths(Boundary.empty().with_inner([line]))
    assert 0 < found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("start", "pieces", "expected"),
    [
        ((-1, 5), [LineTo((11, 5))], 6),  # across the hole
        ((0, 2), [LineTo((0, 12))], 8),  # along a side and beyond
        ((-1, -1), [LineTo((0, 0)), LineTo((-1, 1))], 0),  # to a corner
        ((4, 5), [LineTo((6, 5))], 0),  # in the hole
        ((8, 1), [ArcTo((9, 2), (8, 2), True)], np.pi / 2),
        ((20, 20), [LineTo((30, 20))], 0),
    ],
)
def test_length_inside_counts_what_is_on_the_boundary(start, pieces, expected):
    found, cut = lengths(Boundary.empty().with_inner([open_path(start, pieces, "a")]))
    assert found == pytest.approx(expected, abs=1e-3)
    assert found == pytest.approx(cut, rel=1e-12)


def test_only_chords_that_meet_the_boundary_are_cut(monkeypatch):
    cut, intersection = [], shapely.intersection
    monkeypatch.setattr(shapely, "intersection", lambda some, other: cut.extend(some) or intersection(some, other))
    zigzag = [LineTo((1.05 + k / 10, 1 + k % 2 / 10)) for k in range(1, 101)]
    found = length_inside(Boundary.empty().with_inner([open_path((1.05, 1), zigzag, "a")]), DOMAIN.polygon)
    assert found == pytest.approx(89.5 * np.hypot(0.1, 0.1))
    assert len(cut) == 1
