"""Cases that extend others."""

import pytest

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError, FileError

BASE = """\
name: plate
parameters: {h: 0.1, k: 2}
domain: {outer: {rectangle: [0, 0, 1, 1]}, holes: [{circle: {center: [0.5, 0.5], radius: 0.2}}]}
spacing: "h*k"
method: accelerated
packing: {w1: 1.5, w2: 0.7}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "base.yaml").write_text(BASE)
    return tmp_path


def case_of(folder, text, **options):
    path = folder / "child.yaml"
    path.write_text(text)
    return load_case(path, **options)


def test_a_case_takes_over_what_it_does_not_say(folder):
    case = case_of(folder, "base: base.yaml\n")
    assert case.model_dump(exclude={"name"}) == load_case(folder / "base.yaml").model_dump(exclude={"name"})
    assert case.name == "child"


def test_mappings_join_their_keys_and_other_values_are_replaced(folder):
    case = case_of(folder, "base: base.yaml\nspacing: h\npacking: {w2: 0.6}\ndomain: {holes: []}\n")
    assert case.spacing.text == "h"
    assert case.packing == {"w1": 1.5, "w2": 0.6}
    assert case.domain.holes == ()
    assert case.parameters == {"h": 0.1, "k": 2}


def test_a_ring_is_replaced_as_a_whole(folder):
    case = case_of(folder, "base: base.yaml\ndomain: {outer: {circle: {center: [0, 0], radius: 2}}}\n")
    assert case.domain.outer.circle.radius == 2


def test_bases_form_a_chain_and_lie_beside_the_file_that_names_them(folder):
    (folder / "sub").mkdir()
    (folder / "sub/middle.yaml").write_text("base: ../base.yaml\nparameters: {h: 0.3}\n")
    case = case_of(folder, "base: sub/middle.yaml\nparameters: {k: 5}\n")
    assert case.parameters == {"h": 0.3, "k": 5}


def test_options_go_over_all_files(folder):
    case = case_of(folder, "base: base.yaml\n", overrides=["packing.w1=1"], seed=4)
    assert case.packing == {"w1": 1, "w2": 0.7, "seed": 4}


def test_a_problem_is_told_with_the_file_that_has_it(folder):
    (folder / "base.yaml").write_text(BASE.replace("w1: 1.5", "w1: -1"))
    with pytest.raises(CaseError, match=r"base\.yaml:6: packing\.w1"):
        case_of(folder, "base: base.yaml\npacking: {w2: 1}\n")
    (folder / "base.yaml").write_text(BASE)
    with pytest.raises(CaseError, match=r"child\.yaml:2: packing\.w2"):
        case_of(folder, "base: base.yaml\npacking: {w2: -1}\n")


@pytest.mark.parametrize("base", ["child.yaml", "loop.yaml"])
def test_a_case_that_extends_itself_is_refused(base, folder):
    (folder / "loop.yaml").write_text("base: child.yaml\n")
    with pytest.raises(CaseError, match=r"\.yaml:1: base: .*child\.yaml extends itself"):
        case_of(folder, f"base: {base}\n")


@pytest.mark.parametrize("base", ["3", "[a]", "''", "true"])
def test_a_base_that_is_no_file_name_is_refused(base, folder):
    with pytest.raises(CaseError, match=r"child\.yaml:1: base: must be the name of a case file"):
        case_of(folder, f"base: {base}\n")


def test_a_missing_base_is_a_file_error(folder):
    with pytest.raises(FileError, match=r"missing\.yaml"):
        case_of(folder, "base: missing.yaml\n")


def test_the_base_is_not_an_option(folder):
    with pytest.raises(CaseError, match=r"^overrides: the base"):
        case_of(folder, BASE, overrides=["base=base.yaml"])


def test_only_terms_of_data_name_files(folder):
    text = "spacing: {value: 1, field: {file: a.vtu}, raster: [{file: b.npy}, {file: /c.npy}]}\n"
    (folder / "sub").mkdir()
    (folder / "sub/base.yaml").write_text(BASE.replace('spacing: "h*k"\n', text))
    spacing = case_of(folder, "base: sub/base.yaml\nspacing: {image: null}\n").spacing
    assert spacing.field.file == str(folder / "sub/a.vtu")
    assert [raster.file for raster in spacing.raster] == [str(folder / "sub/b.npy"), "/c.npy"]
    assert spacing.value == 1
