"""Sweeps: a file that stands for several cases."""

import re
import subprocess
import sys

import pytest
from batches import SMALL

from bubblemesh.case import case_variants, load_case
from bubblemesh.case.models import case_schema
from bubblemesh.errors import CaseError


@pytest.fixture
def case(tmp_path):
    def write(sweep, text=SMALL, name="plate.yaml"):
        path = tmp_path / name
        path.write_text(f"{text}sweep: {sweep}\n")
        return path

    return write


def labels(path, **options):
    return [variant.label for variant in case_variants(path, **options)]


def test_a_sweep_is_a_case_for_each_combination_in_order(case):
    path = case("{packing.w2: [0.5, 0.7], spacing: [0.2, 0.3, 0.4]}")
    cases = [load_case(path, variant=variant) for variant in case_variants(path)]
    assert [(one.packing["w2"], one.spacing) for one in cases] == [
        (0.5, 0.2),
        (0.5, 0.3),
        (0.5, 0.4),
        (0.7, 0.2),
        (0.7, 0.3),
        (0.7, 0.4),
    ]
    assert [one.name for one in cases][:2] == ["plate-w2=0.5-spacing=0.2", "plate-w2=0.5-spacing=0.3"]
    assert len({one.name for one in cases}) == 6
    assert {one.method for one in cases} == {"accelerated"}
    assert {one.sweep for one in cases} == {None}


def test_the_cases_of_a_sweep_are_those_of_its_files_as_they_were_when_these_were_read_once(case):
    path = case("{packing.seed: [1, 2]}", text="base: base.yaml\n")
    (path.parent / "base.yaml").write_text(SMALL)
    variants = case_variants(path)
    (path.parent / "base.yaml").unlink()
    path.write_text("spacing: [\n")
    assert [load_case(path, variant=variant).packing["seed"] for variant in variants] == [1, 2]


def test_a_file_without_a_sweep_is_one_case(tmp_path):
    path = tmp_path / "plate.yaml"
    path.write_text(SMALL)
    (variant,) = case_variants(path)
    assert (variant.label, variant.values) == ("", ())
    assert load_case(path, variant=variant) == load_case(path)


@pytest.mark.parametrize(
    ("sweep", "expected"),
    [
        ("{method: [bpm, fnpbs]}", ["-method=bpm", "-method=fnpbs"]),
        ("{packing.dt: [1e-3, 1.5, -2]}", ["-dt=0.001", "-dt=1.5", "-dt=-2"]),
        ("{spacing: [0.1 + x/5, 0.2]}", ["-spacing=1", "-spacing=2"]),  # no words for file names
        ("{domain.outer: [{circle: {center: [0, 0], radius: 1}}]}", ["-outer=1"]),
        ("{a: [0.5, '0.5']}", ["-a=1", "-a=2"]),
        ("{a: [x, X]}", ["-a=1", "-a=2"]),  # one file on some systems
        ("{a: [true, null, 1]}", ["-a=true", "-a=null", "-a=1"]),
        ("{a.0.r: [1], a.1.r: [2], b.c: [3]}", ["-0.r=1-1.r=2-b.c=3"]),
        ("{a: [1], b.a: [2]}", ["-a=1-b.a=2"]),
        ("{a: {from: -10, to: -7, step: 1}}", ["-a=-10", "-a=-9", "-a=-8", "-a=-7"]),
        ("{a: {from: 0, to: 0.3, step: 0.1}}", ["-a=0", "-a=0.1", "-a=0.2", "-a=0.3"]),
        ("{a: {from: 1, to: 0, step: -0.4}}", ["-a=1", "-a=0.6", "-a=0.2"]),
        ("{a: {from: 0.1, to: 0.7, count: 3}}", ["-a=0.1", "-a=0.4", "-a=0.7"]),
        ("{a: {from: 5, to: 5, step: 1}}", ["-a=5"]),
        ("null", [""]),
    ],
)
def test_names_tell_the_values_where_a_file_name_can(sweep, expected, case):
    assert labels(case(sweep)) == expected


def test_the_name_of_the_case_comes_before_the_values(case):
    path = case("{packing.w2: [0.5]}", SMALL + "name: slab\n")
    (variant,) = case_variants(path)
    assert load_case(path, variant=variant).name == "slab-w2=0.5"


@pytest.mark.parametrize(
    ("sweep", "message"),
    [
        ("3", "plate.yaml:6: sweep: must be a mapping of keys to lists of values: write packing.w2: [0.6, 0.7]"),
        ("{}", "sweep: must be a mapping of keys"),
        ("{packing.w2: 0.5}", "plate.yaml:6: sweep.packing.w2: must be a list of values (found 0.5)"),
        ("{packing.w2: []}", "must be a list of values"),
        ("{packing: {w2: [1]}}", "write the key in one word, packing.w2: [...]"),
        ("{packing..w2: [1]}", "sweep.packing..w2: has an empty part"),
        ("{a: [1, 2.5, 1.0]}", "sweep.a: 1.0 is there twice"),
        ("{a: [{b: 1}, {b: 1}]}", "sweep.a: the keys b is there twice"),
        (
            "\n  parameters.h: [0.2, 0.4]\n  parameters: [{h: 0.3}, {h: 0.5}]",
            "plate.yaml:8: sweep: parameters.h and parameters set the same thing: keep one of them",
        ),
        ("{spacing: [1], spacing.value: [2]}", "sweep: spacing and spacing.value set the same thing"),
        ("{packing.w2: [1], packing . w2: [2]}", "sweep: packing.w2 and packing . w2 set the same thing"),
        ("{a.0.r: [1], a.00.r: [2]}", "sweep: a.0.r and a.00.r set the same thing"),
        ("{name: [a, b]}", "sweep.name: cannot be swept"),
        ("{a: {from: 0, to: 1}}", "sweep.a: must have from, to, and either step or count (found the keys from, to)"),
        ("{a: {from: 0, to: 1, step: 1, count: 2}}", "sweep.a: must have from, to, and either step or count"),
        ("{a: {from: 0, to: 1, step: 0}}", "sweep.a: step must lead from 0 to 1 (found 0)"),
        ("{a: {from: 0, to: 1, step: -0.5}}", "sweep.a: step must lead from 0 to 1 (found -0.5)"),
        ("{a: {from: 0, to: .inf, step: 1}}", "sweep.a: to must be a finite number (found inf)"),
        ("{a: {from: 0, to: 1, count: 1}}", "sweep.a: count must be a whole number of 2 at least"),
        ("{a: {from: 0, to: 1e300, step: 1e-300}}", "values, more than 100,000: take larger steps"),
        ("{a: {from: 0, to: 1, count: 1000000000000}}", "sweep.a: makes 1,000,000,000,000 values, more than 100,000"),
        ("{sweep.a: [1]}", "sweep.sweep.a: cannot be swept"),
        (f"{{a: {list(range(400))}, b: {list(range(400))}}}", "makes 160,000 cases, more than 100,000"),
    ],
)
def test_a_wrong_sweep_is_told_with_its_line(sweep, message, case):
    with pytest.raises(CaseError, match=re.escape(message)):
        case_variants(case(sweep))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("parameters: {size: 0.2}\nspacing: size\nsweep: {parameters.sise: [0.1]}", "'sise': did you mean 'size'?"),
        (
            "parameters: {h: 0.2}\nspacing: h\nsweep: {parameters.radius: [0.1]}",
            "'radius' (those that are used: h): name it",
        ),
        (
            "parameters: {h: 0.2, r: 1, d: 2*r}\nspacing: h\nsweep: {parameters.r: [1, 2]}",
            "'r' (those that are used: h): name it",
        ),
        (
            "parameters: {h: 0.3}\nspacing: h\nsweep: {parameters.h: [0.2, 0.3], spacing: [0.3]}",
            "'h': name it in an expression",
        ),
        ("spacing: 0.1\nsweep: {parameters.h: [0.1]}", "'h': name it in an expression, or in braces in a text"),
    ],
)
def test_a_swept_parameter_that_no_key_uses_is_an_error(text, message, tmp_path):
    path = tmp_path / "plate.yaml"
    path.write_text(f"domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\n{text}\n")
    line = text.count("\n") + 2
    name = re.search(r"parameters\.\w+", text)[0]
    with pytest.raises(
        CaseError, match=re.escape(f"plate.yaml:{line}: sweep.{name}: no key uses a parameter {message}")
    ):
        case_variants(path)


@pytest.mark.parametrize(
    "text",
    [
        "parameters: {r: 1, d: 2*r, h: d/10}\nspacing: h\nsweep: {parameters.r: [1, 2]}",
        "spacing: h\nsweep: {parameters.h: [0.1, 0.2]}",
        "spacing: 1\nsweep: {parameters.h: [0.1, 0.2], spacing: [h, 2*h]}",
        "name: part-{n}\nspacing: 1\nsweep: {parameters.n: [1, 2]}",
    ],
)
def test_a_swept_parameter_may_be_used_anywhere(text, tmp_path):
    path = tmp_path / "plate.yaml"
    path.write_text(f"domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\n{text}\n")
    assert len(case_variants(path)) in (2, 4)


def test_an_option_for_a_parameter_that_no_key_uses_is_warned_of(case):
    path = case("", text="parameters: {h: 0.2}\n" + SMALL.replace("spacing: 0.4", "spacing: h"))
    path.write_text(path.read_text().replace("sweep: \n", ""))
    assert load_case(path, overrides=["parameters.h=0.3"]).warnings == load_case(path).warnings
    (told,) = set(load_case(path, overrides=["parameters.hh=0.3"]).warnings) - set(load_case(path).warnings)
    assert told == "overrides: no key uses a parameter 'hh': did you mean 'h'?"


def test_a_wrong_value_is_told_with_the_line_of_its_key(case):
    path = case("\n  packing.w2: [0.7,\n    -1]\n  packing.w1: [2]")
    good, bad = case_variants(path)
    assert load_case(path, variant=good).packing == {"w1": 2, "w2": 0.7}
    with pytest.raises(CaseError, match=re.escape("plate.yaml:7: packing.w2: ")):
        load_case(path, variant=bad)


@pytest.mark.parametrize(
    "options",
    [
        {"overrides": ["packing.w2=1"]},
        {"overrides": ["packing={}"]},
        {"overrides": ["packing.w2.a=1"]},
        {"seed": 3},
        {"time_limit": 5},
    ],
)
def test_no_option_sets_what_is_swept(options, case):
    with pytest.raises(CaseError, match=r"plate.yaml:6 sweeps (packing|limits)\.(w2|seed|seconds)"):
        case_variants(case("{packing.w2: [{}], packing.seed: [1], limits.seconds: [1]}"), **options)


def test_a_key_that_leads_nowhere_is_told_with_its_line(case):
    path = case("\n  packing.w1: [2]\n  domain.holes.3.circle.radius: [0.1]")
    (variant,) = case_variants(path)
    message = "plate.yaml:8: sweep.domain.holes.3.circle.radius: domain.holes: must be a list"
    with pytest.raises(CaseError, match=re.escape(message)):
        load_case(path, variant=variant)


def test_an_option_may_replace_or_remove_the_sweep(case):
    path = case("{packing.w2: [0.5, 0.7]}")
    assert labels(path, overrides=["sweep={packing.w1: [1]}"]) == ["-w1=1"]
    assert labels(path, overrides=["sweep=null"]) == [""]
    assert load_case(path, overrides=["sweep=null"]).name == "plate"


def test_a_sweep_belongs_to_its_file_and_not_to_those_that_extend_it(case, tmp_path):
    case("{packing.w2: [0.5, 0.7]}")
    (tmp_path / "child.yaml").write_text("base: plate.yaml\nspacing: 0.2\n")
    assert labels(tmp_path / "child.yaml") == [""]
    assert load_case(tmp_path / "child.yaml").spacing == 0.2


@pytest.mark.long
def test_a_single_run_of_a_sweep_points_to_batch(case):
    process = subprocess.run(
        [sys.executable, "-m", "bubblemesh", "run", str(case("{packing.w2: [0.5]}"))],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert process.returncode == 2
    assert "plate.yaml:6: sweep: makes several cases of this file: mesh them with bubblemesh batch" in process.stderr


def test_the_schema_knows_the_sweep():
    sweep = case_schema()["properties"]["sweep"]
    values = {"anyOf": [{"type": "array", "items": {}}, {"$ref": "#/$defs/RangeKeys"}]}
    assert {"type": "object", "additionalProperties": values} in sweep["anyOf"]
