import json
import re

import pytest
from batches import Begun, Finished, batch, follow
from batches import rows_of as rows_of_batch

CASE = "domain: {{outer: {{rectangle: [0, 0, 1, 1]}}}}\nspacing: {}\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "cases").mkdir()
    for name, spacing in (("a", 0.2), ("b", 0.3), ("wrong", -1)):
        (tmp_path / "cases" / f"{name}.yaml").write_text(CASE.format(spacing))
    return tmp_path


def rows_of(folder):
    return [json.loads(line) for line in (folder / "out/summary.jsonl").read_text().splitlines()]


@pytest.mark.long
def test_index_links_to_the_page_of_each_case_that_has_one(folder):
    assert batch("cases", "-o", "out", "--report", folder=folder).returncode == 2
    text = (folder / "out/index.html").read_text()
    assert re.findall(r'href="\./([^"]*)"', text) == ["a.html", "b.html"]
    assert (folder / "out/a.html").exists()
    assert "wrong" in text
    assert "greater than 0" in text


@pytest.mark.long
@pytest.mark.parametrize(("options", "pages"), [([], ["a.html"]), (["--no-report"], [])])
def test_without_the_option_there_are_the_pages_of_cases_that_ask_for_one(options, pages, folder):
    (folder / "cases/a.yaml").write_text(CASE.format(0.3) + "output: {report: true}\n")
    batch("cases", "-o", "out", *options, folder=folder)
    assert [path.name for path in (folder / "out").glob("*.html")] == pages


@pytest.mark.long
@pytest.mark.parametrize(("name", "options"), [("index", []), ("index-1-of-2", ["--shard", "1/2"])])
def test_no_page_of_a_case_is_that_of_the_batch(name, options, folder):
    (folder / f"cases/{name}.yaml").write_text(CASE.format(0.3))
    process = batch("cases", "-o", "out", "--report", *options, folder=folder)
    assert process.returncode == 2
    assert f"{name}.yaml: its page would be that of the batch" in process.stderr
    assert not (folder / "out").exists()


def index_of(folder):
    """Cases of the index, and the pages that it links to."""
    text = (folder / "index.html").read_text()
    return re.findall(r'<th[^>]*scope="row"[^>]*data-value="([^"]*)"', text), re.findall(r'href="\./([^"]*)"', text)


@pytest.mark.long
def test_index_has_all_rows_of_the_summary(folder, monkeypatch):
    monkeypatch.chdir(folder)
    rows_of_batch("cases", folder="out", page=True)
    rows_of_batch("cases/b.yaml", folder="out", page=True, resume=True)
    assert index_of(folder / "out") == (["a", "wrong", "b"], ["a.html", "b.html"])


def test_index_of_an_interrupted_batch_has_the_rows_until_then(folder, monkeypatch):
    monkeypatch.chdir(folder)
    done = []

    def interrupt(event):
        if isinstance(event, Finished):
            done.append(event.row.case)
        if len(done) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        follow(interrupt, "cases", folder="out", page=True)
    assert sorted(index_of(folder / "out")[0]) == sorted(done)


def test_index_links_to_pages_wherever_they_are_and_only_to_those(folder, monkeypatch):
    monkeypatch.chdir(folder)
    (folder / "cases/b.yaml").write_text(CASE.format(0.3) + "output: {directory: ../b c}\n")
    rows_of_batch("cases", page=True)
    assert index_of(folder) == (["a", "b", "wrong"], ["a.html", "b%20c/b.html"])
    (folder / "a.html").unlink()
    rows_of_batch("cases/b.yaml", page=True, resume=True)
    assert index_of(folder) == (["a", "wrong", "b"], ["b%20c/b.html"])


def test_what_ends_a_batch_is_told_even_if_the_index_cannot_be_written(folder, monkeypatch):
    monkeypatch.chdir(folder)

    def end(event):
        assert isinstance(event, Begun)
        (folder / "out/index.html").mkdir()
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        follow(end, "cases", folder="out", page=True)
    assert (folder / "out/summary.jsonl").exists()


@pytest.mark.long
def test_time_limit_of_a_case_is_its_row(folder):
    # The time kept for finishing 130,000 nodes is longer than the limit: packing ends at its first step.
    (folder / "cases/a.yaml").write_text(CASE.format(0.003))
    process = batch("cases/a.yaml", "-o", "out", "--time-limit", "3.5", folder=folder)
    assert process.returncode == 6
    (row,) = rows_of(folder)
    assert "time limit" in row["error"]
    assert row["nodes"] > 100_000
    assert (folder / "out/a.msh").exists()


@pytest.mark.long
def test_data_of_a_spacing_are_inputs_that_resume_looks_at(folder):
    (folder / "cases/a.yaml").write_text(CASE.format("{scattered: {file: sizes.csv}}"))
    (folder / "cases/sizes.csv").write_text("0,0,0.2\n1,0,0.2\n0,1,0.3\n")
    assert batch("cases/a.yaml", "-o", "out", folder=folder).returncode == 0
    (before,) = rows_of(folder)
    assert batch("cases/a.yaml", "-o", "out", "--resume", folder=folder).returncode == 0
    assert rows_of(folder) == [before]
    (folder / "cases/sizes.csv").write_text("0,0,0.1\n1,0,0.1\n0,1,0.1\n")
    assert batch("cases/a.yaml", "-o", "out", "--resume", folder=folder).returncode == 0
    (after,) = rows_of(folder)
    assert after["nodes"] > 1.5 * before["nodes"]
