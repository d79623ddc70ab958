"""Temporary folders: those of killed processes go when the next one is made, those of living ones stay."""

import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from bubblemesh.files import temporary_folder
from bubblemesh.meshfiles.transaction import transaction

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such locks")

OWNER = """
import sys, time
from pathlib import Path
from bubblemesh.files import temporary_folder
with temporary_folder(Path(sys.argv[1]), sys.argv[2]) as folder:
    (folder / "data").mkdir()
    (folder / "data" / "mesh").write_text("half")
    print(folder, flush=True)
    time.sleep(60)
"""


@pytest.fixture
def owner(tmp_path):
    """Function that starts a process with a temporary folder; gives both."""
    started = []

    def start(prefix="bubblemesh-"):
        process = subprocess.Popen([sys.executable, "-c", OWNER, tmp_path, prefix], stdout=subprocess.PIPE, text=True)
        started.append(process)
        return process, Path(process.stdout.readline().strip())

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stdout.close()


def kill(process):
    process.send_signal(signal.SIGKILL)
    process.wait()


def test_a_folder_of_a_killed_process_is_removed_and_that_of_a_living_one_stays(owner, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    killed, left = owner()
    _, living = owner()
    (tmp_path / "bubblemesh-of-the-user").mkdir()
    kill(killed)
    assert left.exists()
    with temporary_folder() as mine:
        assert not left.exists()
        assert (living / "data/mesh").read_text() == "half"
        with temporary_folder():
            assert mine.exists()
    assert {path.name for path in tmp_path.iterdir()} == {living.name, "bubblemesh-of-the-user"}


def test_a_staging_folder_beside_results_is_removed_by_the_next_run(owner, tmp_path):
    killed, _ = owner(".bubblemesh-")
    _, living = owner(".bubblemesh-")
    kill(killed)
    with transaction(tmp_path) as staging:
        (staging / "a.msh").write_text("mesh")
    assert {path.name for path in tmp_path.iterdir()} == {living.name, "a.msh"}


def test_a_link_in_place_of_a_folder_is_not_followed(owner, tmp_path):
    killed, left = owner(".other-")
    kill(killed)
    (tmp_path / "bubblemesh-link").symlink_to(left)
    with temporary_folder(tmp_path):
        assert (left / "data/mesh").exists()
