"""Worker processes of this machine: they are several, warm, replaced when they die, and gone at the end."""

import errno
import importlib
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import wait
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from batches import LONG, SMALL, Finished, Note, batch, command, follow, lines_of, results_in, rows_of

from bubblemesh.errors import BubblemeshError, CaseError, FileError
from bubblemesh.files import OWNER
from bubblemesh.messages import places_now
from bubblemesh.parts.work import Job
from bubblemesh.process import resources
from bubblemesh.workers.crew import answer, crew_of
from bubblemesh.workers.hire import workers_at
from bubblemesh.workers.local import WorkerCopy, local_workers
from bubblemesh.workers.workers import WorkerDied

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")

NAP = 0.05
KILLS = 5


@pytest.fixture(scope="module")
def crew():
    with local_workers(2) as workers:
        yield workers


class Unreadable:
    """Needs a module that nobody has to be unpickled."""

    def __reduce__(self):
        return importlib.import_module, ("nowhere",)


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.long
def test_two_processes_work_at_the_same_time_and_stay(crew):
    pids = [crew.submit(os.getpid).result() for _ in range(4)]
    assert len(set(pids)) <= 2
    assert os.getpid() not in pids
    naps = [crew.submit(time.sleep, NAP) for _ in range(2)]
    other = {crew.submit(os.getpid).result() for _ in range(3)}
    wait(naps)
    assert len(other | set(pids)) <= 2


def test_processes_load_what_they_will_call_before_they_are_asked_to():
    loaded = "'bubblemesh.parts.packing' in __import__('sys').modules"
    with local_workers(1) as workers:
        assert not workers.submit(eval, loaded).result()
    with crew_of(lambda jobs, ahead: local_workers(1, ahead), print, ahead="bubblemesh.parts.packing") as crew:
        assert list(crew(eval, [Job("", (loaded,))])) == [(0, True)]


COPIES = """
import json, os, signal, sys, threading, time
from bubblemesh.workers.local import WorkerCopy, local_workers
from bubblemesh.workers.workers import WorkerDied

ahead = "bubblemesh.parts.packing"
opened = "sorted(int(name) for name in __import__('os').listdir('/proc/self/fd'))"
threads = threading.Event()
if sys.argv[1] == "threads":
    threading.Thread(target=threads.wait).start()
told = {}
with local_workers(2, ahead) as crew:
    kinds = lambda: sorted(type(process).__name__ for process in crew.processes)
    told["kinds"], told["loaded"] = kinds(), ahead in sys.modules
    calls = [crew.submit(time.sleep, 0.3), crew.submit(eval, f"{ahead!r} in __import__('sys').modules")]
    told["ready"] = calls[1].result()
    told["opened"] = crew.submit(eval, opened).result()
    told["threads"] = crew.submit(os.getenv, "OMP_NUM_THREADS").result(), os.getenv("OMP_NUM_THREADS")
    told["printed"] = crew.submit(print, "no answer").result()
    told["interrupted"] = crew.submit(signal.raise_signal, signal.SIGINT).result()
    pids = [process.pid for process in crew.processes]
    died = []
    for end in ((os._exit, 3), (signal.raise_signal, signal.SIGTERM)):
        try:
            crew.submit(*end).result()
        except WorkerDied as error:
            died.append(error.args[1])
    told["died"], told["then"] = died, kinds()
    told["answers"] = [crew.submit(abs, -number).result() for number in range(4)]
    pids += [process.pid for process in crew.processes]
threads.set()
told["left"] = [pid for pid in pids if os.path.exists(f"/proc/{pid}")]
print(json.dumps(told))
"""


@pytest.mark.skipif(not resources.TASKS.exists(), reason="threads are counted by /proc")
@pytest.mark.parametrize(
    ("threads", "kind"),
    [("none", "WorkerCopy"), pytest.param("threads", "WorkerProcess", marks=pytest.mark.long)],
)
def test_processes_are_copies_of_one_that_has_loaded_what_they_will_call_unless_it_has_threads(threads, kind):
    copied = kind == "WorkerCopy"
    alone = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "3"}
    done = subprocess.run(
        [sys.executable, "-c", COPIES, threads], env=alone, capture_output=True, text=True, check=True
    )
    told = json.loads(done.stdout)
    assert (told["kinds"], told["loaded"]) == ([kind] * 2, copied)
    assert told["ready"] or not copied  # others load it one after the other
    assert len(told["opened"]) == 6  # the standard streams, two pipes and what lists them
    assert told["threads"] == ["1", "3"]
    assert told["printed"] is told["interrupted"] is None
    assert told["died"] == [
        "its worker process ended with code 3",
        f"its worker process ended by signal {signal.SIGTERM:d} ({signal.strsignal(signal.SIGTERM)})",
    ]
    assert told["then"].count("WorkerProcess") >= 1
    assert told["answers"] == [0, 1, 2, 3]
    assert told["left"] == []
    assert done.stderr == ""


def test_each_process_computes_with_one_thread(crew):
    assert crew.submit(os.getenv, "OMP_NUM_THREADS").result() == "1"
    assert crew.submit(os.getenv, "OPENBLAS_NUM_THREADS").result() == "1"


def test_the_environment_of_the_batch_stays_as_it_is(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    before = dict(os.environ)
    with local_workers(1) as workers:
        assert workers.submit(os.getenv, "OMP_NUM_THREADS").result() == "1"
        assert dict(os.environ) == before


def test_an_exception_of_a_call_is_that_of_its_future(crew):
    with pytest.raises(ValueError, match="invalid literal"):
        crew.submit(int, "x").result()


def test_a_call_that_a_process_cannot_understand_is_an_error_of_that_call_only(crew):
    with pytest.raises(ModuleNotFoundError, match="nowhere"):
        crew.submit(importlib.import_module, "nowhere").result()
    with pytest.raises(ModuleNotFoundError, match="nowhere"):
        crew.submit(int, Unreadable()).result()
    assert crew.submit(int, "7").result() == 7


@pytest.mark.parametrize(
    "error",
    [
        "type('Held', (ValueError,), {})('a fault')",  # of a class that nobody finds
        "type('Held', (ValueError,), {'__reduce__': lambda self: (int, ('a fault',))})('a fault')",  # nor makes again
    ],
)
def test_an_error_that_does_not_travel_is_told_and_the_process_stays(error):
    with local_workers(1) as workers:
        pid = workers.submit(os.getpid).result()
        raising = f"(_ for _ in ()).throw({error})"
        with pytest.raises(BubblemeshError, match=r"^Held: a fault$"):
            workers.submit(eval, raising).result()
        with pytest.raises(BubblemeshError, match=r"^Held: a fault$"):
            workers.submit(answer, places_now(), None, eval, raising).result().get()
        assert workers.submit(os.getpid).result() == pid


def test_what_a_process_prints_is_no_answer(crew):
    assert crew.submit(print, "x" * 100_000).result() is None
    assert crew.submit(os.system, "echo y; cat").result() == 0
    assert crew.submit(int, "7").result() == 7


def test_notes_come_to_the_parent(crew):
    crew.submit(crew.tell, (7, 3, 100)).result()
    assert crew.notes.get(timeout=10) == (7, 3, 100)


@pytest.mark.long
@pytest.mark.parametrize(
    ("end", "message", "code"),
    [
        ((os._exit, 3), "its worker process ended with code 3", 1),
        ((signal.raise_signal, signal.SIGSEGV), r"its worker process ended by signal 11 \(Segmentation fault\)", 1),
        ((signal.raise_signal, signal.SIGKILL), "its worker process was killed, perhaps for want of memory", 6),
    ],
)
def test_a_process_that_dies_takes_its_own_call_only_and_is_replaced(end, message, code, crew):
    nap = crew.submit(time.sleep, NAP)
    with pytest.raises(WorkerDied, match=message) as caught:
        crew.submit(*end).result()
    assert crew.failure(caught.value)[0] == code
    nap.result()
    naps = [crew.submit(time.sleep, NAP) for _ in range(4)]
    assert [nap.result() for nap in naps] == [None] * 4


def test_processes_do_not_hear_of_ctrl_c(crew):
    assert crew.submit(signal.raise_signal, signal.SIGINT).result() is None


@pytest.mark.long
def test_processes_end_at_once_when_the_batch_is_broken_off():
    def interrupted():
        with local_workers(2) as crew:
            pids.extend({crew.submit(os.getpid).result() for _ in range(2)})
            for _ in range(4):
                crew.submit(time.sleep, 60)
            raise KeyboardInterrupt

    pids = []
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - begun < 50
    assert pids
    assert not any(map(alive, pids))


@pytest.mark.parametrize(
    ("quota", "cores"), [("max 100000", 6), ("250000 100000", 3), ("1000 100000", 1), ("900000 100000", 6), ("", 6)]
)
def test_the_cores_that_a_container_allows_are_counted(quota, cores, tmp_path, monkeypatch):
    (tmp_path / "cpu.max").write_text(quota)
    monkeypatch.setattr(resources, "QUOTA", tmp_path / "cpu.max")
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: set(range(6)), raising=False)
    assert resources.available_cores() == cores
    monkeypatch.setattr(resources, "QUOTA", tmp_path / "nowhere")
    assert resources.available_cores() == 6


@pytest.mark.parametrize(("jobs", "cases", "expected"), [(None, 9, 3), (2, 9, 2), (5, 2, 2), (None, 1, 1)])
def test_there_are_no_more_processes_than_cores_jobs_or_cases(jobs, cases, expected, monkeypatch):
    monkeypatch.setattr("bubblemesh.workers.hire.available_cores", lambda: 3)
    monkeypatch.setattr("bubblemesh.workers.hire.local_workers", lambda count, ahead: count)
    assert workers_at(jobs, None)(cases) == expected


def test_jobs_are_no_option_of_a_cluster():
    with pytest.raises(CaseError, match="--jobs counts processes of this machine"):
        workers_at(2, "tcp://host:8786")


def test_the_peak_of_memory_begins_anew():
    if not Path("/proc/self/clear_refs").exists():
        pytest.skip("this system cannot do that")
    large = bytearray(300_000_000)
    large[::4096] = b"x" * len(large[::4096])
    high = resources.peak_memory_mb()
    del large
    resources.forget_peak_memory()
    assert resources.peak_memory_mb() < high - 200


@pytest.mark.parametrize("missing", ["os.pipe", "Popen._execute_child"])
def test_without_file_descriptors_fewer_jobs_are_advised(missing, monkeypatch):
    def refuse(*arguments, **options):
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr(f"subprocess.{missing}", refuse)
    message = "a worker process cannot be started: Too many open files: try fewer --jobs"
    with pytest.raises(FileError, match=message), local_workers(2):
        pass


# In a batch


@pytest.mark.long
def test_a_worker_killed_in_mid_batch_costs_a_retry_and_no_case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    long = SMALL.replace("iterations: 5", "iterations: 500")
    Path("a.yaml").write_text(long + "sweep: {packing.seed: [1, 2, 3]}\n")
    rows, killed, crews = [], [], []

    @contextmanager
    def two_workers(cases):
        with local_workers(2) as crew:
            crews.append(crew)
            yield crew

    def kill(event):
        if isinstance(event, Note) and not killed:  # a case has begun
            killed.extend(process.pid for process in crews[0].processes)
            os.kill(killed[0], signal.SIGKILL)
        if isinstance(event, Finished):
            rows.append(event.row)

    follow(kill, "a.yaml", folder="out", workers=two_workers)
    assert len(killed) == 2
    assert not any(map(alive, killed))
    assert [row.exit_code for row in rows] == [0] * 3
    assert sorted(row.attempts for row in rows) == [1, 1, 2]
    assert len(lines_of(Path("out/summary.jsonl"))) == 3
    rows_of("a.yaml", folder="whole")
    assert results_in(tmp_path / "out") == results_in(tmp_path / "whole")


@pytest.mark.long
def test_workers_whose_batch_is_killed_say_nothing_and_the_next_batch_finds_no_folders(tmp_path, monkeypatch):
    here = tmp_path
    monkeypatch.chdir(here)
    monkeypatch.setenv("TMPDIR", str(here / "tmp"))
    (here / "tmp").mkdir()
    (here / "a.yaml").write_text(LONG + "sweep: {packing.seed: [1, 2, 3]}\n")
    (here / "b.yaml").write_text(SMALL)
    arguments = command("a.yaml", "-o", "out", "--jobs", "2", "-q")
    for after in np.linspace(0, 1, KILLS):
        before = {*(here / "tmp").glob(f"*/{OWNER}")}
        process = subprocess.Popen(arguments, stderr=subprocess.PIPE, stdout=subprocess.PIPE)
        while before >= {*(here / "tmp").glob(f"*/{OWNER}")}:  # then the workers start
            time.sleep(0.001)
        time.sleep(after)
        process.kill()
        assert process.communicate(timeout=60) == (b"", b"")  # when the last worker has closed them
    assert batch("b.yaml", "-o", "out", "--jobs", "1", folder=here).returncode == 0
    assert list((here / "tmp").iterdir()) == []
    assert not list((here / "out").glob(".bubblemesh*"))


@pytest.mark.skipif(not hasattr(os, "fork") or not Path("/proc/self/fd").exists(), reason="descriptors are in /proc")
def test_a_copy_that_cannot_be_made_leaves_nothing_open(monkeypatch):
    def fork():
        raise BlockingIOError("too many processes")

    monkeypatch.setattr(os, "fork", fork)
    before = {*Path("/proc/self/fd").iterdir()}
    with pytest.raises(BlockingIOError):
        WorkerCopy("")
    assert {*Path("/proc/self/fd").iterdir()} == before
