"""Parameters that depend on others, and texts that hold parameters."""

import pytest
from case_data import SQUARE

from bubblemesh.case import case_variants, load_case
from bubblemesh.errors import CaseError


def case_of(text, **options):
    return load_case("folder/plate.yaml", text=text, **options)


def message_of(text, **options):
    with pytest.raises(CaseError) as caught:
        case_of(text, **options)
    return str(caught.value)


def test_parameters_depend_on_parameters_in_any_order():
    case = case_of(SQUARE + "parameters: {area: pi*d**2/4, d: 2*r, r: 0.25}\n")
    assert case.parameters == {"area": pytest.approx(0.19634954), "d": 0.5, "r": 0.25}
    assert case_of(SQUARE + "parameters: {d: 2*r, r: 0.25}\n", overrides=["parameters.r=3"]).parameters["d"] == 6


def test_a_long_chain_of_parameters_is_no_danger():
    chain = ", ".join(f"a{k}: a{k + 1} + 1" for k in range(2000))
    assert case_of(SQUARE + f"parameters: {{{chain}, a2000: 0}}\n").parameters["a0"] == 2000


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ("{a: 2*b, b: c, c: a + 1}", "plate.yaml:8: parameters.a: depends on itself: a -> b -> c -> a: give one"),
        ("{a: a}", "parameters.a: depends on itself: a -> a"),
        ("{radius: 1, d: 2*radios}", "column 3: unknown name 'radios'; did you mean 'radius'?"),
        ("{a: x + 1}", "unknown name 'x'"),
        ("{a: 1/0}", "parameters.a: must be a finite number (found inf)"),
        ("{a: '0.5'}", "parameters.a: must be a number (found the text '0.5'; remove the quotes)"),
        ("{a: 'nan'}", "parameters.a: must be a number (found the text 'nan')"),
        ("{a: true, b: a}", "parameters.a: must be a number (found true)"),
        ("{a: (, b: ']'}", "parameters.b: must be a number, or an expression of other parameters: column 1"),
        ("{a: sqrt}", "'sqrt' is a function"),
    ],
)
def test_what_makes_no_parameter_is_told_with_its_line(parameters, message):
    assert message in message_of(SQUARE + f"parameters: {parameters}\n")


def test_texts_hold_parameters():
    text = """\
name: "plate-{d}"
domain:
  outer: {file: "part-{r}-{ n }.dxf", layer: "L{n}", feature: {name: "hole {d}"}, label: "rim-{third}"}
  holes: [{circle: {center: [0, 0], radius: 1}, label: "{{r}}"}]
spacing: {value: 0.1, labels: {"rim-{third}": 0.2}, scattered: {file: "{n}.csv"}}
output: {directory: "out-{n}"}
parameters: {r: 0.5, d: 2*r, n: 12, third: 0.1*3, big: 1e6}
"""
    case = case_of(text)
    assert case.name == "plate-1"
    outer = case.domain.outer
    assert (outer.file, outer.layer, outer.feature) == ("folder/part-0.5-12.dxf", ("L12",), {"name": "hole 1"})
    assert outer.label == "rim-0.3"
    assert case.domain.holes[0].label == "{r}"
    assert case.spacing.labels == {"rim-0.3": 0.2}
    assert case.spacing.scattered.file == "folder/12.csv"
    assert case.output.directory == "out-12"


@pytest.mark.parametrize(
    ("label", "message"),
    [
        ("{rr}", "unknown parameter 'rr'; did you mean 'r'? known: r; write {{ for a brace"),
        ("{2*r}", "unknown parameter '2*r'"),
        ("{}", "unknown parameter ''"),
        ("a{", "has a single brace"),
        ("}", "has a single brace"),
    ],
)
def test_braces_that_hold_no_parameter_are_told_with_their_line(label, message):
    text = SQUARE.replace("label: hole", f"label: '{label}'") + "parameters: {r: 1}\n"
    assert f"folder/plate.yaml:6: domain.holes.0.label: {message}" in message_of(text)


def test_expressions_name_parameters_without_braces():
    assert "a name in braces, which are for texts" in message_of(
        SQUARE.replace("0.1", "'{r}/2'") + "parameters: {r: 1}\n"
    )


def test_folders_and_files_with_braces_are_no_parameters(tmp_path):
    folder = tmp_path / "{r}"
    folder.mkdir()
    path = folder / "a{b.yaml"
    path.write_text('domain: {file: "{r}.csv"}\nspacing: 1\nparameters: {r: 2}\n')
    case = load_case(path)
    assert case.domain.file == str(folder / "2.csv")
    assert case.name == "a{b"


def test_a_swept_parameter_in_a_text_is_enough(tmp_path):
    path = tmp_path / "foil.yaml"
    path.write_text(
        'domain: {file: "foil{a}.dat"}\nspacing: 1\nparameters: {a: 0}\n'
        "sweep: {parameters.a: {from: -1, to: 1, step: 1}}\n"
    )
    cases = [load_case(path, variant=variant) for variant in case_variants(path)]
    assert [case.domain.file for case in cases] == [str(tmp_path / f"foil{k}.dat") for k in (-1, 0, 1)]
    assert [case.name for case in cases] == ["foil-a=-1", "foil-a=0", "foil-a=1"]
