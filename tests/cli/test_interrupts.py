"""Ctrl-C and requests to end: exit code 130 at any moment, and the files as they were."""

import signal
import subprocess
import sys

import pytest
from commands import contents

pytestmark = pytest.mark.long

CASE = """\
domain: {outer: {rectangle: [0, 0, 1, 1]}, regions: [{name: a, ring: {circle: {center: [0.5, 0.5], radius: 0.2}}}]}
spacing: 0.3
packing: {effort: fast}
output: {formats: [msh, xdmf]}
"""
ENDLESS = ["method=accelerated", "schedule.rounds=10000", "schedule.tolerance=0", "spacing=0.02", "packing={}"]
# Sends itself a signal as soon as the interpreter does something, such as import a module or rename a file.
SELF_INTERRUPTED = """
import atexit, os, sys

event, text, number = sys.argv[1], sys.argv[2], int(sys.argv[3])
armed = [True]

def interrupt(name="exit", args=()):
    if armed and name == event and text in str(args):
        armed.clear()
        os.kill(os.getpid(), number)

sys.addaudithook(interrupt)
atexit.register(interrupt)
sys.argv = ["bubblemesh", *sys.argv[4:]]
from bubblemesh.__main__ import main
main()
"""


@pytest.fixture
def here(tmp_path):
    """A folder with a case and old files."""
    (tmp_path / "case.yaml").write_text(CASE)
    (tmp_path / "out").mkdir()
    for name in ("case.msh", "case.report.json"):
        (tmp_path / "out" / name).write_text("old")
    return tmp_path


def interrupted_at(folder, event, text, number):
    command = [
        sys.executable,
        "-c",
        SELF_INTERRUPTED,
        event,
        text,
        str(int(number)),
        "run",
        "case.yaml",
        "-q",
        "-o",
        "out",
    ]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize(
    ("event", "text", "number"),
    [
        ("import", "typer", signal.SIGINT),  # nothing of the package is loaded
        ("import", "typer", signal.SIGTERM),
        ("import", "yaml", signal.SIGTERM),
        ("import", "numpy", signal.SIGINT),
        ("import", "scipy", signal.SIGTERM),
        ("import", "pythoncdt", signal.SIGINT),
        ("os.mkdir", ".bubblemesh-", signal.SIGTERM),  # the folder in which files are made
        ("open", "case.msh", signal.SIGINT),
        ("open", "case.report.json", signal.SIGTERM),
        ("os.link", "case.msh", signal.SIGINT),  # an old file is kept aside
        ("os.rename", "case.msh", signal.SIGTERM),  # the new one takes its place
        ("os.rename", "case.report.json", signal.SIGINT),  # the last of several
    ],
)
def test_an_interrupt_at_any_moment_leaves_the_files_as_they_were(here, event, text, number):
    before = contents(here)
    process = interrupted_at(here, event, text, number)
    assert (process.returncode, process.stdout) == (130, ""), process.stderr
    assert process.stderr == "error: interrupted\n"
    assert contents(here) == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_when_all_is_done_changes_nothing(here, number):
    process = interrupted_at(here, "exit", "", number)
    assert process.returncode == 0, process.stderr
    assert len(list((here / "out").iterdir())) == 7
    assert (here / "out/case.msh").read_bytes() != b"old"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_from_outside_while_bubbles_move(here, number):
    before = contents(here)
    settings = [word for setting in ENDLESS for word in ("--set", setting)]
    command = [sys.executable, "-m", "bubblemesh", "run", "case.yaml", "-o", "out", *settings]
    process = subprocess.Popen(command, cwd=here, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    for _ in range(3):  # the head of the table and two rounds: packing is under way
        assert process.stderr.readline()
    process.send_signal(number)
    _, message = process.communicate(timeout=60)
    assert process.returncode == 130, message
    assert b"interrupted" in message
    assert b"Traceback" not in message
    assert contents(here) == before


# As Pydantic does where a value may be of two types: whatever is raised while it tries the first one is dropped.
DROPPED = """
import os, signal, sys
from bubblemesh.batch.plan import Entry
from bubblemesh.run import pipeline

def dropping(function):
    def call(*arguments, **options):
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except BaseException:
            pass
        return function(*arguments, **options)
    return call

Entry.job = dropping(Entry.job)
pipeline.prepare = dropping(pipeline.prepare)
from bubblemesh.__main__ import main
main()
"""


@pytest.mark.parametrize("command", ["run", "batch"])
def test_an_interrupt_that_a_library_drops_is_heeded_soon_after(here, command):
    before = contents(here)
    arguments = [sys.executable, "-c", DROPPED, command, "case.yaml", "-q", "-o", "out"]
    process = subprocess.run(arguments, cwd=here, capture_output=True, text=True, timeout=120, check=False)
    assert process.returncode == 130, process.stderr
    assert "error: interrupted" in process.stderr
    if command == "run":
        assert contents(here) == before
