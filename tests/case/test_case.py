"""Case files: what they may say, and where errors are."""

import json

import pytest
from case_data import SQUARE
from pydantic import BaseModel

from bubblemesh.case import Case, load_case
from bubblemesh.case.models import case_schema, case_template
from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.packing.methods import METHODS
from bubblemesh.problem.prepare import prepare
from bubblemesh.problem.shapes import areas_of
from bubblemesh.problem.task import method_of


def case_of(text, **options):
    return load_case("folder/plate.yaml", text=text, **options)


def message_of(text, **options):
    with pytest.raises(CaseError) as caught:
        case_of(text, **options)
    return str(caught.value)


INVALID = [
    ("spacing: 0.1", "spacing: -0.1", "folder/plate.yaml:7: spacing: must be greater than 0 (found -0.1)"),
    ("spacing: 0.1", "spacing: 0", "folder/plate.yaml:7: spacing: must be greater than 0 (found 0)"),
    ("spacing: 0.1", "spacing: .nan", "folder/plate.yaml:7: spacing: must be a finite number (found nan)"),
    ("spacing: 0.1", "spacing: .inf", "folder/plate.yaml:7: spacing: must be a finite number (found inf)"),
    (
        "spacing: 0.1",
        "spacing: true",
        "plate.yaml:7: spacing: must be a number, an expression in x and y, or a mapping of terms (found true)",
    ),
    (
        "spacing: 0.1",
        "spacing:",
        "plate.yaml:7: spacing: must be a number, an expression in x and y, or a mapping of terms (found nothing)",
    ),
    ("spacing: 0.1", "spacing: ''", "plate.yaml:7: spacing: the expression is empty"),
    (
        "spacing: 0.1",
        "spacing: 2*sqr(x)",
        "plate.yaml:7: spacing: column 3: unknown function 'sqr'; did you mean 'sqrt'?",
    ),
    ("spacing: 0.1", "spacing: x.real", "plate.yaml:7: spacing: column 1: a dot"),
    ("spacing: 0.1", "", "plate.yaml:1: spacing: is missing"),
    ("spacing", "spacign", "plate.yaml:7: spacign: unknown key; did you mean 'spacing'?"),
    ("  holes", "  hole", "plate.yaml:5: domain.hole: unknown key; did you mean 'holes'?"),
    ("radius", "radious", "plate.yaml:6: domain.holes.0.circle.radious: unknown key; did you mean 'radius'?"),
    (
        "label: hole",
        "zzz: hole",
        "plate.yaml:6: domain.holes.0.zzz: unknown key; allowed: circle, label, mirror, scale, rotate, move, repeat",
    ),
    ("label: hole", "labels: [a]", "plate.yaml:6: domain.holes.0.labels: unknown key; did you mean 'label'?"),
    ("radius: 0.2", "radius: 0", "plate.yaml:6: domain.holes.0.circle.radius: must be greater than 0 (found 0)"),
    ("radius: 0.2", "radius: '3'", "circle.radius: must be a number (found the text '3'; remove the quotes)"),
    (
        "{circle: {center: [0.5, 0.5], radius: 0.2}, label: hole}",
        "{ellipse: {center: [0.5, 0.5], radii: [0.3, 4e-6]}, label: hole}",
        "plate.yaml:6: domain.holes.0.ellipse.radii: must differ by a factor of 70,000 at most: draw so flat an "
        "ellipse as a line, under lines (found the list [0.3, 4e-06])",
    ),
    ("radius: 0.2", "radius: true", "circle.radius: must be a number (found true)"),
    ("radius: 0.2", f"radius: {'9' * 400}", "circle.radius: must be a finite number (found inf)"),
    ("[1, 0]", "[1, .nan]", "plate.yaml:3: domain.outer.polygon.1.1: must be a finite number (found nan)"),
    ("[1, 0]", "[-.inf, 0]", "plate.yaml:3: domain.outer.polygon.1.0: must be a finite number (found -inf)"),
    ("[1, 0]", "[1e71, 0]", "plate.yaml:3: domain.outer.polygon.1.0: must be at most 1e+70 (found 1e+71)"),
    ("[1, 0]", "[1]", "plate.yaml:3: domain.outer.polygon.1: must be a point [x, y] (found the list [1])"),
    ("[1, 0]", "7", "plate.yaml:3: domain.outer.polygon.1: must be a point [x, y] (found 7)"),
    (
        "[1, 0]",
        "[a, 0]",
        "plate.yaml:3: domain.outer.polygon.1.0: must be a number (found the text 'a'), or an",
    ),
    ("[bottom, on, no, 4]", "[a, b]", "plate.yaml:4: domain.outer.labels: must be one per side: 2 labels for 4 sides"),
    ("[bottom, on, no, 4]", "[a, b, c, true]", "plate.yaml:4: domain.outer.labels.3: must be text (found true)"),
    ("[bottom, on, no, 4]", "[a, b, c, '']", "plate.yaml:4: domain.outer.labels.3: must not be empty"),
    ("[bottom, on, no, 4]", "[a, b, c, 'a\"b']", "plate.yaml:4: domain.outer.labels.3: must be printable"),
    ("    labels", "    label: a\n    labels", "plate.yaml:5: domain.outer.labels: and label exclude each other"),
    (
        "    labels",
        "    rectangle: [0, 0, 1, 1]\n    labels",
        "plate.yaml:2: domain.outer: must be a mapping with exactly one of the keys polygon, rectangle, circle, "
        "ellipse, path, file, union, minus, intersection (found the keys polygon, rectangle, labels)",
    ),
    (
        "{circle:",
        "{circel:",
        "minus, intersection; did you mean 'circle'? (found the keys circel, label)",
    ),
    (
        "- {circle: {center: [0.5, 0.5], radius: 0.2}, label: hole}",
        "- 3",
        "plate.yaml:6: domain.holes.0: must be a mapping",
    ),
    (
        "spacing: 0.1",
        "spacing: 0.1\npacking: 3",
        "plate.yaml:8: packing: must be a mapping of keys to values (found 3)",
    ),
    ("spacing: 0.1", "spacing: 0.1\nname: a/b", "plate.yaml:8: name: must be usable as a file name"),
    ("spacing: 0.1", "spacing: 0.1\nname: ''", "plate.yaml:8: name: must not be empty"),
    ("spacing: 0.1", "spacing: 0.1\nname: ..", "plate.yaml:8: name: must be usable as a file name"),
    ("label: hole", "label: 1.10", "label: must be a text or a whole number (found 1.1): put it in quotes"),
    ("spacing: 0.1", "spacing: 0.1\nparameters: {x: 1}", "plate.yaml:8: parameters.x: the parameter 'x' would hide"),
    ("spacing: 0.1", "spacing: 0.1\nparameters: {a: b}", "plate.yaml:8: parameters.a: must be a number"),
    (
        "spacing: 0.1",
        "spacing: 0.1\noutput: {formats: [msh, stl]}",
        "plate.yaml:8: output.formats.1: must be 'msh', 'vtu'",
    ),
    (
        "spacing: 0.1",
        "spacing: 0.1\noutput: {formats: [msh, vtu, msh]}",
        "plate.yaml:8: output.formats: msh is there twice: name it once",
    ),
    ("spacing: 0.1", "spacing: 0.1\noutput: {formats: []}", "plate.yaml:8: output.formats: must not be empty"),
    (
        "spacing: 0.1",
        "spacing: 0.1\noutput: {formats: msh}",
        "plate.yaml:8: output.formats: must be a list (found the text",
    ),
    ("spacing: 0.1", "spacing: 0.1\nlimits: {max_nodes: 0}", "plate.yaml:8: limits.max_nodes: must be greater than 0"),
    ("spacing: 0.1", "spacing: 0.1\nlimits: {max_nodes: 1.5}", "limits.max_nodes: must be a whole number (found 1.5)"),
    ("spacing: 0.1", "spacing: 0.1\nrequire: {quality_min: 2}", "plate.yaml:8: require.quality_min: must be at most 1"),
    ("spacing: 0.1", "spacing: 0.1\nrequire: [1]", "plate.yaml:8: require: must be a mapping of keys to values"),
]


PATHS = [
    ("[]", "domain.outer.path: must have at least one entry"),
    ("3", "domain.outer.path: must be a list (found 3; write [a, b], or a line"),
    ("[{to: [1, 0]}]", "domain.outer.path: must begin with a point [x, y] (found the keys to)"),
    (
        "[[0, 0], {too: [1, 0]}]",
        "domain.outer.path.1: must be a point [x, y], or a mapping with exactly one of the keys to",
    ),
    ("[[0, 0], {to: [1, 0], lable: a}]", "domain.outer.path.1.lable: unknown key; did you mean 'label'?"),
    ("[[0, 0], {to: [1]}]", "domain.outer.path.1.to: must be a point [x, y]"),
    ("[[0, 0], [1]]", "domain.outer.path.1: must be a point [x, y]"),
    (
        "[[0, 0], {arc: {to: [1, 0], center: [0, 0], turn: up}}]",
        "path.1.arc.turn: must be 'left' or 'right' (found the text",
    ),
    ("[[0, 0], {arc: {to: [1, 0], turn: left}}]", "domain.outer.path.1.arc.center: is missing"),
    (
        "[[0, 0], {arc: {to: [1, 0], centre: [0, 0], turn: left}}]",
        "path.1.arc.centre: unknown key; did you mean 'center'?",
    ),
    ("[[0, 0], {spline: {through: []}}]", "domain.outer.path.1.spline.through: must have at least one entry"),
    ("[[0, 0], {spline: {through: [[1, .nan]]}}]", "domain.outer.path.1.spline.through.0.1: must be a finite number"),
]


class TestLoading:
    def test_defaults(self):
        case = case_of(SQUARE)
        assert (case.name, case.method, case.spacing) == ("plate", "multilevel", 0.1)
        assert (case.packing, case.schedule, case.parameters) == ({}, {}, {})
        assert case.output.formats == ("msh", "vtu")
        assert case.limits.max_nodes == 2_000_000
        assert case.domain.outer.labels == ("bottom", "on", "no", "4")
        assert load_case("-", text=SQUARE).name == "mesh"

    def test_file_is_read(self, tmp_path):
        path = tmp_path / "square.yaml"
        path.write_text(SQUARE)
        assert load_case(path) == load_case(str(path))
        assert load_case(path).name == "square"

    def test_template_loads(self):
        case = case_of(case_template())
        assert (case.name, case.method) == ("plate", "multilevel")
        assert case.spacing.text.startswith("h*(1 + 2*max")

    def test_case_survives_json(self):
        case = case_of(case_template())
        assert Case.model_validate_json(case.model_dump_json(), context=case.parameters) == case
        assert Case.model_validate(case.model_dump(), context=case.parameters) == case

    @pytest.mark.parametrize(("old", "new", "message"), INVALID, ids=[new[:40] for _, new, _ in INVALID])
    def test_problem_names_place_and_key(self, old, new, message):
        found = message_of(SQUARE.replace(old, new, 1))
        assert message in found
        assert len(found.splitlines()) <= 2

    @pytest.mark.parametrize(("path", "message"), PATHS)
    def test_problem_in_a_path(self, path, message):
        found = message_of(f"spacing: 1\ndomain:\n  outer:\n    path: {path}\n")
        assert found.startswith("folder/plate.yaml:4: ")
        assert message in found
        assert len(found.splitlines()) <= 2

    def test_every_problem_is_listed_up_to_ten(self):
        assert message_of("method: 3\nspacing: -1\n").splitlines() == [
            "folder/plate.yaml:1: domain: is missing",
            "folder/plate.yaml:2: spacing: must be greater than 0 (found -1)",
            "folder/plate.yaml:1: method: must be text (found 3)",
        ]
        many = SQUARE + "".join(f"wrong_{k}: 1\n" for k in range(100))
        assert message_of(many).splitlines()[10:] == ["... and 90 more"]

    def test_standard_input_has_a_name(self):
        with pytest.raises(CaseError, match=r"^<stdin>:1: domain: is missing"):
            load_case("-", text="spacing: 1")

    def test_file_stem_must_be_usable_as_name(self):
        with pytest.raises(CaseError, match=r"name: must be usable as a file name"):
            load_case("a\nb.yaml", text=SQUARE)

    def test_overrides(self):
        case = case_of(
            SQUARE,
            overrides=["domain.holes.0.circle.radius=0.3", "parameters.h=1e-1", "spacing=h*2", "limits.max_nodes=1e4"],
        )
        assert case.domain.holes[0].circle.radius == 0.3
        assert (case.spacing.text, case.parameters, case.limits.max_nodes) == ("h*2", {"h": 0.1}, 10_000)

    def test_plain_spacing_that_gets_a_key_becomes_the_value(self):
        one, other = (
            case_of(SQUARE.replace("spacing: 0.1", f"spacing: {text}"), overrides=["spacing.nodes=50"])
            for text in ("x + 2", "{value: x + 2}")
        )
        assert one.spacing == other.spacing
        assert (one.spacing.value.text, one.spacing.nodes) == ("x + 2", 50)

    @pytest.mark.parametrize(
        ("option", "message"),
        [
            (
                "domain.holes.0.circle.radius=-1",
                "overrides: domain.holes.0.circle.radius: must be gr",
            ),
            ("domain.outer.polygon=[[1]]", "overrides: domain.outer.polygon.0: must be a point"),
            ("limits.max_node=1", "overrides: limits.max_node: unknown key; did you mean 'max_nodes'?"),
            ("bogus.key=1", "overrides: bogus: unknown key; allowed: "),
            ("spacing=hh", "overrides: spacing: column 1: unknown name 'hh'"),
            (
                "domain.holes.0.label.h=3",
                "overrides: domain.holes.0.label is the plain value 'hole'",
            ),
            ("spacing.h=3", "overrides: spacing.h: unknown key; "),
            ("spacing.nodes=2", "overrides: spacing.nodes: must be at least 3 (found 2)"),
        ],
    )
    def test_problem_of_an_override_names_the_option(self, option, message):
        assert message in message_of(SQUARE, overrides=[option])

    def test_method_and_seed_options(self):
        case = case_of(SQUARE, method="accelerated", seed=7)
        assert (case.method, case.packing) == ("accelerated", {"seed": 7})

    def test_options_of_another_method_are_left_out_where_an_option_names_the_method(self):
        text = SQUARE + "method: accelerated\npacking: {seed: 3, w2: 0.7}\nschedule: {c_out: 0.3}\n"
        case = case_of(text, method="multilevel")
        assert (case.method, case.packing, case.schedule) == ("multilevel", {"seed": 3}, {})
        assert case.warnings == (
            "packing.w2: the method 'multilevel' does not use this key: it is left out",
            "schedule.c_out: the method 'multilevel' does not use this key: it is left out",
        )
        assert prepare(case).warnings[:2] == case.warnings
        assert case_of(text).warnings == ()

    def test_options_that_no_method_knows_stay_errors_and_so_do_those_of_the_command_line(self):
        text = SQUARE + "packing: {w2: 0.7}\n"
        assert message_of(text).startswith("folder/plate.yaml:8: packing.w2: the method 'multilevel' does not use")
        zzz = message_of(SQUARE + "packing: {zzz: 1}\n", method="bpm")
        assert zzz.startswith("folder/plate.yaml:8: packing.zzz: ")
        both = message_of(SQUARE, method="multilevel", overrides=["packing.w2=0.7"])
        assert both.startswith("overrides: packing.w2: the method 'multilevel' does not use this key")

    def test_a_copy_with_another_method_is_configured_anew(self):
        assert method_of(case_of(SQUARE).model_copy(update={"method": "bpm"})) == METHODS["bpm"]

    def test_unknown_method_and_option(self):
        name = next(iter(METHODS))
        assert message_of(SQUARE + "method: " + name + "x\n").startswith("folder/plate.yaml:8: method: ")
        assert message_of(SQUARE, method="zzz").startswith("load_case(): method: unknown method 'zzz'")
        assert message_of(SQUARE, seed=-1).startswith("seed: packing.seed: ")
        assert message_of(SQUARE + "packing: {zzz: 1}\n").startswith("folder/plate.yaml:8: packing.zzz: ")
        assert message_of(SQUARE + "schedule:\n  zzz: 1\n").startswith("folder/plate.yaml:9: schedule.zzz: ")
        assert message_of(SQUARE, overrides=["packing.zzz=1"]).startswith("overrides: packing.zzz: ")


class TestRings:
    @pytest.mark.parametrize(
        "ring",
        [
            {"polygon": [[0, 0], [1, 0], [0, 1]], "labels": [1, "on", "c"]},
            {"polygon": [[0, 0], [1, 0], [0, 1], [0, 0]], "labels": ["a", "b", "c"]},
            {"rectangle": [0, 0, 1, 2], "labels": ["a", "b", "c", "d"]},
            {"circle": {"center": [0, 0], "radius": 1}, "label": "rim"},
            {"ellipse": {"center": [0, 0], "radii": [1, 2]}},
            {"ellipse": {"center": [0, 0], "radii": [1, 2], "angle": 30}},
            {"path": [[1, 0], {"arc": {"to": [-1, 0], "center": [0, 0], "turn": "left"}, "label": "rim"}]},
            {"path": [[0, 0], [1, 0], {"to": [1, 1], "label": "a"}, {"spline": {"through": [[0.5, 1.2], [0, 1]]}}]},
        ],
    )
    def test_every_shape_makes_a_ring(self, ring):
        case = Case.model_validate({"domain": {"outer": ring}, "spacing": 1})
        assert areas_of(case.domain.outer)[0].outer.sides

    def test_polygon_without_points_is_no_geometry(self):
        case = Case.model_validate({"domain": {"outer": {"polygon": []}}, "spacing": 1})
        with pytest.raises(GeometryError, match="no points"):
            areas_of(case.domain.outer)


def test_every_field_has_a_description_of_one_sentence():
    def models(model):
        yield model
        for child in model.__subclasses__():
            yield from models(child)

    strict = Case.__mro__[1]
    assert issubclass(strict, BaseModel)
    for model in models(strict):
        for name, field in model.model_fields.items():
            description = field.description or ""
            assert description.endswith("."), (model, name)
            assert ". " not in description, (model, name)


def test_numbers_of_domain_and_spacing_may_be_expressions_of_the_parameters():
    text = """
parameters: {r: 0.2, n: 3}
domain:
  outer: {rectangle: [0, 0, 10*r, sqrt(n)]}
  holes: [{ellipse: {center: [5*r, "1/2"], radii: [r, r/2], angle: 10*n}, label: bore}]
spacing: {near: [{point: [0, r], size: r/10, growth: 1/20}], labels: {bore: r/n}, maximum: 0.5*r, per_circle: 12*n}
"""
    plain = """
parameters: {r: 0.3, n: 4}
domain:
  outer: {rectangle: [0, 0, 3.0, 2.0]}
  holes: [{ellipse: {center: [1.5, 0.5], radii: [0.3, 0.15], angle: 40}, label: bore}]
spacing: {near: [{point: [0, 0.3], size: 0.03, growth: 0.05}], labels: {bore: 0.075}, maximum: 0.15, per_circle: 48}
"""
    overrides = ["parameters.r=0.3", "parameters.n=4"]
    assert case_of(text, overrides=overrides) == case_of(plain)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (
            "2*q",
            "number (found the text '2*q'), or an expression of the parameters: column 3: unknown name",
        ),
        ("x", "unknown name 'x'; allowed: pi, e, r"),
        ("distance()", "there is none here"),
        ("r - 0.5", "circle.radius: must be greater than 0 (found -0.3)"),
        ("r/0", "circle.radius: must be a finite number (found inf)"),
        ("r.real", "column 1: a dot"),
    ],
)
def test_expressions_of_the_parameters_that_make_no_number(value, message):
    found = message_of(SQUARE.replace("radius: 0.2", f"radius: {value}") + "parameters: {r: 0.2}\n")
    assert found.startswith("folder/plate.yaml:6: domain.holes.0.circle.radius: must be ")
    assert message in found


def test_json_schema_names_every_key_and_forbids_others():
    schema = case_schema()
    json.dumps(schema, allow_nan=False)
    assert list(schema["properties"]) == list(Case.model_fields)
    assert schema["additionalProperties"] is False
    assert schema["anyOf"] == [{"required": ["domain", "spacing"]}, {"required": ["base"]}]
    assert len(schema["$defs"]["RingDomain"]["properties"]["outer"]["anyOf"][0]["anyOf"]) == 9
    assert schema["$defs"]["CircleKeys"]["properties"]["radius"]["anyOf"][0]["exclusiveMinimum"] == 0
