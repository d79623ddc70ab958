"""Limits on time and memory hold in every stage, and leave nothing behind."""

import gc
import importlib
import subprocess
import sys
import threading
from dataclasses import replace
from functools import partial
from itertools import count
from time import perf_counter, process_time
from typing import get_args

import numpy as np
import pytest
import shapely
from commands import command

from bubblemesh.api import adapt
from bubblemesh.batch.plan import BatchOptions, plan_cases
from bubblemesh.batch.worker import mesh_job
from bubblemesh.case import load_case, overrides_of
from bubblemesh.errors import FileError, LimitError
from bubblemesh.process import memory_limit, watchdog
from bubblemesh.process.limits import within
from bubblemesh.process.stopwatch import Stopwatch
from bubblemesh.process.watchdog import Late, enter, settle, time_left
from bubblemesh.run.pipeline import mesh_case

SQUARE = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.2\n"
PLENTY = 60.0  # seconds that no test takes


def in_time(call, seconds=None, megabytes=None):
    return within(call, seconds, megabytes, perf_counter())


def spin(*_, seconds=PLENTY, **__):
    """Be busy as Python is, in an endless loop without a clock of its own."""
    end = perf_counter() + seconds
    for _ in count():
        if perf_counter() > end:
            return


@pytest.fixture(autouse=True)
def _nobody_watches_the_collection_of_garbage():
    """Hypothesis has a function called then, in which an exception of a thread may land and be lost."""
    before = gc.callbacks[:]
    gc.callbacks.clear()
    yield
    gc.callbacks[:] = before


@pytest.fixture
def strict(monkeypatch):
    """No grace after the time is up."""
    for name in ("GRACE", "GRACE_SHARE", "SHORT_GRACE", "SHORT_GRACE_SHARE"):
        monkeypatch.setattr(watchdog, name, 0.0)


@pytest.mark.parametrize("stage", watchdog.STAGES)
def test_a_late_run_ends_with_the_name_of_its_stage_and_what_to_do(stage, strict):
    def run():
        enter(stage)
        spin()

    begun = perf_counter()
    with pytest.raises(LimitError) as caught:
        in_time(run, 0.05)
    assert perf_counter() - begun < PLENTY / 4
    doing, advice, _ = watchdog.STAGES[stage]
    assert str(caught.value) == (
        f"limits.seconds: the time limit of 0.05 s was over while {doing}: {advice}, or raise the limit"
    )
    assert caught.value.exit_code == 6
    assert time_left() == np.inf


def test_after_a_stage_within_another_one_a_late_run_names_the_outer_one(strict):
    def run():
        stopwatch = Stopwatch()
        with stopwatch.stage("spacing"):
            with stopwatch.stage("metric"):
                pass
            spin()

    with pytest.raises(LimitError, match=watchdog.STAGES["spacing"][0]):
        in_time(run, 0.05)


def test_every_stage_has_words():
    assert get_args(watchdog.Stage) == tuple(watchdog.STAGES)


@pytest.mark.parametrize("stage", watchdog.STAGES)
def test_only_a_packing_that_has_begun_may_end_later(stage, monkeypatch):
    monkeypatch.setattr(watchdog, "GRACE", PLENTY)
    monkeypatch.setattr(watchdog, "SHORT_GRACE", 0.0)

    def run():
        enter(stage)
        spin(seconds=0.3)

    if stage in ("reading", "geometry", "estimate", "spacing", "metric", "layers"):
        with pytest.raises(LimitError, match=watchdog.STAGES[stage][0]):
            in_time(run, 0.05)
    else:
        in_time(run, 0.05)


def test_a_run_in_any_thread_ends_and_no_other_thread_does(strict):
    found = []

    def run():
        try:
            in_time(spin, 0.05)
        except LimitError as error:
            found.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    spin(seconds=0.2)
    thread.join(PLENTY)
    assert len(found) == 1


def test_nothing_is_raised_after_the_end(strict):
    """Runs end at all times around their limit; one that is late is told so, and nobody else hears of it."""
    outcomes = set()
    for attempt in range(150):
        try:
            in_time(partial(spin, seconds=0.001 + 1e-4 * attempt), 0.004)
            outcomes.add("done")
        except LimitError:
            outcomes.add("late")
        spin(seconds=5e-4)
    spin(seconds=0.05)
    assert outcomes == {"done", "late"}
    assert "bubblemesh-time-limit" not in {thread.name for thread in threading.enumerate() if thread.is_alive()}


def test_an_error_of_the_run_goes_through(strict):
    def run():
        raise FileError("no such file")

    with pytest.raises(FileError, match="no such file"):
        in_time(run, 1, 1e6)


def test_an_exception_that_is_swallowed_is_raised_anew(strict, monkeypatch):
    monkeypatch.setattr(watchdog, "AGAIN", 0.3)
    swallowed = []

    def run():
        try:
            spin()
        except Late:
            swallowed.append(1)
        spin()

    with pytest.raises(LimitError):
        in_time(run, 0.5)
    assert swallowed == [1]


@pytest.fixture
def _nothing_kept_from_standard_error():
    watchdog._keep_from_standard_error.cache_clear()
    yield
    watchdog._keep_from_standard_error.cache_clear()


@pytest.mark.usefixtures("_nothing_kept_from_standard_error")
def test_an_exception_that_python_ignores_is_raised_anew_and_not_told(strict, monkeypatch):
    class Slow:
        def __del__(self):
            spin()  # ended by an exception that Python cannot raise from here

    told = []
    monkeypatch.setattr(sys, "unraisablehook", told.append)
    monkeypatch.setattr(watchdog, "AGAIN", 0.3)

    def run():
        Slow()
        spin()

    with pytest.raises(LimitError):
        in_time(run, 0.5)
    assert not told
    Broken()
    assert [one.exc_type for one in told] == [ZeroDivisionError]


class Broken:
    def __del__(self):
        1 / 0  # noqa: B018


def test_a_module_is_loaded_to_its_end(strict, tmp_path, monkeypatch):
    (tmp_path / "slow_module.py").write_text(
        "from time import sleep\nfor _ in range(1000):\n    sleep(0.001)\nwhole = 1\n"
    )
    monkeypatch.syspath_prepend(tmp_path)

    def run():
        importlib.import_module("slow_module")
        spin()

    with pytest.raises(LimitError):
        in_time(run, 0.5)
    assert sys.modules.pop("slow_module").whole == 1


def test_what_must_not_stop_half_way_does_not(strict):
    def run():
        settle()
        spin(seconds=0.5)
        return "whole"

    assert in_time(run, 0.2) == "whole"


def test_the_limits_of_the_outer_call_hold_inside():
    def run():
        return in_time(time_left, 1e-9)

    assert 50 < in_time(run, 60) <= 60
    assert in_time(run) == np.inf


STANDS_FOR = {
    "geometry": "bubblemesh.problem.prepare.case_domain",
    "spacing": "bubblemesh.problem.fitting.surveyed",
    "placement": "bubblemesh.run.packing.tabulated",
    "quality": "bubblemesh.run.measurement.require_conforming",
    "writing": "bubblemesh.meshfiles.writing.json_text",
}


@pytest.mark.long
@pytest.mark.parametrize("stage", STANDS_FOR)
def test_every_stage_of_a_run_is_watched(stage, strict, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(SQUARE)
    assert command("run", "case.yaml", "-o", "first/")[0] == 0  # whatever is to be loaded is
    monkeypatch.setattr(STANDS_FOR[stage], spin)
    begun = perf_counter()
    code, _, message = command("run", "case.yaml", "-q", "-o", "out/", "--time-limit", "1.5")
    assert perf_counter() - begun < PLENTY / 4
    assert code == 6
    assert (
        f"error: case.yaml: limits.seconds: the time limit of 1.5 s was over while {watchdog.STAGES[stage][0]}"
        in message
    )
    assert not (tmp_path / "out").exists()
    if stage in ("geometry", "spacing"):
        assert command("check", "case.yaml", "--time-limit", "1.5") == (6, "", message)
    (entry,) = plan_cases(["case.yaml"], BatchOptions(overrides_of(time_limit=1.5), "batch"))
    outcome = mesh_job(entry.job(), lambda note: None)
    assert (outcome.row.exit_code, outcome.files) == (6, {})
    assert outcome.row.error.startswith("case.yaml: limits.seconds: the time limit of 1.5 s was over")


def test_the_estimate_beside_a_picture_is_watched(strict, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(SQUARE)
    # As the end of a file does:
    monkeypatch.setattr("bubblemesh.run.preview.draw_preview", lambda problem, picture: settle())
    monkeypatch.setattr("bubblemesh.run.preview.estimate", partial(spin, seconds=5.0))
    code, _, message = command("check", "case.yaml", "--plot", "a.png", "--time-limit", "0.3")
    assert (code, "the time limit of 0.3 s was over" in message) == (6, True)


def test_reading_a_solution_is_watched(strict, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(SQUARE + "limits: {seconds: 1.5}\n")
    monkeypatch.setattr("bubblemesh.meshfiles.fields.read_nodal_field", spin)
    told = f"limits.seconds: the time limit of 1.5 s was over while {watchdog.STAGES['estimate'][0]}"
    code, _, message = command("adapt", "case.yaml", "--solution", "solution.vtu", "-o", "out/")
    assert (code, message.startswith(f"error: case.yaml: {told}")) == (6, True)
    with pytest.raises(LimitError, match=told):
        adapt(load_case("case.yaml"), "solution.vtu")


@pytest.mark.parametrize("limit", ["", "limits: {seconds: 0.2}\n"])
def test_reading_is_watched(limit, strict, monkeypatch):
    monkeypatch.setattr("bubblemesh.case.load._check_names" if limit else "bubblemesh.case.load.merged", spin)
    with pytest.raises(LimitError, match=r"^case.yaml: limits.seconds: .* while reading the case"):
        load_case("case.yaml", text=SQUARE + limit, time_limit=None if limit else 0.2)


def test_the_time_of_reading_counts():
    case = load_case("case.yaml", text=SQUARE, time_limit=2)
    late = case.loaded(replace(case.origin, seconds=5.0), ())
    with pytest.raises(LimitError, match="while reading the case"):
        mesh_case(late)


needs_memory_limit = pytest.mark.skipif(not memory_limit.memory_can_be_limited(), reason="the system has no such limit")


def mapped_limit():
    import resource

    return resource.getrlimit(resource.RLIMIT_DATA)


@needs_memory_limit
@pytest.mark.parametrize(
    "need",
    [
        lambda: np.ones(10**9),
        lambda: bytearray(8 * 10**9),
        lambda: [[number] * 10**5 for number in range(10**5)],
    ],
)
def test_too_much_memory_is_an_error_with_the_limit(need):
    before = mapped_limit()
    with pytest.raises(LimitError, match=r"^limits.max_memory_mb: more than the limit of \d+ MB is needed: ") as caught:
        in_time(need, None, megabytes_held() + 200)
    assert caught.value.exit_code == 6
    assert mapped_limit() == before
    assert np.ones(10**8, bool).all()


@needs_memory_limit
@pytest.mark.parametrize(
    ("error", "about_memory"),
    [
        (shapely.errors.GEOSException("std::bad_alloc"), True),
        (ImportError("libblas.so: Cannot allocate memory"), True),
        (FileError("bad_alloc.yaml: there is no such file"), False),
    ],
)
def test_errors_that_tell_of_memory_are_known_by_their_kind(error, about_memory):
    def failing():
        raise error

    with pytest.raises(LimitError if about_memory else type(error)):
        in_time(failing, None, megabytes_held() + 200)


def megabytes_held():
    import resource

    return int(memory_limit.MEMORY.read_text().split()[1]) * resource.getpagesize() // 10**6


@needs_memory_limit
def test_the_least_of_several_limits_on_memory_holds_until_the_last_run_ends():
    before, begun, ended = mapped_limit(), threading.Barrier(2), threading.Barrier(2)

    def other():
        begun.wait(PLENTY)
        ended.wait(PLENTY)

    thread = threading.Thread(target=in_time, args=(other, None, megabytes_held() + 1000))
    thread.start()
    begun.wait(PLENTY)
    around = mapped_limit()
    inside = in_time(mapped_limit, None, megabytes_held() + 500)
    assert inside[0] < around[0]
    assert mapped_limit() == around
    ended.wait(PLENTY)
    thread.join(PLENTY)
    assert mapped_limit() == before


@needs_memory_limit
def test_a_limit_below_what_the_program_holds_says_so():
    with pytest.raises(LimitError, match=r"the program alone holds \d+ MB"):
        in_time(lambda: None, None, 1)


@needs_memory_limit
def test_memory_is_limited_in_run_check_and_batch(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    limit = f"limits: {{max_memory_mb: {megabytes_held() + 400}}}\n"
    (tmp_path / "case.yaml").write_text(SQUARE + limit)
    assert command("run", "case.yaml", "-q", "-o", "out/")[0] == 0
    monkeypatch.setattr("bubblemesh.problem.fitting.surveyed", lambda *_: np.ones(10**9))
    for name in ("run", "check"):
        code, _, message = command(name, "case.yaml")
        assert code == 6
        assert message.startswith("error: case.yaml: limits.max_memory_mb: more than the limit of")
    (entry,) = plan_cases(["case.yaml"], BatchOptions(folder="batch"))
    outcome = mesh_job(entry.job(), lambda note: None)
    assert outcome.row.exit_code == 6
    assert "limits.max_memory_mb" in outcome.row.error


@needs_memory_limit
def test_a_small_file_is_read_in_little_memory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text("domain: {outer: {file: ring.txt}}\nspacing: 0.2\n")
    (tmp_path / "ring.txt").write_text("0 0\n1 0\n1 1\n0 1\n")
    for name in ("run", "check"):
        code, _, message = command(name, "case.yaml", "--set", f"limits.max_memory_mb={megabytes_held() + 200}")
        assert code == 0, message
    limited = (tmp_path / "case.yaml").read_text() + f"limits: {{max_memory_mb: {megabytes_held() + 200}}}\n"
    (tmp_path / "limited.yaml").write_text(limited)
    (entry,) = plan_cases(["limited.yaml"], BatchOptions(folder="batch"))
    assert mesh_job(entry.job(), lambda note: None).row.exit_code == 0


@needs_memory_limit
@pytest.mark.parametrize("before", ["60, None", "None, None"])
@pytest.mark.parametrize("seconds", [60, None])
def test_a_limit_on_time_leaves_that_on_memory_as_it_is(before, seconds):
    """The C library maps a heap of 64 MB for each thread, of which other threads take when theirs is full."""
    code = (
        "import time\nfrom bubblemesh.process.limits import within\n"
        "from bubblemesh.process.memory_limit import MEMORY\n"
        "def hold(pieces):\n    return len([bytes(1000) for _ in range(pieces)])\n"
        f"within(lambda: hold(1), {before}, time.perf_counter())\n"
        "held = int(MEMORY.read_text().split()[1]) * 4096 // 10**6\n"
        f"within(lambda: hold(70_000), {seconds}, held + 40, time.perf_counter())\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert "MB is needed" in ended.stderr


def test_a_system_without_limits_on_memory_is_told_of(monkeypatch, tmp_path):
    monkeypatch.setattr(memory_limit, "MEMORY", tmp_path / "nothing")
    case = load_case("case.yaml", text=SQUARE + "limits: {max_memory_mb: 1}\n")
    (warning,) = [one for one in mesh_case(case).report["warnings"] if "memory" in one]
    assert warning.startswith("limits.max_memory_mb: this system cannot limit")
    assert load_case("case.yaml", text=SQUARE).warnings == ()


def star(points):
    turn, radius = 2 * np.pi * np.arange(points) / points, np.where(np.arange(points) % 2, 1.0, 0.5)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn)]).tolist()


def polygon(points):
    return f"domain: {{outer: {{polygon: {points}}}}}\nspacing: 0.05\n"


def holes(number):
    spots = [
        f"{{circle: {{center: [{k + 0.5}, {j + 0.5}], radius: 0.2}}}}" for k in range(number) for j in range(number)
    ]
    return f"domain: {{outer: {{rectangle: [0, 0, {number}, {number}]}}, holes: [{', '.join(spots)}]}}\nspacing: 1\n"


FINE = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.001\n"
SLOW = {  # with a time that is enough for the stages before, and not for this one, on fast and slow machines
    "geometry": (lambda: holes(50), "multilevel", 1.0),
    "spacing": (lambda: FINE.replace("0.001", "'0.1 + 0.09*sin(1e6*x*y)'"), "multilevel", 1.0),
    "placement": (lambda: FINE.replace("0.001", "0.0008"), "accelerated", 2.5),
}


@pytest.mark.long
@pytest.mark.parametrize("stage", SLOW)
def test_a_case_that_is_slow_in_a_stage_ends_in_time(stage):
    text, method, seconds = SLOW[stage]
    case = load_case("case.yaml", text=text(), method=method)
    limited = case.model_copy(update={"limits": case.limits.model_copy(update={"seconds": seconds})})
    begun = perf_counter()
    with pytest.raises(LimitError, match=f"while {watchdog.STAGES[stage][0]}"):
        mesh_case(limited.loaded(replace(case.origin, seconds=0.0), ()))
    assert perf_counter() - begun < seconds + 3


@pytest.mark.long
def test_a_case_that_is_slow_to_read_ends_in_time():
    text = SQUARE + "parameters: {" + ", ".join(f"p{k}: {k}" for k in range(200_000)) + "}\n"
    begun = perf_counter()
    with pytest.raises(LimitError, match="while reading the case"):
        load_case("case.yaml", text=text, time_limit=1)
    assert perf_counter() - begun < 4


@pytest.mark.long
@pytest.mark.parametrize("form", ["{}limits: {{seconds: 1}}\n", "limits: {{seconds: 1}}\n{}"])
def test_a_limit_in_the_case_holds_from_the_start(form):
    text = SQUARE + "parameters:\n" + "".join(f"  p{k}: {k}\n" for k in range(300_000))
    begun = perf_counter()
    with pytest.raises(LimitError, match="while reading the case"):
        load_case("case.yaml", text=form.format(text))
    assert perf_counter() - begun < 3


@pytest.mark.long
def test_a_ring_of_very_many_points_is_read_soon():
    begun = process_time()
    load_case("case.yaml", text=polygon(np.random.default_rng(0).random((200_000, 2)).tolist()))
    assert process_time() - begun < 5


@pytest.mark.long
@pytest.mark.parametrize(("spacing", "seconds"), [(0.003, 5), (0.002, 12)])
def test_a_packing_that_is_slow_leaves_time_for_the_rest(spacing, seconds, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.yaml").write_text(
        FINE.replace("0.001", str(spacing)) + "packing: {effort: best, fully_shaken: 1000000}\n"
    )
    begun = perf_counter()
    code, _, message = command("run", "case.yaml", "-q", "-o", "out/", "--time-limit", seconds)
    assert perf_counter() - begun < 1.2 * seconds + 3
    assert code == 6
    assert "the mesh is as it was then" in message
    assert (tmp_path / "out/case.msh").exists()


@pytest.mark.long
def test_a_batch_goes_on_after_a_case_that_is_late(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "late.yaml").write_text(holes(50) + "limits: {seconds: 1}\n")
    (tmp_path / "good.yaml").write_text(SQUARE)
    code, _, message = command("batch", "late.yaml", "good.yaml", "-o", "out", "-j", "1")
    assert code == 6, message
    assert (tmp_path / "out/good.msh").exists()


def test_a_limit_that_was_kept_leaves_the_profiler_working():
    """An exception of a thread that is taken back makes Python look for it for ever, with which profiling hangs."""
    code = (
        "import cProfile, time\nfrom bubblemesh.process.limits import within\n"
        "within(lambda: None, 60, None, time.perf_counter())\n"
        "print(cProfile.Profile().runcall(lambda: sum(k for k in range(10))))\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=30)
    assert ended.stdout == "45\n"
