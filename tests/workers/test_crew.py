"""Workers that pack the parts of one mesh: results of all jobs, whatever becomes of the workers."""

import os
import pickle
import signal
import sys
from concurrent.futures import Future
from contextlib import contextmanager

import numpy as np
import pytest
from commands import command
from sweeps import sweep

from bubblemesh.case import load_case
from bubblemesh.errors import (
    COARSEN,
    NODE_LIMIT,
    CaseError,
    FileError,
    GeometryError,
    Key,
    LimitError,
    NodeLimitError,
    RequirementError,
    prefixed,
)
from bubblemesh.geometry.plane import Plane
from bubblemesh.messages import place, tell_places_by, tell_places_of
from bubblemesh.packing.configure import OptionError
from bubblemesh.parts.work import Job
from bubblemesh.process.memory_limit import memory_can_be_limited
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.spacing.expression import UnknownNameError
from bubblemesh.workers.crew import called, crew_of
from bubblemesh.workers.hire import workers_at
from bubblemesh.workers.local import local_workers
from bubblemesh.workers.workers import ATTEMPTS, Workers

CASE = """
domain: {outer: {rectangle: [0, 0, 2, 1]}}
spacing: 0.1
"""


@pytest.fixture(scope="module")
def workers():
    with local_workers(2) as some:
        yield some


def test_all_jobs_have_a_result(workers):
    told = []
    assert dict(called(workers, pow, (Job("", (k, 2)) for k in range(20)), told.append)) == {
        k: k * k for k in range(20)
    }
    assert told == []


def limit_on_data():
    import resource

    return resource.getrlimit(resource.RLIMIT_DATA)[0]


@pytest.mark.skipif(not memory_can_be_limited(), reason="this system cannot limit the memory of a process")
def test_a_limit_on_memory_holds_in_each_worker_as_long_as_it_has_a_job(workers):
    (limited,) = dict(called(workers, limit_on_data, [Job("", ())], print, 1000)).values()
    assert 0 < limited < 4e9
    (again,) = dict(called(workers, limit_on_data, [Job("", ())], print)).values()
    assert again not in range(limited + 1)
    with pytest.raises(LimitError, match=r"^part 2: limits\.max_memory_mb: more than the limit of 300 MB is needed"):
        list(called(workers, np.ones, [Job("part 2", (10**9,))], print, 300))


def refused_at(point):
    raise GeometryError(f"no place for it at {place(point)}")


def test_workers_tell_places_as_this_process_does(workers):
    pytest.importorskip("pyproj")
    plane = Plane("EPSG:4326", None, (3.05, 52.05))
    there = plane.to(np.array([[3.02, 52.01]]))[0]
    for given, size, text in ((plane.given_place, None, r"\(3.02, 52.01\)"), (None, 1e7, r"\(-2060, -4450\)")):
        tell_places_by(given)
        tell_places_of(size)
        with pytest.raises(GeometryError, match=f"^part 1: no place for it at {text}$"):
            list(called(workers, refused_at, [Job("part 1", (there,))], print))


def test_no_jobs_have_no_results_and_hire_nobody():
    @contextmanager
    def hire(jobs):
        raise AssertionError
        yield

    with crew_of(hire, print):
        pass
    with local_workers(1) as one:
        assert list(called(one, pow, (), print)) == []


def test_jobs_are_made_when_workers_are_free_for_them(workers):
    made = []

    def jobs():
        for k in range(50):
            made.append(k)
            yield Job("", (k, 1))

    results = called(workers, pow, jobs(), print)
    next(results)
    assert len(made) <= workers.capacity() + 2
    results.close()


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")
def test_a_job_whose_worker_dies_is_given_to_another_one(workers, tmp_path):
    marker = tmp_path / "died"
    jobs = [Job("", (f"{marker!s}", k)) for k in range(4)]
    assert dict(called(workers, dying_once, jobs, print)) == {k: 10 * k for k in range(4)}
    assert marker.exists()


class Leaving(Workers):
    """Workers that leave with their first job, and come back; nobody else hears of its cancellation."""

    def submit(self, function, /, *arguments):
        future = Future()
        if self.recalled:
            future.set_result(function(*arguments))
        else:
            self.recalled.add(future)
            future.cancel()
        return future

    def capacity(self):
        return 1

    def failure(self, error):
        raise AssertionError


def test_a_job_that_is_recalled_is_given_out_again():
    assert dict(called(Leaving(), pow, [Job("", (3, 2)), Job("", (4, 2))], print)) == {0: 9, 1: 16}


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")
def test_a_job_that_takes_each_worker_with_it_is_an_error_that_says_so(workers):
    with pytest.raises(LimitError, match=f"the part around here: its worker process was killed.*in each of {ATTEMPTS}"):
        list(called(workers, dying, [Job("the part around here", ())], print))


def test_an_error_of_the_package_tells_its_job(workers):
    with pytest.raises(GeometryError, match=r"^the seam there: rings cross$"):
        list(called(workers, failing, [Job("the seam there", ("rings cross",))], print))


@pytest.mark.parametrize(
    ("function", "argument", "error"),
    [(np.ones, 1 << 45, MemoryError), (int, "no number", ValueError), (chr, -1, ValueError)],
)
def test_any_other_error_is_what_it_is(workers, function, argument, error):
    with pytest.raises(error):
        list(called(workers, function, [Job("the part around here", (argument,))], print))


@pytest.mark.parametrize(
    "error",
    [
        *(kind("there: a fault") for kind in (CaseError, GeometryError, RequirementError, FileError, LimitError)),
        UnknownNameError("unknown name 'z'", "z", follows=True),
        OptionError("packing", "seed", "must be a number"),
        NodeLimitError(f"{NODE_LIMIT}: there are more: {COARSEN}", "the metric"),
    ],
)
def test_errors_of_the_package_travel_as_they_are(error):
    error.about = Key(["spacing", 0])
    with pytest.raises(type(error)) as caught, prefixed("case.yaml"):
        raise error
    again = pickle.loads(pickle.dumps(caught.value))
    assert (type(again), str(again), vars(again)) == (type(error), str(error), vars(error))
    assert str(again).startswith("case.yaml: ")


def test_a_result_that_cannot_travel_is_an_error_that_says_so(workers):
    with pytest.raises(FileError, match=r"^the seam there: no worker process could take it: .*pickle"):
        list(called(workers, eval, [Job("the seam there", ("lambda: 0",))], print))
    assert dict(called(workers, pow, [Job("", (3, 2))], print)) == {0: 9}


def test_hired_workers_are_those_of_the_command_line():
    with crew_of(workers_at(1, None), print) as crew:
        pids = {pid for _, pid in crew(os.getpid, [Job("", ())] * 3)}
        assert len(pids) == 1
        assert {pid for _, pid in crew(os.getpid, [Job("", ())])} == pids
    assert os.getpid() not in pids


def test_workers_load_only_what_packing_needs(tmp_path):
    case = tmp_path / "plate.yaml"
    case.write_text(CASE.replace("0.1", "{value: 0.1 + 0.01*x, near: [{point: [1, 0.5], size: 0.06}]}"))
    with crew_of(workers_at(1, None), print) as crew:
        mesh_case(load_case(case, parts=3), crew=crew)
        (_, loaded), *_ = crew(eval, [Job("", ("{*__import__('sys').modules}",))])
    assert "bubblemesh.parts.packing" in loaded
    assert not loaded & {
        "pydantic",
        "yaml",
        "rich",
        "numpy.ma",
        "bubblemesh.case",
        "bubblemesh.problem",
        "bubblemesh.run",
    }


@pytest.mark.parametrize("more", sweep(["", "metric: {angle: 0.5, across: 0.05}\n"], quick=1))
def test_a_run_in_parts_is_the_same_with_any_number_of_workers(tmp_path, monkeypatch, more):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plate.yaml").write_text(CASE + more)
    for jobs in ("1", "2"):
        code, _, told = command("run", "plate.yaml", "--parts", "3", "--jobs", jobs, "-o", f"jobs-{jobs}")
        assert code == 0, told
    one, two = ((tmp_path / f"jobs-{jobs}" / "plate.msh").read_bytes() for jobs in ("1", "2"))
    assert one == two


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--jobs", "2"], "error: --jobs: a mesh in one piece takes one process: add --parts auto"),
        (["--cluster", "tcp://here:1"], "error: --cluster: a mesh in one piece takes one process: add --parts auto"),
        (["--parts", "2", "--jobs", "2", "--cluster", "tcp://here:1"], "--jobs counts processes of this machine"),
        (["--parts", "some"], "--parts: parts: must be auto, or a whole number of at least 1 (found the text 'some')"),
        (["--parts", "-2"], "--parts: parts: must be auto, or a whole number of at least 1 (found -2)"),
    ],
)
def test_options_that_do_not_go_together_are_told(tmp_path, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plate.yaml").write_text(CASE)
    code, _, told = command("run", "plate.yaml", *options)
    assert code == 2
    assert message in told


def dying_once(marker, number):
    """Ten times the number; the first call of all kills its process."""
    try:
        os.close(os.open(marker, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return 10 * number
    return dying()


def dying():
    os.kill(os.getpid(), signal.SIGKILL)


def failing(text):
    raise GeometryError(text)
