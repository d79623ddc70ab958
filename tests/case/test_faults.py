"""What a message on a wrong case tells: causes without what follows from them, and where keys belong."""

import pytest

from bubblemesh.case import load_case
from bubblemesh.case.key_homes import homes
from bubblemesh.case.models import Case
from bubblemesh.errors import CaseError

PLATE = """\
parameters:
  r: 0.4
  h: 0.06
domain:
  outer: {rectangle: [-1, -1, 1, 1], labels: [bottom, right, top, left]}
  holes:
    - {circle: {center: [0, 0], radius: r}, label: "hole {r}"}
spacing: "h + 0.1*(hypot(x, y) - r)"
"""


def faults(text):
    """Lines of the message, without the name of the file."""
    with pytest.raises(CaseError) as caught:
        load_case("plate.yaml", text=text)
    return [line.removeprefix("plate.yaml:") for line in str(caught.value).splitlines()]


def with_(old, new):
    assert PLATE.count(old) == 1
    return PLATE.replace(old, new)


@pytest.mark.parametrize("value", ["[0.4]", '"0.4"', ".inf", "true", "2*q", "0.4 mm", "{a: 1}", "r/2"])
def test_a_parameter_with_a_fault_is_told_of_alone(value):
    (line,) = faults(with_("r: 0.4", f"r: {value}"))
    assert line.startswith("2: parameters.r: ")


def test_parameters_that_depend_on_one_with_a_fault_are_left_out():
    (line,) = faults(with_("h: 0.06", "h: 2*d\n  d: r/s\n  s: [1]"))
    assert line == "5: parameters.s: must be a number (found the list [1])"


def test_faults_beside_that_of_a_parameter_are_told_of():
    assert faults(with_("h: 0.06", "h: 2*q").replace("holes", "hole")) == [
        "3: parameters.h: must be a number, or an expression of other parameters: column 3: "
        "unknown name 'q'; allowed: pi, e, r, h, at 'q'",
        "6: domain.hole: unknown key; did you mean 'holes'?",
    ]


def test_a_name_that_stands_for_nothing_is_told_of_once():
    (line,) = faults(with_("r: 0.4", "radius: 0.4").replace('"hole {r}"', "hole"))
    assert line.startswith("7: domain.holes.0.circle.radius: ")
    assert line.endswith("(also in spacing)")


def test_a_parameter_named_like_a_coordinate_hides_no_other_fault():
    first, second = faults(with_("h: 0.06", "x: 0.06"))
    assert first.startswith("3: parameters.x: ")
    assert second.startswith("8: spacing: column 1: unknown name 'h'")


def test_a_key_that_is_missing_for_a_slip_beside_it_is_not_told_of():
    assert faults(with_("center: [0, 0], radius", "centre: [0, 0], r")) == [
        "7: domain.holes.0.circle.centre: unknown key; did you mean 'center'?",
        "7: domain.holes.0.circle.r: unknown key; did you mean 'radius'?",
    ]
    assert faults(with_("spacing", "Spacing")) == ["8: Spacing: unknown key; did you mean 'spacing'?"]


def test_keys_of_a_mapping_that_was_forgotten_explain_that_it_is_missing():
    flat = "outer: {circle: {center: [0, 0], radius: 1}}\nholes: []\nspacing: 0.1\n"
    assert faults(flat) == [
        "1: outer: unknown key; it belongs under domain",
        "2: holes: unknown key; it belongs under domain, beside outer",
    ]


def test_a_list_whose_only_entry_has_a_fault_is_not_told_to_be_empty():
    (line,) = faults(PLATE + "output: {formats: [stl]}\n")
    assert line.startswith("9: output.formats.0: must be 'msh', 'vtu'")


def test_alike_faults_in_one_list_are_one_line():
    (line,) = faults("domain: {outer: {polygon: [0, 0, 1, 0, 1, 1]}}\nspacing: 0.1\n")
    assert line == "1: domain.outer.polygon.0: must be a point [x, y] (found 0) (and 5 more like it)"
    assert len(faults("domain: {outer: {polygon: [[0, 0], 1, 2, [1, 1]]}}\nspacing: 0.1\n")) == 2


# A key at the top of the case, and what its message tells.
BELONG = {
    "growth": "it belongs under spacing",
    "per_circle": "it belongs under spacing",
    "seed": "it belongs under packing",
    "effort": "it belongs under packing",
    "rounds": "it belongs under schedule",
    "c_in": "it belongs under schedule",
    "formats": "it belongs under output",
    "max_nodes": "it belongs under limits",
    "quality_min": "it belongs under require",
    "units": "it belongs under domain, beside file",
    "features": "did you mean 'feature'? It belongs under domain, beside file",
    "regions": "it belongs under domain or under spacing",
    "size": "it belongs under spacing.near",
    "spacin": "did you mean 'spacing'?",
    "zzz": "allowed: base, name, ",
}


@pytest.mark.parametrize("key", BELONG)
def test_an_unknown_key_is_told_where_it_belongs(key):
    (line,) = faults(PLATE + f"{key}: 1\n")
    assert line.startswith(f"9: {key}: unknown key; {BELONG[key]}")


@pytest.mark.parametrize(
    ("old", "new", "advice"),
    [
        ("radius: r}", "radius: r}, layer: A", "it belongs beside file"),
        ("radius: r}", "radius: r}, corners: 30", "it belongs beside polygon, file, union, minus or intersection"),
        (
            "radius: r}",
            "radius: r}, growth: 0.2",
            "it belongs under spacing, under metric, beside like or under layers",
        ),
        ("label:", "labels:", "did you mean 'label'? 'labels' belongs beside polygon or rectangle"),
        ("  holes:", "  spacing: 0.1\n  holes:", "it belongs at the top level or under domain.regions"),
        ("spacing:", "limits: {nodes: 9}\nspacing:", "did you mean 'max_nodes'? 'nodes' belongs under spacing"),
    ],
)
def test_an_unknown_key_deeper_down_is_told_where_it_belongs(old, new, advice):
    (line,) = faults(with_(old, new))
    assert line.endswith(f"unknown key; {advice}")


@pytest.mark.parametrize(
    ("section", "key", "advice"),
    [
        ("packing", "w1", "the method 'multilevel' does not use this key: it belongs to the methods bpm, fnpbs, "),
        ("packing", "rounds", "the method 'multilevel' does not use this key: it belongs under schedule"),
        ("schedule", "seed", "the method 'multilevel' does not use this key: it belongs under packing"),
        ("packing", "c0", "the method 'multilevel' does not use this key: it belongs under schedule, for other"),
        ("packing", "efort", "the method 'multilevel' does not use this key: did you mean 'effort'?"),
        ("packing", "growth", "unknown key; it belongs under spacing"),
    ],
)
def test_an_option_that_the_method_lacks_is_told_where_it_belongs(section, key, advice):
    (line,) = faults(PLATE + f"{section}: {{{key}: 1}}\n")
    assert line.startswith(f"9: {section}.{key}: {advice}")


def test_all_options_with_faults_are_told_of():
    lines = faults(PLATE + "packing: {seed: x, sed: 1}\nschedule: {rounds: 0}\n")
    assert [line.partition(": ")[2].partition(":")[0] for line in lines] == [
        "packing.seed",
        "packing.sed",
        "schedule.rounds",
    ]


def test_keys_of_a_ring_that_was_forgotten_are_told_where_they_belong():
    (line,) = faults(with_("circle: {center: [0, 0], radius: r}", "center: [0, 0], radius: r"))
    assert line.endswith("(found the keys center, radius, label; center, radius belong under circle)")


def test_the_form_of_a_mapping_is_told():
    (line,) = faults(with_("{center: [0, 0], radius: r}", "[0, 0, r]"))
    assert line.endswith("(found the list [0, 0, 'r']; write {center: ..., radius: ...})")


def test_every_key_of_the_schema_has_a_home():
    known = set()

    def walk(node):
        if isinstance(node, dict):
            known.update(node.get("properties", {}))
            node = list(node.values())
        for part in node if isinstance(node, list) else ():
            walk(part)

    walk(Case.model_json_schema())
    assert homes(Case).keys() == known
