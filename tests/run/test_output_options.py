"""Where results go: never over a file that is read for them."""

import json
from contextlib import chdir

import pytest
from commands import command, contents

from bubblemesh.batch.plan import BatchOptions, plan_cases
from bubblemesh.case import load_case
from bubblemesh.errors import FileError
from bubblemesh.run.output import OutputOptions, destination

SQUARE = "{rectangle: [0, 0, 1, 1]}"
READ = {
    "field": ("vtu", f"domain: {{outer: {SQUARE}}}\nspacing: {{field: {{file: one.vtu}}}}\n", "one.vtu"),
    "raster": (
        "nodes.npz",
        f"domain: {{outer: {SQUARE}}}\nspacing: {{raster: [{{file: one.nodes.npz}}]}}\n",
        "one.nodes.npz",
    ),
    "metric": ("mesh", f"domain: {{outer: {SQUARE}}}\nspacing: 0.5\nmetric: {{file: one.mesh}}\n", "one.mesh"),
    "metric beside": ("mesh", f"domain: {{outer: {SQUARE}}}\nspacing: 0.5\nmetric: {{file: one.meshb}}\n", "one.sol"),
    "geometry": ("vtu", "domain: {outer: {file: one.labels.json}}\nspacing: 0.5\n", "one.labels.json"),
}


def case_of(text, name, formats):
    return f"{text}name: {name}\noutput: {{formats: [{formats}]}}\n"


@pytest.mark.parametrize("kind", READ)
def test_no_file_that_a_case_reads_is_overwritten(kind, tmp_path):
    formats, text, file = READ[kind]
    (tmp_path / file).touch()
    with chdir(tmp_path):
        load = load_case("case.yaml", text=case_of(text, "one", formats))
        with pytest.raises(FileError, match=f"{file}: the results would overwrite this file: give another name by -o"):
            destination(load, "case.yaml", OutputOptions("."))
        assert destination(load, "case.yaml", OutputOptions("out")).name == "one"
        assert destination(load, "case.yaml", OutputOptions("two.vtu")).name == "two"


def test_neither_is_what_belongs_to_a_file_that_a_case_reads(tmp_path):
    (tmp_path / "one.pvd").write_text(
        '<VTKFile type="Collection"><Collection><DataSet timestep="0" file="two.vtu"/></Collection></VTKFile>'
    )
    (tmp_path / "two.vtu").touch()
    text = f"domain: {{outer: {SQUARE}}}\nspacing: {{field: {{file: one.pvd}}}}\n"
    with chdir(tmp_path):
        load = load_case("case.yaml", text=case_of(text, "two", "vtu"))
        with pytest.raises(FileError, match=r"two\.vtu: the results would overwrite"):
            destination(load, "case.yaml", OutputOptions("."))


@pytest.mark.usefixtures("workers_in_threads")
def test_a_run_leaves_its_field_as_it_was(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(case_of(READ["field"][1], "one", "vtu"))
    (tmp_path / "one.vtu").write_text("a field")
    before = contents(tmp_path)
    told = "one.vtu: the results would overwrite this file: give another name by -o\n"
    assert command("run", "case.yaml", "-o", ".") == (5, "", f"error: {told}")
    code, _, message = command("batch", "case.yaml", "-o", ".", "--jobs", "1")
    assert code == 5
    assert told.strip() in message
    assert {name: contents(tmp_path)[name] for name in before} == before


def test_no_case_of_a_batch_overwrites_what_another_one_reads(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text(case_of(f"domain: {{outer: {SQUARE}}}\nspacing: 0.5\n", "one", "vtu"))
    (tmp_path / "b.yaml").write_text(case_of(READ["field"][1], "two", "vtu"))
    (tmp_path / "one.vtu").touch()
    with pytest.raises(FileError, match=r"one\.vtu: the results of a\.yaml would overwrite this file$"):
        plan_cases(["a.yaml", "b.yaml"], BatchOptions(folder="."))
    assert len(plan_cases(["a.yaml", "b.yaml"], BatchOptions(folder="out"))) == 2


@pytest.mark.parametrize(
    ("names", "form", "told"),
    [
        (["Fibre", "fibre"], "inp", "inp: 'fibre' is called 'fibre_"),
        (["a b", "a_b"], "inp", "inp: 'a_b' is called 'a_b_"),
        (["Fibre", "fibre"], "msh", None),
        (["a b", "c"], "inp", None),
    ],
)
def test_names_that_other_groups_have_in_a_format_are_told(names, form, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    boxes = [f"{{name: {name}, ring: {{rectangle: [{k}.2, 0.5, {k}.8, 1]}}}}" for k, name in enumerate(names)]
    text = f"domain: {{outer: {{rectangle: [0, 0, 2, 2]}}, regions: [{', '.join(boxes)}]}}\nspacing: 0.3\n"
    (tmp_path / "a.yaml").write_text(text)
    code, out, _ = command("run", "a.yaml", "-o", f"a.{form}", "--json", "-q")
    warnings = json.loads(out)["warnings"]
    assert code == 0
    found = [text for text in warnings if "has this name in the format" in text]
    assert len(found) == (told is not None)
    assert all(text.startswith(told) for text in found)
