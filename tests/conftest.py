"""What all tests share: what needs a browser is marked so, and Gmsh's own reader."""

import gc
import os
import signal
import stat
from functools import cache

import pytest
import typer.testing
from batches import threads
from hypothesis import settings
from twins import needs_compiler, run_by
from typer.main import get_command

from bubblemesh.kernels.library import COMPILED, NUMPY
from bubblemesh.messages import own_places
from bubblemesh.process.resources import seldom_look_for_garbage

# A busy machine fails no test by its time, and all runs try the same examples.
settings.register_profile("steady", deadline=None, derandomize=True)
settings.load_profile("steady")

# Typer's runner puts all commands together anew for each one that a test calls, which takes longer than many of them.
typer.testing._get_command = cache(get_command)

# Whether a file is on the disk only a power cut can tell, and waiting for the disk takes longer than many tests.
to_disk = os.fsync


def to_disk_if_special(number):
    """What `os.fsync` does, but for files and folders, which are there for all processes already."""
    kind = os.fstat(number).st_mode
    if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
        to_disk(number)


os.fsync = to_disk_if_special

# Python would look for garbage again and again in all that is collected, which takes a third of the time of that.
gc.disable()


def pytest_collection_finish():
    """Look for garbage from now on as the program does: seldom, and not among all that is there already."""
    seldom_look_for_garbage()
    gc.enable()


def pytest_collection_modifyitems(items):
    """Mark what opens a browser."""
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.browser)


@pytest.fixture(params=[pytest.param(COMPILED, marks=needs_compiler), NUMPY])
def each_engine(request):
    """Both engines have to pass the tests that use this."""
    with run_by(request.param):
        yield


@pytest.fixture(autouse=True)
def places_of_each_test():
    """Places in messages are those of each test's own cases."""
    with own_places():
        yield


@pytest.fixture
def workers_in_threads(monkeypatch):
    """Workers of commands are threads, since it takes longer to start processes than to mesh small cases."""
    monkeypatch.setattr("bubblemesh.workers.hire.local_workers", lambda count, ahead=None: threads(count))


@pytest.fixture(scope="module")
def gmsh():
    """Gmsh's own Python module, ready to open files."""
    try:
        import gmsh
    except (ImportError, OSError) as error:
        pytest.skip(f"Gmsh cannot be imported, so that its own reader is not tested: {error}")
    gmsh.initialize(["gmsh", "-noenv"], interruptible=False)
    # Gmsh lets a broken pipe end the process, which Python does not.
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()
