"""Whether polygons share their borders exactly: edges say the same as the library does, and in less time."""

import numpy as np
import pytest
import shapely

from bubblemesh.geometry import borders
from bubblemesh.geometry.borders import matched
from bubblemesh.geometry.coverage import is_coverage, surely_coverage


def pixels(size=40, seed=0, corners=True):
    """Polygons of the phases of a noisy image, and their names; with all corners of pixels, or only where they turn."""
    random = np.random.default_rng(seed)
    image = (np.indices((size, size))[0] > size / 2).astype(int)
    noise = random.random((size, size)) < 0.1
    image[noise] = random.integers(0, 3, noise.sum())
    found = []
    for phase in range(3):
        cells = [shapely.box(x, y, x + 1, y + 1) for y, x in np.argwhere(image == phase).tolist()]
        found += [(part, str(phase)) for part in shapely.get_parts(shapely.coverage_union_all(cells)).tolist()]
    shapes = np.array([shape for shape, _ in found], dtype=object)
    if not corners:
        shapes = shapely.simplify(shapes, 0)
    return shapes, [name for _, name in found]


def cells(count=12, seed=1):
    """Voronoi cells of random points, which cover a box."""
    points = np.random.default_rng(seed).random((count**2, 2))
    cells = shapely.voronoi_polygons(shapely.multipoints(points), extend_to=shapely.box(0, 0, 1, 1))
    return np.array(shapely.get_parts(cells), dtype=object)


def moved(shapes):
    """The shapes, of which one is moved by a little."""
    found = shapes.copy()
    found[7] = shapely.transform(found[7], lambda points: points + 1e-3)
    return found


def with_one_more(shapes, one):
    return np.append(shapes, one)


CASES = {
    "pixels": pixels()[0],
    "pixels with few vertices": pixels(corners=False)[0],
    "turned pixels": shapely.transform(pixels()[0], lambda points: points @ [[0.8, 0.6], [-0.6, 0.8]]),
    "cells": cells(),
    "clockwise": np.array([shape.reverse() if k % 3 else shape for k, shape in enumerate(cells())]),
    "moved": moved(cells()),
    "without some": cells()[::2],
    "one twice": with_one_more(cells(), cells()[20]),
    "one within": with_one_more(cells(), cells()[20].buffer(-1e-3)),
    "one that covers others": with_one_more(cells(), shapely.union_all(cells()[20:30])),
    "one around all": with_one_more(cells(), cells()[0].envelope.union(shapely.union_all(cells())).buffer(1)),
    "one across": with_one_more(cells(), shapely.Polygon([(0.1, 0.1), (0.9, 0.11), (0.9, 0.12)])),
    "several parts": np.append(cells()[:-2], shapely.MultiPolygon([cells()[-2], shapely.box(9, 9, 10, 10)])),
    "far apart": np.array([shapely.box(3 * k, 0, 3 * k + 1, 1) for k in range(200)]),
    "a vertex on a side": np.array(
        [*(shapely.box(3 * k, 0, 3 * k + 1, 1) for k in range(200)), shapely.Polygon([(1, 0.5), (2, 0), (2, 1)])]
    ),
}


@pytest.mark.parametrize("gap", [0, 1e-6, 1e-2])
@pytest.mark.parametrize("shapes", CASES.values(), ids=CASES)
def test_edges_say_what_the_library_says(shapes, gap):
    expected = bool(shapely.coverage_is_valid(shapes, gap))
    assert surely_coverage(shapes, gap) in (expected, None)
    assert is_coverage(shapes, gap) == expected


@pytest.mark.parametrize("name", ["pixels", "cells", "clockwise", "turned pixels", "far apart", "several parts"])
def test_coverages_are_known_by_their_edges(name):
    assert surely_coverage(CASES[name]) is True


def test_borders_of_pixels_are_matched_without_what_takes_long(monkeypatch):
    def long(*shapes, **keys):
        raise AssertionError("takes time by the square of the grains in a matrix")

    def none(operation, one, other, rounding):
        assert len(one) == 0, "pairs of shapes that do not overlap"
        return one

    shapes, names = pixels(corners=False)
    assert surely_coverage(shapes) is False
    monkeypatch.setattr(shapely, "coverage_is_valid", long)
    monkeypatch.setattr(borders, "_surely", none)
    found = matched(shapes, names, None).shapes
    assert surely_coverage(found) is True
    assert shapely.area(found).tolist() == shapely.area(shapes).tolist()
