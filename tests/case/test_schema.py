"""The JSON Schema by which editors complete and check cases: it takes what `run` takes, and finds slips."""

import pytest
from json_schemas import faults
from paths import ROOT

from bubblemesh.case.models import case_schema, case_template
from bubblemesh.case.yaml import read_value

CONFIGS = sorted((ROOT / "configs").rglob("*.yaml"))
PLATE = """\
domain: {outer: {circle: {center: [0, 0], radius: r}, label: wall}}
spacing: "0.1 + 0.1*hypot(x, y)"
parameters: {r: 1}
"""


@pytest.fixture(scope="module")
def schema():
    return case_schema()


def found(text, schema):
    return list(faults(read_value(text, "case.yaml"), schema))  # as editors do, takes `on` for a text


def test_the_template_names_the_schema_in_its_first_line_and_fits_it(schema):
    first, *others = case_template().splitlines()
    assert first == "# yaml-language-server: $schema=bubblemesh.schema.json"
    assert any("bubblemesh schema > bubblemesh.schema.json" in line for line in others[:3])
    assert found(case_template(), schema) == []


def test_all_cases_of_the_repository_fit_the_schema(schema):
    assert len(CONFIGS) > 40
    assert {path.name: found(path.read_text(), schema) for path in CONFIGS} == {path.name: [] for path in CONFIGS}


@pytest.mark.parametrize(
    ("old", "new", "path"),
    [
        ("spacing:", "growth: 0.2\nspacing:", ()),
        ("spacing:", "Spacing:", ()),
        ("label: wall", "lable: wall", ("domain", "outer")),
        ("{center: [0, 0], radius: r}", "[0, 0, 1]", ("domain", "outer")),
        ("parameters:", "output: {formats: msh}\nparameters:", ("output", "formats")),
        ("parameters:", "output: {for: fenics}\nparameters:", ("output", "for")),
        ("parameters:", "packing: {sed: 3}\nparameters:", ("packing",)),
        ("parameters:", "method: mutilevel\nparameters:", ("method",)),
        ("parameters:", "angle_min: 45\nparameters:", ("angle_min",)),
    ],
)
def test_slips_are_found_where_they_are(old, new, path, schema):
    assert found(PLATE, schema) == []
    assert PLATE.count(old) == 1
    assert any(
        place[: len(path)] == path or path[: len(place)] == place for place, _ in found(PLATE.replace(old, new), schema)
    )


def test_a_case_with_a_base_needs_nothing_else(schema):
    assert found("base: other.yaml\n", schema) == []
    assert found("spacing: 0.1\n", schema) == [((), "anyOf")]
