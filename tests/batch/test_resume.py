"""A batch that goes on: what an earlier one has done stays, everything else is done anew."""

import json
import os
import re
import signal
import subprocess
import tempfile
import time
from contextlib import chdir, contextmanager
from pathlib import Path
from shutil import copytree

import pytest
from batch_cases import table_in
from batches import BAD, SMALL, Finished, batch, command, finished, follow, lines_of, results_in, rows_of

from bubblemesh.batch import BatchOptions
from bubblemesh.batch.folders import staging_prefix
from bubblemesh.batch.worker import BatchJob
from bubblemesh.case import overrides_of
from bubblemesh.errors import CaseError
from bubblemesh.messages import own_places

RING = "0 0\n1 0\n1 1\n0 1\n"
WITH_FILE = SMALL.replace("rectangle: [0, 0, 1, 1], label: wall", "file: ../data/ring.txt")


@pytest.fixture(scope="module")
def once_done(tmp_path_factory):
    """A folder with a batch of three cases done: one plain, one with a base, one with a file."""
    here = tmp_path_factory.mktemp("batch")
    with chdir(here), own_places():
        for folder in ("cases", "data"):
            Path(folder).mkdir()
        Path("data/ring.txt").write_text(RING)
        Path("cases/_base.yaml").write_text(SMALL)
        Path("cases/plain.yaml").write_text(SMALL)
        Path("cases/child.yaml").write_text("base: _base.yaml\nspacing: 0.5\n")
        Path("cases/file.yaml").write_text(WITH_FILE)
        rows_of("cases", folder="out")
    return here


@pytest.fixture
def done(once_done, tmp_path, monkeypatch):
    """The present folder: a copy of that with the batch."""
    copytree(once_done, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def anew(*paths, **options):
    """Names of the cases that a resumed batch does anew."""
    return [
        end.row.case
        for end in finished(*(paths or ["cases"]), folder="out", resume=True, **options)
        if not end.unchanged
    ]


def modified(folder):
    return {
        path.name: path.stat().st_mtime_ns for path in Path(folder).iterdir() if not path.name.startswith("summary")
    }


def stopped_after(count):
    """Listens to a batch, and interrupts it after so many cases."""
    ended = []

    def hear(event):
        if isinstance(event, Finished):
            ended.append(event.row.case)
            if len(ended) == count:
                raise KeyboardInterrupt

    return hear


@pytest.mark.parametrize("resume", [False, True])
def test_rows_of_an_earlier_batch_stay_until_their_cases_have_new_ones(done, resume):
    before = {row["case"]: row for row in lines_of(Path("out/summary.jsonl"))}
    coarser = overrides_of(["spacing=0.45"])
    with pytest.raises(KeyboardInterrupt):
        follow(stopped_after(1), "cases", folder="out", resume=resume, overrides=coarser)
    rows = {row["case"]: row for row in lines_of(Path("out/summary.jsonl"))}
    assert rows.keys() == before.keys()
    assert len(lines_of(Path("out/summary.jsonl"))) == len(table_in(Path("out"))) == len(before)
    changed = [case for case, row in rows.items() if row["inputs"] != before[case]["inputs"]]
    assert len(changed) == 1
    assert anew() == changed
    after = {row["case"]: row["inputs"] for row in lines_of(Path("out/summary.jsonl"))}
    assert after == {case: row["inputs"] for case, row in before.items()}


def test_a_batch_that_is_killed_may_leave_two_rows_of_a_case_of_which_the_true_one_counts(done):
    rows = Path("out/summary.jsonl").read_text()
    Path("out/summary.jsonl").write_text(re.sub('"inputs": "[0-9a-f]', '"inputs": "x', rows) + rows)
    assert anew(workers=lambda count: pytest.fail("nothing to do")) == []
    assert len(lines_of(Path("out/summary.jsonl"))) == 3


def test_a_batch_that_ends_has_the_rows_of_its_own_cases_alone(done):
    rows_of("cases/plain.yaml", folder="out")
    assert [row["case"] for row in lines_of(Path("out/summary.jsonl"))] == ["plain"]
    assert [row["case"] for row in table_in(Path("out"))] == ["plain"]


@pytest.mark.parametrize("of_command", [True, False])
@pytest.mark.parametrize("option", [{"method": "nope"}, {"seed": -1}])
def test_an_option_that_is_wrong_for_all_cases_is_refused_before_anything_is_written(option, of_command, done):
    before = Path("out/summary.jsonl").read_bytes()
    (name,) = option
    start = "--" if of_command else r"(load_case\(\): )?"
    with pytest.raises(CaseError, match=f"^{start}{name}: "):
        rows_of("cases", folder="out", overrides=overrides_of(**option, of_command=of_command))
    assert Path("out/summary.jsonl").read_bytes() == before


@pytest.mark.parametrize("broken", ["domain: [\n", "domain: {outer: {circle: 1}}\nspacing: -1\n"])
def test_cases_with_other_errors_do_not_make_a_wrong_option_right(broken, done):
    Path("cases/broken.yaml").write_text(broken)
    rows_of("cases", folder="out")
    before = Path("out/summary.jsonl").read_bytes()
    with pytest.raises(CaseError, match=r"^--set spacng: .*unknown key"):
        rows_of("cases", folder="out", overrides=overrides_of(["spacng=3"], of_command=True))
    assert Path("out/summary.jsonl").read_bytes() == before


def test_an_option_that_suits_one_case_alone_is_wrong_in_the_rows_of_the_others(done):
    Path("cases/plain.yaml").write_text(SMALL.replace("}}", "}, holes: [{circle: {center: [0.5, 0.5], radius: 0.1}}]}"))
    overrides = overrides_of(["domain.holes.0.circle.radius=0.2"], of_command=True)
    rows = rows_of("cases", folder="out", overrides=overrides)
    assert {row.case: row.exit_code for row in rows} == {"child": 2, "file": 2, "plain": 0}


def test_nothing_is_done_twice_if_nothing_has_changed(done):
    before, rows = modified("out"), Path("out/summary.jsonl").read_bytes()
    assert anew(workers=lambda count: pytest.fail("nothing to do")) == []
    assert modified("out") == before
    assert sorted(Path("out/summary.jsonl").read_bytes().splitlines()) == sorted(rows.splitlines())


def test_without_resume_everything_is_done_again(done):
    Path("cases/plain.yaml").unlink()
    assert [end.unchanged for end in finished("cases", folder="out")] == [False, False]
    assert [line["case"] for line in lines_of(Path("out/summary.jsonl"))].count("plain") == 0


@pytest.mark.long
@pytest.mark.parametrize(
    ("file", "text", "expected"),
    [
        ("cases/plain.yaml", SMALL.replace("0.4", "0.3"), ["plain"]),
        ("cases/plain.yaml", SMALL + "# only a remark\n", []),
        ("cases/_base.yaml", SMALL.replace("iterations: 5", "iterations: 6"), ["child"]),
        ("cases/_base.yaml", SMALL.replace("0.4", "0.3"), []),  # what the child replaces
        ("data/ring.txt", RING.replace("1 1", "1.5 1"), ["file"]),
    ],
)
def test_a_change_of_a_case_its_base_or_its_file_is_noticed(file, text, expected, done):
    Path(file).write_text(text)
    assert anew() == expected
    assert anew() == []


@pytest.mark.long
@pytest.mark.parametrize(
    "options",
    [
        {"overrides": overrides_of(seed=3)},
        {"overrides": overrides_of(["spacing=0.3"])},
        {"overrides": overrides_of(method="fnpbs")},
        {"page": True},
    ],
)
def test_a_change_of_an_option_is_noticed(options, done):
    assert anew(**options) == ["child", "file", "plain"]
    assert anew(**options) == []


@pytest.mark.parametrize(
    "key", ["partition=2", "open=wall", "depth=10", "depth={of: 10, over: cell}", "order=2", "formats=[msh4]"]
)
def test_a_change_of_what_is_in_the_files_is_noticed(key, done):
    options = {"overrides": overrides_of([f"output.{key}"])}
    assert anew("cases/plain.yaml", **options) == ["plain"]
    assert anew("cases/plain.yaml", **options) == []


def test_a_change_of_where_files_go_is_none(done):
    assert anew("cases/plain.yaml", overrides=overrides_of(["output.directory=elsewhere"])) == []


@pytest.mark.long
def test_a_page_more_is_made_and_one_less_is_no_change(done):
    assert anew("cases/plain.yaml", page=True) == ["plain"]
    assert anew("cases/plain.yaml") == []
    assert anew() == []
    assert anew(page=True) == ["child", "file"]
    Path("out/plain.html").write_text("something else")
    assert anew(page=True) == ["plain"]


def test_a_time_limit_is_no_input_of_what_was_finished_in_time(done):
    assert anew(overrides=overrides_of(["limits.seconds=60"])) == []
    Path("cases/late.yaml").write_text(SMALL + "limits: {seconds: 1.0e-9}\n")
    assert anew() == ["late"]
    assert anew() == ["late"]
    assert anew(overrides=overrides_of(["limits.seconds=60"])) == ["late"]
    assert anew() == []


def test_another_version_is_noticed(done, monkeypatch):
    monkeypatch.setattr(BatchJob.__init__, "__defaults__", ("0.0.9",))
    monkeypatch.setattr("bubblemesh.batch.worker.__version__", "0.0.9")
    assert anew() == ["child", "file", "plain"]
    assert anew() == []


@pytest.mark.parametrize("damage", [Path.unlink, lambda path: path.write_bytes(path.read_bytes()[:-1] + b"?")])
def test_a_result_that_is_gone_or_not_as_written_is_made_again(damage, done):
    before = results_in(done / "out")
    damage(Path("out/plain.msh"))
    assert anew() == ["plain"]
    assert results_in(done / "out") == before


def test_it_does_not_matter_where_one_calls_from_or_where_the_folder_lies(done, monkeypatch):
    Path("project").mkdir()
    for folder in ("cases", "data", "out"):
        Path(folder).rename(f"project/{folder}")
    monkeypatch.chdir("project/data")
    ends = finished("../cases", folder="../out", resume=True)
    assert [end.unchanged for end in ends] == [True] * 3


def test_failed_cases_are_tried_again_but_not_those_that_only_miss_a_requirement(done):
    Path("cases/bad.yaml").write_text(BAD)
    Path("cases/poor.yaml").write_text(SMALL + "require: {quality_mean: 1}\n")
    rows = rows_of("cases", folder="out")
    assert [(row.case, row.exit_code) for row in rows if row.exit_code] == [("bad", 3), ("poor", 4)]
    ends = {end.row.case: end for end in finished("cases", folder="out", resume=True)}
    assert (ends["bad"].unchanged, ends["bad"].row.exit_code) == (False, 3)
    assert (ends["poor"].unchanged, ends["poor"].row.exit_code) == (True, 4)
    Path("cases/bad.yaml").write_text(SMALL)
    assert anew() == ["bad"]
    cases = [line["case"] for line in lines_of(Path("out/summary.jsonl"))]
    assert sorted(cases) == ["bad", "child", "file", "plain", "poor"]


def test_a_case_that_cannot_be_read_any_more_has_one_row(done):
    Path("cases/plain.yaml").write_text("spacing: [\n")
    Path("cases/child.yaml").write_text("base: _base.yaml\nsweep: 3\n")
    assert anew() == ["child", "plain"]
    rows = {line["case"]: line["exit_code"] for line in lines_of(Path("out/summary.jsonl"))}
    assert rows == {"file": 0, "child": 2, "plain": 2}
    assert len(lines_of(Path("out/summary.jsonl"))) == 3


def test_rows_of_other_cases_stay(done):
    Path("more.yaml").write_text(SMALL)
    assert anew("more.yaml") == ["more"]
    assert anew("cases", "more.yaml") == []
    assert {line["case"] for line in lines_of(Path("out/summary.jsonl"))} == {"child", "file", "plain", "more"}


def test_rows_of_other_cases_stay_even_if_these_cannot_be_read(done):
    Path("broken.yaml").write_text("spacing: [\n")
    Path("strange.yaml").write_text("domain: {}\n")
    others = ["broken.yaml", "strange.yaml"]
    rows_of("cases", *others, folder="out")
    assert anew() == []
    assert anew("strange.yaml") == ["strange"]
    rows = [(line["source"], line["exit_code"]) for line in lines_of(Path("out/summary.jsonl")) if line["exit_code"]]
    assert sorted(rows) == [(name, 2) for name in others]
    Path("broken.yaml").write_text(SMALL)
    assert anew("broken.yaml") == ["broken"]
    assert [line["case"] for line in lines_of(Path("out/summary.jsonl"))].count("broken") == 1


@pytest.mark.long
@pytest.mark.parametrize(
    "tear",
    [
        lambda content: content[:-1],
        lambda content: content[:-20],
        lambda content: content[:-20] + bytes(20),
        lambda content: content + b'{"case": "x"}\n',
        lambda content: content + b"\xff\xfe[1, 2]\nnull\n",
        lambda content: content.replace(b'"files": {', b'"files": [], "x": {'),
        lambda content: content.replace(b'"sweep": {}', b'"sweep": null', 1),
        lambda content: content.replace(b'"nodes": ', b'"nodes": "9", "x": ', 1),
        lambda content: content.replace(b'"quality_mean": ', b'"quality_mean": null, "x": ', 1),
        lambda content: content.replace(b'"warnings": [', b'"warnings": 3, "x": [', 1),
        lambda content: content.replace(b'"folder": ".", ', b'"folder": {}, ', 1),
    ],
)
def test_a_torn_line_is_mended(tear, done):
    path = Path("out/summary.jsonl")
    rows = path.read_bytes()
    path.write_bytes(tear(rows))
    assert len(anew()) <= 3
    assert sorted(line["case"] for line in lines_of(path)) == ["child", "file", "plain"]
    assert len(Path("out/summary.csv").read_text().splitlines()) == 4


def test_a_table_that_lost_a_row_has_it_again(done):
    table = Path("out/summary.csv").read_text()
    Path("out/summary.csv").write_text(table[:-30])
    assert anew() == []
    assert sorted(Path("out/summary.csv").read_text().splitlines()) == sorted(table.splitlines())


def left_behind(summary, shard=(1, 1)):
    """Make a staging folder among the results, as a batch with this summary does when it is killed."""
    folder = Path("out", f"{staging_prefix(Path('out'), BatchOptions(folder=summary, shard=shard))}xyz")
    folder.mkdir(parents=True)
    (folder / "plain.msh").write_text("half of a mesh")
    return folder.name


def hidden(folder):
    return {path.name for path in Path(folder).glob(".*")}


def test_staging_folders_of_a_killed_batch_are_removed(done):
    whole, first, second = (left_behind("out", shard) for shard in ((1, 1), (1, 2), (2, 2)))
    Path("out/.other").mkdir()
    rows_of("cases", folder="out", resume=True, shard=(1, 2))  # other shards may be at work
    assert hidden("out") == {whole, second, ".other"}
    assert first != second
    assert anew() == []
    assert hidden("out") == {".other"}


def test_staging_folders_of_a_batch_with_another_summary_stay(done):
    Path("cases/own.yaml").write_text(SMALL.replace("formats", "directory: ../out, formats"))
    elsewhere, _ = left_behind("elsewhere"), left_behind(".")
    rows_of("cases/own.yaml")
    assert Path("out/own.msh").exists()
    assert hidden("out") == {elsewhere}


def test_staging_folders_are_known_again_where_the_whole_lies_elsewhere(done):
    name = left_behind("out")
    Path("out").rename("moved")
    Path("link").symlink_to("moved")
    assert staging_prefix(Path("moved"), BatchOptions(folder="link")) in name


@pytest.mark.parametrize("shard", [(1, 1), (1, 2)])
def test_an_interrupt_in_the_midst_of_writing_leaves_no_staging_folder(shard, done, monkeypatch):
    @contextmanager
    def interrupted(folder, prefix):
        made.append(Path(tempfile.mkdtemp(prefix=prefix, dir=folder)))
        raise KeyboardInterrupt
        yield

    made = []
    monkeypatch.setattr("bubblemesh.batch.folders.transaction", interrupted)
    with pytest.raises(KeyboardInterrupt):
        rows_of("cases", folder="out", shard=shard)
    assert made
    assert not list(Path("out").glob(".*"))


def test_more_shards_than_before_take_over_what_is_done(done):
    rows_of("cases", folder="parts", shard=(1, 2))
    rows_of("cases", folder="parts", shard=(2, 2))
    for index in (1, 2, 3):
        (end,) = finished("cases", folder="parts", shard=(index, 3), resume=True)
        assert end.unchanged
        assert [line["case"] for line in lines_of(Path(f"parts/summary-{index}-of-3.jsonl"))] == [end.row.case]


# Ends that nobody asked for


def write_cases(folder):
    cases = folder / "cases"
    cases.mkdir()
    (cases / "a.yaml").write_text(SMALL + f"sweep: {{packing.seed: {list(range(16))}}}\n")
    return cases


def workers_of(process):
    """Ids of the worker processes."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return [
        int(pid)
        for pid in children.read_text().split()
        if b"workers.serving" in Path(f"/proc/{pid}/cmdline").read_bytes()
    ]


def rows_now(path):
    return path.read_bytes().count(b"\n") if path.exists() else 0


def started(folder, rows, *options):
    """A batch that has so many rows, and its workers."""
    temporary = folder / "temporary"
    temporary.mkdir(exist_ok=True)
    with (folder / "log.txt").open("w") as log:
        process = subprocess.Popen(
            command("cases", "-o", "out", "--jobs", "2", *options),
            cwd=folder,
            stderr=log,
            env={**os.environ, "TMPDIR": str(temporary)},
        )
    end = time.monotonic() + 60
    while rows_now(folder / "out/summary.jsonl") < rows:
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.002)
    return process, workers_of(process)


def gone(pids):
    """Whether all these processes end soon."""
    for _ in range(500):
        if not any(
            Path(f"/proc/{pid}/stat").exists() and " Z " not in Path(f"/proc/{pid}/stat").read_text() for pid in pids
        ):
            return True
        time.sleep(0.02)
    return False


needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are found by /proc")


@pytest.mark.long
@needs_proc
def test_a_batch_killed_again_and_again_ends_with_the_bytes_of_one_that_was_not(tmp_path):
    write_cases(tmp_path)
    for rows in (2, 8):
        process, workers = started(tmp_path, rows, "--resume")
        process.kill()
        process.wait()
        assert gone(workers)
        assert len(workers) == 2
        assert not any((tmp_path / "temporary").iterdir())
        whole = (tmp_path / "out/summary.jsonl").read_bytes().rpartition(b"\n")[0].splitlines()
        for row in map(json.loads, whole):  # a row is a promise
            assert all((tmp_path / "out" / name).exists() for name in row["files"])
    process = batch("cases", "-o", "out", "--jobs", "2", "--resume", folder=tmp_path)
    assert process.returncode == 0, process.stderr
    assert process.stderr.count(", unchanged\n") >= 8
    assert batch("cases", "-o", "whole", "--jobs", "2", "-q", folder=tmp_path).returncode == 0
    assert results_in(tmp_path / "out") == results_in(tmp_path / "whole")
    cases = [sorted(line["case"] for line in lines_of(tmp_path / name / "summary.jsonl")) for name in ("out", "whole")]
    assert cases[0] == cases[1]
    assert len(cases[0]) == len(set(cases[0])) == 16


@pytest.mark.long
@needs_proc
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_batch_ends_with_130_and_whole_rows_and_no_process_left(number, tmp_path):
    write_cases(tmp_path)
    process, workers = started(tmp_path, 3)
    if number == signal.SIGINT:  # as the terminal does it: to all processes
        for pid in workers:
            os.kill(pid, number)
    process.send_signal(number)
    assert process.wait(timeout=20) == 130
    assert gone(workers)
    assert not any((tmp_path / "temporary").iterdir())
    log = (tmp_path / "log.txt").read_text()
    assert "error: interrupted" in log
    assert "Traceback" not in log
    rows = lines_of(tmp_path / "out/summary.jsonl")
    assert 3 <= len(rows) < 16
    ((told, left),) = re.findall(r" (\d+) done, (\d+) left for --resume", log)
    assert int(told) + int(left) == 16
    assert len(rows) - 1 <= int(told) <= len(rows)  # the last row may be written, and not told yet
    assert not [path for path in (tmp_path / "out").iterdir() if path.name.startswith(".")]
    assert len((tmp_path / "out/summary.csv").read_text().splitlines()) == len(rows) + 1
