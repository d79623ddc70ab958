"""What all tests share: what needs a browser is marked so, and Gmsh's own reader."""

import signal

import pytest
from hypothesis import settings

from bubblemesh.messages import own_places

# A busy machine fails no test by its time, and all runs try the same examples.
settings.register_profile("steady", deadline=None, derandomize=True)
settings.load_profile("steady")


def pytest_collection_modifyitems(items):
    """Mark what opens a browser."""
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.browser)


@pytest.fixture(autouse=True)
def places_of_each_test():
    """Places in messages are those of each test's own cases."""
    with own_places():
        yield


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
