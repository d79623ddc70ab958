"""The spacing of a case, bound to its domain: exact values of every kind of term, and errors with their keys."""

import numpy as np
import pytest
import shapely
from partitions import domain_of
from sweeps import sweep

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError
from bubblemesh.geometry.domain import Domain
from bubblemesh.problem.domain import case_domain
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.python.spacing import spacing_of
from bubblemesh.problem.spacing import case_spacing, held_request
from bubblemesh.run.estimate import estimate
from bubblemesh.spacing.spacing import Spacing

DOMAIN = """
parameters: {h: 0.1}
domain:
  outer: {rectangle: [0, 0, 4, 2], labels: [bottom, right, top, left]}
  region: matrix
  regions:
    - {name: core, ring: {rectangle: [2, 0.5, 3, 1.5]}}
    - {name: seed, ring: {rectangle: [2.2, 0.7, 2.6, 1.1]}OWN}
  holes:
    - {circle: {center: [1, 1], radius: 0.3}, label: bore}
  lines:
    - {path: [[0.2, 1.7], [0.8, 1.7]], label: crack}
  points:
    - {at: [3.5, 1.5], label: well}
"""
BOUND = domain_of(DOMAIN.replace("OWN", ""))
X, Y = np.random.default_rng(1).uniform([0, 0], [4, 2], (600, 2)).T
OUTSIDE_BORE = np.hypot(X - 1, Y - 1) > 0.3
X, Y = X[OUTSIDE_BORE], Y[OUTSIDE_BORE]
POINTS = np.column_stack([X, Y])

BORE = np.hypot(X - 1, Y - 1) - 0.3
WELL = np.hypot(X - 3.5, Y - 1.5)
CRACK = np.hypot(X - np.clip(X, 0.2, 0.8), Y - 1.7)
CORE = (X > 2) & (X < 3) & (Y > 0.5) & (Y < 1.5)
SEED = (X > 2.2) & (X < 2.6) & (Y > 0.7) & (Y < 1.1)
CORE_RIM = np.abs(shapely.distance(shapely.points(POINTS), shapely.box(2, 0.5, 3, 1.5).exterior))
WALL = np.min([X, 4 - X, Y, 2 - Y, BORE], axis=0)


def requested(spacing, own=""):
    case = load_case("plate.yaml", text=f"{DOMAIN.replace('OWN', own)}spacing: {spacing}\n")
    return case_spacing(case, BOUND).at(None)


def values(spacing, own=""):
    return requested(spacing, own)(POINTS)


TERMS = [
    ("{near: [{label: bore, size: 0.05, growth: 0.15}]}", 0.05 + 0.15 * BORE),
    ("{near: [{label: bore, size: 0.05}]}", 0.05 + 0.2 * BORE),
    ("{near: [{label: bore, size: 0.05}], growth: 0.3}", 0.05 + 0.3 * BORE),
    ("{near: [{label: bore, size: 0.05, until: 0.4, growth: 0.1}]}", 0.05 + 0.1 * np.maximum(BORE - 0.4, 0)),
    ("{near: [{label: crack, size: 0.05}]}", 0.05 + 0.2 * CRACK),
    ("{near: [{label: [bore, crack], size: 0.05}]}", 0.05 + 0.2 * np.minimum(BORE, CRACK)),
    ("{near: [{label: core-rim, size: 0.05}]}", 0.05 + 0.2 * CORE_RIM),
    ("{near: [{label: well, size: 0.03}]}", 0.03 + 0.2 * WELL),
    (
        "{near: [{label: left, size: 0.03}, {label: right, size: 0.06, growth: 0.1}]}",
        np.minimum(0.03 + 0.2 * X, 0.06 + 0.1 * (4 - X)),
    ),
    ("{near: [{point: [0.5, 0.5], size: 0.03}], value: 0.2}", np.minimum(0.03 + 0.2 * np.hypot(X - 0.5, Y - 0.5), 0.2)),
    ("{near: [{line: [[0, 0.5], [4, 0.5]], size: 0.05}]}", 0.05 + 0.2 * np.abs(Y - 0.5)),
    ("{labels: {bore: 0.05, well: 0.04}}", np.minimum(0.05 + 0.2 * BORE, 0.04 + 0.2 * WELL)),
    (
        "{near: [{label: bore, size: 0.05}, {label: well, size: 0.05}, {label: bore, size: 0.05, growth: 0.1}]}",
        np.min([0.05 + 0.2 * BORE, 0.05 + 0.2 * WELL, 0.05 + 0.1 * BORE], axis=0),
    ),
    ("{labels: {bore: 0.05}, growth: 0.1, maximum: 0.2}", np.minimum(0.05 + 0.1 * BORE, 0.2)),
    ("{labels: {bore: 0.05}, scale: 2}", 2 * (0.05 + 0.2 * BORE)),
    ("{labels: {bore: 0.01}, minimum: 0.05, maximum: 0.3}", np.clip(0.01 + 0.2 * BORE, 0.05, 0.3)),
    ("{value: 0.2, regions: {core: 0.1}}", np.where(CORE & ~SEED, 0.1, 0.2)),
    (
        "{value: 0.2, regions: {core: 0.1, seed: 0.15, matrix: 'h*(1 + x)'}}",
        np.where(SEED, 0.15, np.where(CORE, 0.1, np.minimum(0.1 * (1 + X), 0.2))),
    ),
    ("{value: 0.05, regions: {core: 0.1}}", np.full(len(X), 0.05)),
    (
        "{regions: {core: 0.1, seed: 0.15, matrix: 'h + 0.1*distance(\"bore\")'}}",
        np.where(SEED, 0.15, np.where(CORE, 0.1, 0.1 + 0.1 * BORE)),
    ),
    ("\"h + 0.1*distance('bore', 'well')\"", 0.1 + 0.1 * np.minimum(BORE, WELL)),
    ("{value: \"h + 0.1*distance('crack')**2\"}", 0.1 + 0.1 * CRACK**2),
    ("'h + 0.2*distance()'", 0.1 + 0.2 * WALL),
]


@pytest.mark.parametrize(("spacing", "expected"), TERMS, ids=[spacing for spacing, _ in TERMS])
def test_values_are_exact(spacing, expected):
    np.testing.assert_allclose(values(spacing), expected, rtol=1e-9)


def test_labels_alike_take_one_look_for_the_nearest_of_them(monkeypatch):
    holes = "".join(f"    - {{polygon: {ring(k)}, label: isle-{k}}}\n" for k in range(5))
    islands = domain_of(f"domain:\n  outer: {{rectangle: [0, 0, 6, 2]}}\n  holes:\n{holes}")
    near = ", ".join(f"{{label: isle-{k}, size: 0.05}}" for k in range(4))
    terms = f"{{near: [{near}], labels: {{isle-4: 0.05}}}}"
    case = load_case("sea.yaml", text=f"domain: {{outer: {{rectangle: [0, 0, 6, 2]}}}}\nspacing: {terms}\n")
    spacing, asked = case_spacing(case, islands).at(None), []
    look = Domain.distance_to
    monkeypatch.setattr(Domain, "distance_to", lambda self, *given: asked.append(given) or look(self, *given))
    found = spacing(np.array([[0.0, 0.0], [5.9, 1.0]]))
    assert len(asked) == 1
    corners = [np.array(ring(k)) for k in range(5)]
    nearest = [min(np.hypot(*(points - at).T).min() for points in corners) for at in ([0, 0], [5.9, 1])]
    np.testing.assert_allclose(found, 0.05 + 0.2 * np.array(nearest), rtol=0.02)


def ring(k):
    """An island of many corners, so that no formula gives the distance."""
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    return np.column_stack([k + 1 + 0.3 * np.cos(turn), 1 + 0.3 * np.sin(turn)]).round(6).tolist()


FRACTURES = """
domain:
  outer: {rectangle: [0, 0, 4, 2]}
  holes: [{circle: {center: [3, 1], radius: 0.3}}]
  regions: [{name: core, ring: {rectangle: [0.2, 0.2, 0.6, 0.6]}}]
  lines:
    - {file: a.csv, label: frac}
    - {path: [[1, 0.5], [2, 1.5]], label: other}
"""
ROWS = {  # and which ends are free
    "1,0.5\n1,1.6": [(1, 1.6)],  # at another line
    "1.5,1\n2.4,1\n2.4,1.5": [(2.4, 1.5)],  # on another line
    "3,1\n3,1.7": [(3, 1.7)],  # from a hole
    "3.6,1.8\n3.6,2": [(3.6, 1.8)],  # on the boundary
    "3.8,-1\n3.8,0.5": [(3.8, 0.5)],  # from outside
    "0.6,0.4\n0.9,0.4": [(0.9, 0.4)],  # on the rim of a region
    "0.2,1\n0.4,1\n\n0.4,1\n0.4,1.4": [(0.2, 1), (0.4, 1.4)],  # at each other
    "0.7,1.8\n1.6,1.8\n\n1.2,1.7\n1.2,1.9": [(0.7, 1.8), (1.6, 1.8), (1.2, 1.7), (1.2, 1.9)],  # across each other
}


def test_ends_of_lines_are_those_where_nothing_else_is(tmp_path):
    (tmp_path / "a.csv").write_text("\n\n".join(ROWS))
    terms = "{near: {ends: frac, size: 0.01, growth: 0.1, until: 0.02}, maximum: 0.3}"
    (tmp_path / "a.yaml").write_text(f"{FRACTURES}spacing: {terms}\n")
    case = load_case(tmp_path / "a.yaml")
    tips = np.array([tip for tips in ROWS.values() for tip in tips])
    distance = np.hypot(*(POINTS[:, None] - tips).T).min(axis=0)
    found = case_spacing(case, case_domain(case)).at(None)(POINTS)
    np.testing.assert_allclose(found, np.minimum(0.01 + 0.1 * np.maximum(distance - 0.02, 0), 0.3), rtol=1e-9)
    problem = prepare(case)
    assert problem.survey.extremes.minimum == 0.01


def test_labels_without_free_ends_are_told():
    told = (
        r"spacing.near.ends: no line with the label 'bore', 'left' has a free end, .*: leave it out, or give the place"
    )
    with pytest.raises(CaseError, match=told):
        requested("{value: 1, near: {ends: [bore, left], size: 0.1}}")
    with pytest.raises(CaseError, match=r"spacing.near.1.ends: unknown label 'crak'; did you mean 'crack'"):
        requested("{value: 1, near: [{ends: crack, size: 0.1}, {ends: crak, size: 0.1}]}")


def test_the_finest_counts_on_the_rim_of_a_region():
    rim = np.array([[2.0, 1.0], [3.0, 0.7], [2.5, 0.5], [2.2, 0.9]])
    np.testing.assert_array_equal(requested("{value: 0.2, regions: {core: 0.1, seed: 0.15}}")(rim), 0.1)
    np.testing.assert_array_equal(requested("{value: 0.2, regions: {matrix: 0.1}}")(rim), [0.1, 0.1, 0.1, 0.2])


def test_a_spacing_of_a_region_stands_in_place_of_the_value():
    found = values("{value: 0.2, near: [{label: left, size: 0.05, growth: 0.1}], scale: 0.5}", ", spacing: 0.3")
    np.testing.assert_allclose(found, 0.5 * np.minimum(np.where(SEED, 0.3, 0.2), 0.05 + 0.1 * X), rtol=1e-12)
    found = values("{labels: {left: 0.1}}", ", spacing: \"0.05 + 0.1*distance('left')\"")
    np.testing.assert_allclose(
        found, np.where(SEED, np.minimum(0.05 + 0.1 * X, 0.1 + 0.2 * X), 0.1 + 0.2 * X), rtol=1e-12
    )


UNKNOWN = [
    (
        "{near: [{label: bore, size: 1}, {label: boer, size: 1}]}",
        "spacing.near.1.label: unknown label 'boer'; did you mean 'bore'? known: ",
    ),
    ("{labels: {matrix: 1}}", "spacing.labels.matrix: unknown label 'matrix'; "),
    (
        "{value: 1, regions: {kore: 1}}",
        "spacing.regions.kore: unknown region 'kore'; did you mean 'core'? known: core, seed, matrix",
    ),
    ("{regions: {core: 'distance(\"x\")'}}", "spacing.regions.core: column 1: unknown label 'x'; "),
    ("'0.1 + distance(\"x\")'", "spacing: column 7: unknown label 'x'; "),
    ("{value: '0.1 + distance(\"x\")'}", "spacing.value: column 7: unknown label 'x'; "),
]


@pytest.mark.parametrize(("spacing", "message"), UNKNOWN, ids=[spacing for spacing, _ in UNKNOWN])
def test_unknown_names_are_told_with_their_key_and_the_known_ones(spacing, message):
    with pytest.raises(CaseError) as caught:
        requested(spacing)
    assert str(caught.value).startswith(message)
    if "label" in message:
        assert all(name in str(caught.value) for name in ("bore", "left", "core-rim", "crack", "well"))


def test_unknown_names_in_the_spacing_of_a_region_are_told_with_their_key():
    with pytest.raises(CaseError, match=r"^domain.regions.1.spacing: column 1: unknown label 'x'"):
        requested("1", ", spacing: \"distance('x')\"")


@pytest.mark.parametrize(
    ("spacing", "size", "told"),
    [
        ("0.15", np.where(SEED, 0.05, 9.0), []),
        (
            "{value: 0.15, nodes: 400}",
            np.full(X.shape, 9.0),
            ["domain.regions.1.spacing: does not hold, since with spacing.nodes its values are no lengths"],
        ),
    ],
)
def test_beside_another_spacing_that_of_a_region_is_a_limit_unless_it_is_scaled(spacing, size, told):
    case = load_case("plate.yaml", text=f"{DOMAIN.replace('OWN', ', spacing: 0.05')}spacing: {spacing}\n")
    request = held_request(case, BOUND, lambda scale: Spacing(lambda x, y: np.full(np.shape(x), 9.0)))
    np.testing.assert_array_equal(request.at(None)(POINTS), size)
    assert list(request.warnings) == told


def test_a_region_without_any_limit_is_named_by_a_point():
    with pytest.raises(CaseError, match=r"spacing: is inf at \("):
        values("{regions: {core: 0.1}}")


def test_terms_that_take_long_count_as_others_do():
    text = """
domain:
  outer: {rectangle: [0, 0, 4, 2], label: wall}
  holes:
    - {ellipse: {center: [1, 1], radii: [0.4, 0.2], angle: 30}, label: a}
    - {ellipse: {center: [3, 1], radii: [0.2, 0.4], angle: 30}, label: b}
spacing: {labels: {a: 0.02, b: 0.05, wall: 0.1}, near: {label: b, size: 0.03, growth: 0.4}, value: 0.25}
"""
    domain = domain_of(text.partition("spacing")[0])
    spacing = case_spacing(load_case("plate.yaml", text=text), domain).at(None)
    assert spacing.costly
    a, b, wall = (domain.distance_to(POINTS, label) for label in ("a", "b", "wall"))
    expected = np.min([0.02 + 0.2 * a, 0.05 + 0.2 * b, 0.03 + 0.4 * b, 0.1 + 0.2 * wall, np.full(len(X), 0.25)], axis=0)
    np.testing.assert_allclose(spacing(POINTS), expected, rtol=1e-9)
    assert spacing_of("0.1 + distance('a')", domain).at(None).costly
    assert not spacing_of("0.1 + distance('wall')", domain).at(None).costly
    assert not requested("{labels: {bore: 0.1}}").costly
    assert not requested("{value: 0.1, per_circle: 36}").costly


BAD = [
    ("{value: 0.2, regions: {core: 'x - 2.5'}}", "", r"spacing\.regions\.core: is -"),
    ("{value: 'x - 0.5', regions: {core: 0.1}, scale: 2}", "", r"spacing\.value: is -"),
    ("{value: 'x - 0.5'}", "", r"spacing\.value: is -"),
    ("'x - 0.5'", "", r"spacing: is -"),
    ("{value: 0.2, labels: {bore: 0.1}, maximum: 1}", ", spacing: 'x - 2.4'", r"domain\.regions\.1\.spacing: is -"),
    ("{maximum: 0.2, regions: {core: 'sqrt(x - 2.5)'}}", "", r"spacing\.regions\.core: is nan"),
]


@pytest.mark.parametrize(("spacing", "own", "message"), BAD)
def test_the_term_that_is_no_spacing_is_named(spacing, own, message):
    with pytest.raises(CaseError, match=f"^{message}") as caught:
        values(spacing, own)
    assert str(caught.value).startswith(f"{caught.value.about}: ")


def test_places_where_it_may_be_fine_are_known():
    terms = "{near: [{point: [1, 0.2], size: 0.1}, {line: [[0, 0.5], [4, 0.5]], size: 0.05}], labels: {well: 0.1}}"
    found = requested(terms).spots.tolist()
    assert [found[k] for k in (0, 1, -2, -1)] == [[1, 0.2], [0, 0.5], [4, 0.5], [3.5, 1.5]]
    assert {y for _, y in found[1:-1]} == {0.5}
    assert len(requested("0.1").spots) == 0


def test_a_tiny_spot_is_not_passed_by():
    text = f"{DOMAIN.replace('OWN', '')}spacing: {{value: 0.5, near: {{point: [3.01, 0.17], size: 1e-4, growth: 9}}}}\n"
    problem = prepare(load_case("plate.yaml", text=text))
    assert problem.packing_extremes.minimum == pytest.approx(1e-4, rel=0.05)


SCALED = [
    ("{maximum: 0.2, scale: 0.5}", np.full(len(X), 0.1)),
    ("{maximum: 0.2, scale: 3}", np.full(len(X), 0.2)),
    ("{labels: {bore: 0.05}, maximum: 0.2, scale: 0.5}", 0.5 * np.minimum(0.05 + 0.2 * BORE, 0.2)),
    ("{value: 1, labels: {bore: 0.05}, maximum: 0.2, scale: 0.5}", np.minimum(0.5 * (0.05 + 0.2 * BORE), 0.2)),
    ("{regions: {core: 0.1}, maximum: 0.2, scale: 0.5}", np.where(CORE & ~SEED, 0.05, 0.1)),
]


@pytest.mark.parametrize(("spacing", "expected"), SCALED, ids=[spacing for spacing, _ in SCALED])
def test_without_a_value_the_maximum_is_scaled_like_one(spacing, expected):
    np.testing.assert_allclose(values(spacing), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("terms", "at", "size"),
    [
        ("near: {point: [0.71, 0.43], size: 0.001, growth: 20}", (0.71, 0.43), 0.001),
        ("near: {line: [[0.61, 0.83], [1.31, 0.83]], size: 0.002, growth: 20}", (1.111, 0.83), 0.002),
        ("scattered: {points: [[0, 0, 0.2], [2, 0, 0.2], [2, 1, 0.2], [0, 1, 0.2], %s]}", (1.31, 0.62), 0.003),
    ],
)
def test_small_spots_of_terms_are_not_passed_over(terms, at, size):
    x, y = at
    ring = ", ".join(f"[{x + u}, {y + v}, 0.2]" for u, v in ((0.01, 0), (-0.01, 0), (0, 0.01), (0, -0.01)))
    points = f"[{x}, {y}, {size}], {ring}"
    text = "domain: {outer: {rectangle: [0, 0, 2, 1]}}\nspacing: {maximum: 0.2, growth: 0.2, %s}"
    problem = prepare(load_case("-", text=text % (terms % points if "%s" in terms else terms)))
    away = np.add(at, [[0, 0], [0, 0.01], [0, 0.1]])
    np.testing.assert_allclose(problem.packing_spacing(away), size + 0.2 * np.array([0, 0.01, 0.1]), rtol=0.05)
    assert problem.survey.extremes.minimum == pytest.approx(size, rel=0.01)


def test_the_estimate_tells_the_labels_of_all_that_is_inside_too():
    problem = prepare(load_case("plate.yaml", text=f"{DOMAIN.replace('OWN', '')}spacing: 0.2\n"))
    inner = {"bore", "core-rim", "seed-rim", "crack", "well"}
    assert set(estimate(problem)["labels"]) == {"bottom", "right", "top", "left", *inner}


@pytest.mark.parametrize("sizes", sweep([1, 100, 2], quick=2))
def test_very_many_points_count_as_each_of_them_would(sizes):
    rng = np.random.default_rng(1)
    places, size = rng.uniform(0.1, 0.9, (100, 2)), np.repeat([0.02 + 0.001 * k for k in range(sizes)], 100 // sizes)
    terms = [{"point": place, "size": own} for place, own in zip(places.tolist(), size.tolist(), strict=True)]
    found = values({"value": 0.5, "near": terms, "growth": 0.3})
    each = [values({"value": 0.5, "near": term, "growth": 0.3}) for term in terms]
    np.testing.assert_array_equal(found, np.min(each, axis=0))
