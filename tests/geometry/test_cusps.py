import numpy as np
import pytest
from partitions import domain_of
from sweeps import sweep

from bubblemesh.errors import GeometryError


def disc(x, y, radius):
    return f"circle: {{center: [{x}, {y}], radius: {radius}}}"


def inscribed(ratio, angle):
    """A circle that touches the one of radius 0.3 about (0.5, 0.5) from inside, at ``angle``."""
    away = 0.3 * (1 - ratio)
    return disc(0.5 + away * np.cos(angle), 0.5 + away * np.sin(angle), 0.3 * ratio)


NESTED = {
    "hole in the outer ring": "domain: {{outer: {{{0}}}, holes: [{{{1}}}]}}",
    "region in the outer ring": "domain: {{outer: {{{0}}}, regions: [{{name: a, ring: {{{1}}}}}]}}",
    "region in a region": "domain: {{outer: {{rectangle: [0, 0, 1, 1]}}, "
    "regions: [{{name: b, ring: {{{0}}}}}, {{name: a, ring: {{{1}}}}}]}}",
    "hole in a region": "domain: {{outer: {{rectangle: [0, 0, 1, 1]}}, holes: [{{{1}}}], "
    "regions: [{{name: b, ring: {{{0}}}}}]}}",
}


@pytest.mark.parametrize(
    ("name", "ratio", "angle"),
    sweep([(name, *touch) for name in NESTED for touch in ((0.97, 0.37), (0.99, 2.1), (0.999, 0.37))], quick=5),
)
def test_circles_that_touch_with_nearly_the_same_radius_are_refused_with_the_place(name, angle, ratio):
    text = NESTED[name]
    with pytest.raises(GeometryError, match=r"two curves (part|pass each other) at") as caught:
        domain_of(text.format(disc(0.5, 0.5, 0.3), inscribed(ratio, angle)))
    x, y = (float(word.strip("(),")) for word in str(caught.value).partition(" at ")[2].split()[:2])
    # Where they are that much alike, the place is one at which they are next to each other.
    assert np.hypot(x - 0.5, y - 0.5) == pytest.approx(0.3, abs=1e-5)
    assert np.hypot(x - 0.5 - 0.3 * np.cos(angle), y - 0.5 - 0.3 * np.sin(angle)) < 0.01


@pytest.mark.parametrize("text", NESTED.values(), ids=NESTED)
@pytest.mark.parametrize("ratio", [0.99999, 0.9999999])
def test_circles_that_are_almost_the_same_are_refused_whatever_it_is_called(text, ratio):
    with pytest.raises(GeometryError, match=r"\(0\.\d+, 0\.\d+\)|lies outside"):
        domain_of(text.format(disc(0.5, 0.5, 0.3), inscribed(ratio, 0.37)))


@pytest.mark.long
@pytest.mark.parametrize("text", NESTED.values(), ids=NESTED)
@pytest.mark.parametrize("ratio", [0.9, 0.5, 0.1])
def test_other_circles_touch_in_a_node(text, ratio):
    domain = domain_of(text.format(disc(0.5, 0.5, 0.3), inscribed(ratio, 0.37)))
    at = 0.5 + 0.3 * np.array([np.cos(0.37), np.sin(0.37)])
    assert np.hypot(*(domain.boundary.corners - at).T).min() < 1e-8


@pytest.mark.parametrize("turn", range(0, 360, 45))
def test_cusps_of_one_ring_are_found_in_any_direction(turn):
    a = np.radians(turn)
    across, along = np.array([-np.sin(a), np.cos(a)]), np.array([np.cos(a), np.sin(a)])

    def crescent(radius):
        """From a half circle of radius 1 back along an arc of another radius with the same tangent at the start."""
        center, angle = radius * across, 2.0
        stop = center + radius * (np.sin(angle) * along - np.cos(angle) * across)
        far, middle = (2 * across).tolist(), across.tolist()
        return (
            f"domain: {{outer: {{path: [[0, 0], {{arc: {{to: {far}, center: {middle}, turn: left}}}}, {stop.tolist()}, "
            f"{{arc: {{to: [0, 0], center: {center.tolist()}, turn: right}}}}]}}}}"
        )

    domain_of(crescent(0.8))
    with pytest.raises(
        GeometryError, match=r"part at \(0, 0\) with a common tangent and with radii of (1 and 0\.97|0\.97 and 1),"
    ):
        domain_of(crescent(0.97))


def test_lines_and_curves_that_go_on_smoothly_are_no_cusps():
    domain = domain_of(
        "domain: {outer: {path: [[0, 0], [1, 0], {arc: {to: [1, 1], center: [1, 0.5], turn: left}}, "
        "{spline: {through: [[0.5, 1.1], [0, 1]]}}]}, "
        "lines: [{path: [[0.2, 0.5], {arc: {to: [0.6, 0.5], center: [0.4, 0.5], turn: right}}, "
        "{arc: {to: [1.0, 0.5], center: [0.8, 0.5], turn: left}}]}]}"
    )
    joints = [[0, 0], [1, 0], [1, 1], [0, 1], [0.2, 0.5], [0.6, 0.5], [1, 0.5]]
    np.testing.assert_allclose(domain.boundary.corners, joints, atol=1e-12)
