"""The mapping under ``spacing`` in a case file: what it takes, and what it says of mistakes."""

import pytest

from bubblemesh.case import Case, load_case
from bubblemesh.case.models import case_schema, case_template
from bubblemesh.errors import CaseError

HEAD = "domain:\n  outer: {rectangle: [0, 0, 1, 1]}\n"


def loaded(spacing, more=""):
    return load_case("plate.yaml", text=f"{HEAD}spacing: {spacing}\n{more}")


ALL = """
  value: "0.1 + 0.2*distance('bottom')"
  near:
    - {label: bottom, size: 0.01, growth: 0.15}
    - {ends: [crack, fault], size: 0.01}
    - {point: [0.3, 0.2], size: 2e-3, until: 0.1}
    - {line: [[0, 0], [1, 1], [1, 0]], size: 0.02}
  labels: {top: 0.02, left: 0.05}
  regions: {domain: 0.1, core: "0.1 + h*distance()"}
  per_circle: 36
  across: 3
  scale: 0.5
  minimum: 0.001
  maximum: 0.2
  growth: 0.2
"""


def test_all_keys_together():
    terms = loaded(ALL, "parameters: {h: 2}\n").spacing
    label, ends, point, line = terms.near
    assert (label.label, label.size, label.growth, label.until) == ("bottom", 0.01, 0.15, 0)
    assert (ends.ends, ends.size, ends.growth, ends.until) == (("crack", "fault"), 0.01, None, 0)
    assert (point.point, point.size, point.growth, point.until) == ((0.3, 0.2), 0.002, None, 0.1)
    assert line.line == ((0, 0), (1, 1), (1, 0))
    assert terms.labels == {"top": 0.02, "left": 0.05}
    assert {name: str(value) for name, value in terms.regions.items()} == {
        "domain": "0.1",
        "core": "0.1 + h*distance()",
    }


def test_terms_survive_json():
    case = loaded(ALL, "parameters: {h: 2}\n")
    assert Case.model_validate_json(case.model_dump_json(), context=case.parameters) == case
    assert Case.model_validate(case.model_dump(), context=case.parameters) == case


def test_the_terms_of_the_template_are_right():
    shown = case_template().partition("# spacing:\n")[2].partition("\n\n")[0]
    lines = [line.removeprefix("#") for line in shown.splitlines()]
    terms = load_case("plate.yaml", text=f"{HEAD}spacing:\n" + "\n".join(lines) + "\n").spacing
    assert (terms.near.label, terms.labels, terms.maximum, terms.growth) == ("hole", {"left": 0.08}, 0.2, 0.2)


def test_one_thing_to_be_near_needs_no_list():
    assert loaded("{near: {label: bottom, size: 0.1}}").spacing.near.label == "bottom"


MISTAKES = [
    ("{value: 0.1, growht: 0.2}", "plate.yaml:3: spacing.growht: unknown key; did you mean 'growth'?"),
    ("{growth: 0.2}", "plate.yaml:3: spacing: must have a value or a maximum"),
    ("{near: []}", "plate.yaml:3: spacing.near: must have at least one entry"),
    (
        "{near: 3}",
        "plate.yaml:3: spacing.near: must be a mapping with exactly one of the keys label, ends, point, line",
    ),
    ("{near: [{size: 1}]}", "plate.yaml:3: spacing.near.0: must be a mapping with exactly one of the keys label, "),
    ("{near: [{lable: a, size: 1}]}", "exactly one of the keys label, ends, point, line; did you mean 'label'?"),
    (
        "{near: [{label: a, point: [0, 0], size: 1}]}",
        "exactly one of the keys label, ends, point, line (found the keys",
    ),
    ("{near: [{label: a}]}", "plate.yaml:3: spacing.near.0.size: is missing"),
    ("{near: [{label: a, sise: 1}]}", "plate.yaml:3: spacing.near.0.sise: unknown key; did you mean 'size'?"),
    ("{near: {label: a, sise: 1}}", "plate.yaml:3: spacing.near.sise: unknown key; did you mean 'size'?"),
    ("{near: [{label: a, size: 0}]}", "plate.yaml:3: spacing.near.0.size: must be greater than 0 (found 0)"),
    ("{near: [{label: a, size: x/9}]}", "spacing.near.0.size: must be a number (found the text 'x/9')"),
    ("{near: [{label: a, size: 1, growth: 0}]}", "spacing.near.0.growth: must be greater than 0 (found 0)"),
    ("{near: [{label: a, size: 1, growth: .inf}]}", "spacing.near.0.growth: must be a finite number (found inf)"),
    ("{near: [{label: a, size: 1, until: -1}]}", "spacing.near.0.until: must be at least 0 (found -1)"),
    ("{near: [{point: [0], size: 1}]}", "spacing.near.0.point: must be a point [x, y] (found the list [0])"),
    ("{near: [{line: [[0, 0], [0, 0]], size: 1}]}", "spacing.near.0.line: must have two different points at least"),
    ("{near: [{line: [[0, 0]], size: 1}]}", "spacing.near.0.line: must have two different points at least"),
    ("{near: [{line: 3, size: 1}]}", "spacing.near.0.line: must be a list (found 3; write [a, b], or a line"),
    ("{labels: {a: 0}}", "plate.yaml:3: spacing.labels.a: must be greater than 0 (found 0)"),
    ("{labels: {a: x}}", "plate.yaml:3: spacing.labels.a: must be a number (found the text 'x')"),
    ("{labels: [a]}", "plate.yaml:3: spacing.labels: must be a mapping of keys to values"),
    ("{regions: {a: -1}}", "plate.yaml:3: spacing.regions.a: must be greater than 0 (found -1)"),
    ("{regions: {a: true}}", "spacing.regions.a: must be a number or an expression in x and y (found true)"),
    ("{regions: {a: 2*z}}", "plate.yaml:3: spacing.regions.a: column 3: unknown name 'z'; allowed: x, y, pi, e"),
    ("{value: distance(a)}", "plate.yaml:3: spacing.value: column 10: distance takes labels in quotes"),
    ("distance(a)", "plate.yaml:3: spacing: column 10: distance takes labels in quotes"),
]


@pytest.mark.parametrize(("spacing", "message"), MISTAKES, ids=[spacing for spacing, _ in MISTAKES])
def test_mistakes_are_named_with_their_place(spacing, message):
    with pytest.raises(CaseError) as caught:
        loaded(spacing)
    assert message in str(caught.value)


def test_mistakes_in_the_spacing_of_a_region_are_found_on_loading():
    region = "  regions: [{name: a, ring: {circle: {center: [0.5, 0.5], radius: 0.1}}, spacing: 2*z}]\n"
    with pytest.raises(CaseError, match=r"plate.yaml:3: domain.regions.0.spacing: column 3: unknown name 'z'"):
        load_case("plate.yaml", text=f"{HEAD}{region}spacing: 1\n")


def test_labels_are_not_looked_for_before_there_is_a_domain():
    assert loaded("\"0.1 + distance('nowhere')\"").spacing.text == "0.1 + distance('nowhere')"


def test_the_schema_has_the_terms():
    definitions = case_schema()["$defs"]
    terms = definitions["SpacingTerms"]["properties"]
    assert {"value", "near", "labels", "regions", "growth", "minimum"} <= set(terms)
    assert all(terms[key].get("description") for key in terms)
    assert set(definitions["NearLabel"]["properties"]) == {"label", "size", "growth", "until"}
    assert definitions["NearPoint"]["required"] == ["size", "point"]
    assert definitions["NearEnds"]["required"] == ["size", "ends"]
