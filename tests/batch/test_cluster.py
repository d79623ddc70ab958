"""The same batch on a Dask cluster: a real scheduler and real workers, in processes of their own."""

import json
import logging
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections import Counter
from importlib.util import find_spec
from pathlib import Path
from threading import Thread

import pytest
from batches import (
    BAD,
    SMALL,
    Finished,
    Note,
    Warned,
    batch,
    command,
    events_of,
    follow,
    lines_of,
    results_in,
    rows_of,
)

import bubblemesh
from bubblemesh.errors import CaseError, FileError
from bubblemesh.workers.cluster import cluster_workers
from bubblemesh.workers.hire import workers_at

pytestmark = [
    pytest.mark.long,
    # Not imported, which takes long, where none of these tests are run.
    pytest.mark.skipif(find_spec("distributed") is None, reason="the extra cluster is not installed"),
    pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX"),
]

QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
LONG = SMALL.replace("iterations: 5", "iterations: 2000")


class Cluster:
    """A scheduler and its workers, which work in a folder of their own."""

    def __init__(self, folder):
        self.folder = folder
        self.file = folder / "scheduler.json"
        self.workers = []
        # A task that kills its worker is given up at once: our jobs are told apart from it by other tests.
        settings = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "2"}
        self.scheduler = self.started("scheduler", "--port", "0", "--scheduler-file", self.file, **settings)
        end = time.monotonic() + 60
        while not (self.file.exists() and self.file.read_text().endswith("}")):
            assert time.monotonic() < end
            time.sleep(0.02)
        self.address = json.loads(self.file.read_text())["address"]

    def started(self, *arguments, **settings):
        line = [sys.executable, "-m", "dask", *map(str, arguments), "--no-dashboard"]
        paths = {"PYTHONPATH": str(Path(bubblemesh.__file__).parents[1])}  # and not the tests
        environment = {**os.environ, **paths, **settings, "OMP_NUM_THREADS": "1"}
        return subprocess.Popen(line, cwd=self.folder, env=environment, **QUIET)

    def hire(self, count, **settings):
        """Start so many workers, beside those that live."""
        for _ in range(count):
            self.workers.append(self.started("worker", self.address, "--nthreads", "1", "--no-nanny", **settings))

    def hire_unfit(self, code):
        """Start a worker whose Python runs some code first."""
        folder = self.folder / f"python-{len(self.workers)}"
        folder.mkdir()
        (folder / "sitecustomize.py").write_text(code)
        self.hire(1, PYTHONPATH=f"{folder}:{Path(bubblemesh.__file__).parents[1]}")

    def close(self):
        for process in (*self.workers, self.scheduler):
            process.send_signal(signal.SIGCONT)
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    running = Cluster(tmp_path_factory.mktemp("cluster"))
    running.hire(2)
    yield running
    running.close()


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


PARTS = """
domain: {outer: {rectangle: [0, 0, 2, 1]}}
spacing: 0.008
parts: 8
output: {formats: [xdmf]}
"""


def kept(folder):
    """Number of the parts that a run has kept, -1 before it has begun."""
    return len([*folder.glob(".bubblemesh-parts-*/**/part-*.npz")]) if folder.exists() else -1


@pytest.mark.parametrize("lost", [1, 2], ids=["one of two", "both"])
@pytest.mark.parametrize("done", [0, 3], ids=lambda done: f"after {done} parts")
def test_parts_of_workers_that_die_are_packed_by_others(lost, done, here, tmp_path_factory):
    Path("plate.yaml").write_text(PARTS)
    line = [sys.executable, "-m", "bubblemesh", "run", "plate.yaml", "-q", "-o"]
    subprocess.run([*line, "local/", "--jobs", "1"], check=True, timeout=120)
    own = Cluster(tmp_path_factory.mktemp("dying"))
    own.hire(2)
    try:
        with cluster_workers(own.address) as workers:
            while workers.capacity() < 4:  # until both have told their version
                time.sleep(0.05)
        process = subprocess.Popen([*line, "remote/", "--cluster", own.address], stderr=subprocess.PIPE, text=True)
        while kept(here / "remote") < done:
            assert process.poll() is None
            time.sleep(0.01)
        for worker in own.workers[:lost]:
            worker.kill()
        if lost == 2:
            own.hire(2)
        _, message = process.communicate(timeout=120)
    finally:
        own.close()
    assert process.returncode == 0, message
    # That there is nobody may be seen or not, and is all that is told.
    assert message in {"", f"warning: no workers are at {own.address}: waiting for them\n"}
    for name in ("plate.h5", "plate_facets.h5"):
        assert Path("local", name).read_bytes() == Path("remote", name).read_bytes()


def test_what_the_library_says_of_lost_workers_is_not_shown(cluster):
    with cluster_workers(cluster.address):
        for name in ("distributed.client", "tornado.application"):
            assert not logging.getLogger(name).isEnabledFor(logging.CRITICAL)


def test_a_cluster_gives_the_rows_and_the_bytes_of_this_machine(cluster, here):
    (here / "ring.txt").write_text("0 0\n1 0\n1 1\n0 1\n")
    Path("a.yaml").write_text(SMALL + "sweep: {packing.seed: [1, 2, 3]}\n")
    Path("b.yaml").write_text(BAD)
    Path("c.yaml").write_text(SMALL.replace("rectangle: [0, 0, 1, 1], label: wall", "file: ring.txt"))
    Path("d.yaml").write_text(SMALL.replace("[msh]", "[msh, vtu, xdmf]"))
    process = batch(".", "-o", "out", "--cluster", cluster.address, "--json", folder=here)
    assert process.returncode == 3, process.stderr
    assert "Traceback" not in process.stderr
    assert rows_of(".", folder="local")[3].exit_code == 3
    assert results_in(here / "out") == results_in(here / "local")
    rows = {name: lines_of(here / name / "summary.jsonl") for name in ("out", "local")}
    lasting = ("case", "source", "sweep", "exit_code", "error", "nodes", "quality_min", "inputs", "folder")
    there, local = (sorted([row[key] for key in lasting] for row in found) for found in rows.values())
    assert there == local
    assert len(there) == json.loads(process.stdout)["cases"] == 6
    again = batch(".", "-o", "out", "--cluster", cluster.address, "--resume", folder=here)
    assert "1 failed, 5 unchanged" in again.stderr


def test_a_worker_killed_in_mid_batch_costs_a_retry_and_no_case(cluster, here):
    longer = SMALL.replace("iterations: 5", "iterations: 1000")  # so that both are still at work when that is known
    Path("a.yaml").write_text(longer + "sweep: {packing.seed: [1, 2, 3, 4]}\n")
    begun, rows = Counter(), []

    def kill(event):
        if isinstance(event, Note) and event.round == 0:
            begun[event.number] += 1
            if len(begun) == 2:  # both workers have a case
                cluster.workers[-1].kill()
                cluster.hire(1)
        if isinstance(event, Finished):
            rows.append(event.row)

    follow(kill, "a.yaml", folder="out", workers=workers_at(None, cluster.address))
    assert [row.exit_code for row in rows] == [0] * 4
    assert sum(row.attempts for row in rows) == sum(begun.values()) > 4
    rows_of("a.yaml", folder="local")
    assert results_in(here / "out") == results_in(here / "local")


def test_a_call_that_kills_every_worker_is_given_up(cluster):
    cluster.hire(3)
    with cluster_workers(cluster.address) as crew:
        code, words = crew.failure(crew.submit(os._exit, 1).exception(timeout=60))
    assert (code, words) == (6, "3 workers in turn ended over it, perhaps for want of memory")
    cluster.hire(1)


def test_a_worker_without_what_the_job_needs_is_told_of(cluster):
    with cluster_workers(cluster.address) as crew:
        code, words = crew.failure(crew.submit(results_in, ".").exception(timeout=60))  # a module of the tests
    assert code == 5
    assert f"is bubblemesh {bubblemesh.__version__} installed there, with the same Python?" in words
    assert words.startswith("no worker could take it: ModuleNotFoundError: No module named 'batches'")


def test_an_interrupt_takes_the_cases_off_the_cluster(cluster, here):
    Path("a.yaml").write_text(LONG + f"sweep: {{packing.seed: {list(range(40))}}}\n")
    process = subprocess.Popen(
        command("a.yaml", "-o", "out", "--cluster", cluster.address), stderr=subprocess.PIPE, text=True
    )
    while not process.stderr.readline().startswith("[1/40]"):
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    _, message = process.communicate(timeout=30)
    assert process.returncode == 130, message
    assert "error: interrupted" in message
    assert "Traceback" not in message
    assert 1 <= len(lines_of(here / "out/summary.jsonl")) < 40
    with cluster_workers(cluster.address) as crew:  # whose workers are free after the cases that they have begun
        assert crew.submit(int, "3").result(timeout=60) == 3


# Workers that cannot mesh

UNFIT = {
    "without": "import sys\nsys.modules['bubblemesh'] = None\n",
    "another version": "import bubblemesh\nbubblemesh.__version__ = '0.0.9'\n",
    "without a library": "import sys\nsys.modules['shapely'] = None\n",
}
FOUND = {
    "without": "cannot load bubblemesh (ModuleNotFoundError: ",
    "another version": "has bubblemesh 0.0.9, this process has ",
    "without a library": "cannot load bubblemesh (ModuleNotFoundError: ",
}


@pytest.mark.parametrize("kind", UNFIT)
def test_a_worker_that_cannot_mesh_is_told_and_left_out_and_the_others_get_the_cases(kind, here, tmp_path_factory):
    Path("a.yaml").write_text(SMALL + f"sweep: {{packing.seed: {list(range(6))}}}\n")
    own = Cluster(tmp_path_factory.mktemp("unfit"))
    own.hire_unfit(UNFIT[kind])
    events = []

    def hire(event):
        events.append(event)
        if isinstance(event, Warned) and event.message.endswith("waiting for others"):
            own.hire(1)  # only now is there somebody for the cases

    try:
        totals = follow(hire, "a.yaml", folder="out", workers=workers_at(None, own.address))
    finally:
        own.close()
    assert (totals["cases"], totals["failed"]) == (6, 0)
    told = [event.message for event in events if isinstance(event, Warned)]
    (refused,) = [message for message in told if not message.startswith("no workers")]
    assert re.match(r"the worker at tcp://[\d.]+:\d+ " + re.escape(FOUND[kind]), refused)
    assert any(message.startswith(f"no workers at {own.address} are left that can mesh") for message in told)
    assert [row["attempts"] for row in totals["rows"]] == [1] * 6


def test_cases_of_workers_that_have_left_go_to_those_that_come(here, tmp_path_factory, monkeypatch):
    monkeypatch.setattr("bubblemesh.workers.cluster.REFRESH", 0.5)
    Path("a.yaml").write_text(LONG + "sweep: {packing.seed: [1, 2, 3]}\n")
    own = Cluster(tmp_path_factory.mktemp("left"))
    own.hire(1)
    rows, killed = [], []

    def kill(event):
        if isinstance(event, Note) and not killed:
            killed.append(own.workers[0].kill())
            own.workers[0].wait()
            own.hire(1)
        if isinstance(event, Finished):
            rows.append(event.row)

    try:
        follow(kill, "a.yaml", folder="out", workers=workers_at(None, own.address))
    finally:
        own.close()
    assert [row.exit_code for row in rows] == [0] * 3
    assert sorted(row.attempts for row in rows) == [1, 1, 2]


# Clusters that are not there


@pytest.mark.parametrize("address", ["here", "tcp://", "tcp://host", "http://host:80", "host:8786", "tcp://host:port"])
def test_an_address_has_a_protocol_a_host_and_a_port(address):
    with pytest.raises(CaseError, match="must be the address of a Dask scheduler, such as tcp://host:8786"):
        workers_at(None, address)


@pytest.mark.parametrize("what", ["nobody listens", "no such host", "silence", "babble", "a worker"])
def test_a_scheduler_that_does_not_answer_ends_the_batch_soon_and_loses_nothing(what, here, cluster, monkeypatch):
    monkeypatch.setattr("bubblemesh.workers.cluster.PATIENCE", 2.0)
    Path("a.yaml").write_text(SMALL)
    rows_of("a.yaml", folder="out")
    before = Path("out/summary.jsonl").read_bytes()
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{listening.getsockname()[1]}"
        if what == "no such host":
            address = "tcp://no.such.host.invalid:8786"
        elif what == "a worker":
            address = worker_of(cluster)
        elif what != "nobody listens":
            listening.listen()
        if what == "babble":
            Thread(target=babble, args=(listening,), daemon=True).start()
        with pytest.raises(FileError) as caught:
            events_of("a.yaml", folder="out", workers=workers_at(None, address))
    message = "a Dask worker answers" if what == "a worker" else "no Dask scheduler has answered within 2 s"
    assert str(caught.value).startswith(f"--cluster {address}: {message}")
    assert Path("out/summary.jsonl").read_bytes() == before


def test_a_scheduler_that_has_stopped_ends_the_command_without_a_traceback(here, tmp_path_factory):
    Path("a.yaml").write_text(SMALL)
    own = Cluster(tmp_path_factory.mktemp("stopped"))
    try:
        own.scheduler.send_signal(signal.SIGSTOP)
        process = batch("a.yaml", "-o", "out", "--cluster", own.address, folder=here)
    finally:
        own.close()
    assert process.returncode == 5
    assert process.stderr.startswith(f"error: --cluster {own.address}: no Dask scheduler has answered within 5 s: is ")
    assert len(process.stderr.splitlines()) == 1


def worker_of(cluster):
    """The address of a worker."""
    with cluster_workers(cluster.address) as crew:
        return crew.submit(eval, "__import__('distributed').get_worker().address").result(timeout=60)


def babble(listening):
    connection, _ = listening.accept()
    with connection:
        connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 100)


def test_a_scheduler_that_goes_away_ends_the_batch_with_whole_rows(here, tmp_path_factory):
    Path("a.yaml").write_text(LONG + f"sweep: {{packing.seed: {list(range(8))}}}\n")
    own = Cluster(tmp_path_factory.mktemp("own"))
    own.hire(1)
    try:
        process = subprocess.Popen(
            command("a.yaml", "-o", "out", "--cluster", own.address), stderr=subprocess.PIPE, text=True
        )
        while not process.stderr.readline().startswith("[1/8]"):
            assert process.poll() is None
        own.scheduler.kill()
        _, message = process.communicate(timeout=60)
    finally:
        own.close()
    assert process.returncode == 5, message
    assert "the scheduler is out of reach: start it, and give the command again with --resume" in message
    assert "Traceback" not in message
    done = len(lines_of(here / "out/summary.jsonl"))
    assert 1 <= done < 8
    assert [row.exit_code for row in rows_of("a.yaml", folder="out", resume=True)] == [0] * 8


def test_a_scheduler_that_stops_in_mid_batch_ends_the_batch_with_whole_rows(here, tmp_path_factory, monkeypatch):
    Path("a.yaml").write_text(LONG + f"sweep: {{packing.seed: {list(range(8))}}}\n")
    own = Cluster(tmp_path_factory.mktemp("frozen"))
    own.hire(1)

    def stop(event):
        if isinstance(event, Finished):
            own.scheduler.send_signal(signal.SIGSTOP)
            for name in ("SILENCE", "REFRESH"):
                monkeypatch.setattr(f"bubblemesh.workers.cluster.{name}", 0.5)

    try:
        with pytest.raises(FileError, match="the scheduler is out of reach: start it, and give the command again"):
            follow(stop, "a.yaml", folder="out", workers=workers_at(None, own.address))
    finally:
        own.close()
    assert 1 <= len(lines_of(here / "out/summary.jsonl")) < 8


def test_a_scheduler_without_workers_is_told_of_once_and_the_batch_goes_on_when_they_come(
    here, tmp_path_factory, monkeypatch
):
    monkeypatch.setattr("bubblemesh.workers.cluster.REFRESH", 0.1)
    Path("a.yaml").write_text(SMALL)
    own = Cluster(tmp_path_factory.mktemp("empty"))
    waits, rows = [], []

    def hire(event):
        if isinstance(event, Warned):
            waits.append(event.message)
            own.hire(1)
        if isinstance(event, Finished):
            rows.append(event.row)

    try:
        follow(hire, "a.yaml", folder="out", workers=workers_at(None, own.address))
    finally:
        own.close()
    assert waits == [f"no workers are at {own.address}: waiting for them"]
    assert [row.exit_code for row in rows] == [0]


def test_without_the_extra_it_is_named(here, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    Path("a.yaml").write_text(SMALL)
    with pytest.raises(FileError, match=r'distributed is needed for --cluster: pip install "bubblemesh\[cluster\]"'):
        events_of("a.yaml", workers=workers_at(None, "tcp://127.0.0.1:8786"))
    assert sorted(path.name for path in here.iterdir()) == ["a.yaml"]
