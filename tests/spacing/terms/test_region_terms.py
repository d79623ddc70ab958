import numpy as np
import pytest
import shapely

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import Region
from bubblemesh.geometry.paths import Area
from bubblemesh.problem.prepare import prepare
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.terms.regions import RegionSpacing, by_region


def spacing(text):
    return Spacing(Expression.parse(text, {}))


def region(ring, name="r"):
    return Region(Area(ring), name, label="rim")


COARSE, FINE, FINER = spacing("1"), spacing("0.5"), spacing("0.25 + 0*x")
SHAPES = [
    (rings.rectangle(0, 0, 4, 4), FINE),
    (rings.rectangle(4, 0, 8, 4), FINER),
    (rings.rectangle(1, 1, 3, 3), spacing("2")),
    (rings.circle((2, 2), 0.5), FINER),
    (rings.circle((6, 2), 1.5), FINE),
    (rings.polygon([(8, 0), (9, 0), (8, 3)]), spacing("0.1*x")),
]


def one_after_the_other(points):
    """The same by a loop over the regions, the largest first."""
    d = COARSE(points)
    for ring, own in sorted(SHAPES, key=lambda one: -region(one[0]).polygon.area):
        shape = region(ring)
        for k, (x, y) in enumerate(points.tolist()):
            if shapely.contains_xy(shape.core, x, y):
                d[k] = own(points[[k]])[0]
            elif shapely.contains_xy(shape.reach, x, y):
                d[k] = min(d[k], own(points[[k]])[0])
    return d


def test_each_region_has_its_own_spacing_and_a_rim_the_finest():
    rng = np.random.default_rng(0)
    inside = rng.random((500, 2)) * [12, 6] - 1
    on_sides = np.array([(4, 1), (4, 0), (0, 2), (8, 1), (3, 2), (2.5, 2), (7.5, 2), (8, 2.5)])
    points = np.vstack([inside, on_sides])
    own = [RegionSpacing(region(ring), one, "key") for ring, one in SHAPES]
    found = by_region(COARSE, own)(points)
    np.testing.assert_array_equal(found, one_after_the_other(points))
    np.testing.assert_array_equal(found, by_region(COARSE, own[::-1])(points))
    assert found[-8:].tolist() == [0.25, 0.25, 0.5, 0.25, 0.5, 0.25, 0.25, 0.25]


def test_without_regions_the_spacing_stays_as_it_is():
    assert by_region(COARSE, []) is COARSE


CASE = """\
domain:
  outer: {rectangle: [0, 0, 4, 4]}
  regions:
    - {name: a, ring: {rectangle: [0, 0, 1, 4]}, spacing: 0.2}
    - {name: b, ring: {rectangle: [2, 2, 4, 4]}, spacing: "0.2*(3 - x)"}
    - {name: c, ring: {circle: {center: [3, 3], radius: 0.1}}, spacing: 0.1}
"""


@pytest.mark.parametrize(
    ("own", "spacing", "message"),
    [
        ("0.2*(3 - x)", "0.5", r"^domain\.regions\.1\.spacing: is -\S+ at \([34]\S*, \S+\): it has to be positive"),
        ("0.3", "x - 2", r"^spacing: is -\S+ at \([01]\S*, \S+\): it has to be positive"),
    ],
)
def test_an_unusable_value_names_the_spacing_that_has_it(own, spacing, message):
    with pytest.raises(CaseError, match=message):
        prepare(load_case("a.yaml", text=CASE.replace("0.2*(3 - x)", own) + f"spacing: {spacing}\n"))


@pytest.mark.parametrize("own", ["x +", "q", "1j"])
def test_an_expression_of_a_region_is_checked_with_the_case(own):
    with pytest.raises(CaseError, match=r"^a\.yaml:5: domain\.regions\.1\.spacing: column \d: "):
        load_case("a.yaml", text=CASE.replace("0.2*(3 - x)", own) + "spacing: 1\n")
