"""Streams that fail: messages are given up, data are not."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from batches import SMALL

from bubblemesh.cli.stdio import Expendable

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="there is no device that is always full")


@pytest.fixture
def here(tmp_path):
    (tmp_path / "cases").mkdir()
    for name in ("a", "b", "c"):
        (tmp_path / f"cases/{name}.yaml").write_text(SMALL)
    return tmp_path


def gone():
    """A pipe whose reader has gone."""
    reader, writer = os.pipe()
    os.close(reader)
    return writer


def hung_up():
    """A terminal that has been closed."""
    master, terminal = pty.openpty()
    os.close(master)
    return terminal


def full():
    return os.open(FULL, os.O_WRONLY)


def ended(folder, *arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
    """Exit code of a command whose streams are those file descriptors."""
    command = [sys.executable, "-m", "bubblemesh", *arguments]
    try:
        return subprocess.run(command, cwd=folder, stdout=stdout, stderr=stderr, timeout=120).returncode
    finally:
        for stream in {stdout, stderr} - {subprocess.DEVNULL}:
            os.close(stream)


LOST = [pytest.param(full, marks=needs_full), gone, hung_up]


@pytest.mark.long
@pytest.mark.parametrize("stream", LOST)
def test_a_run_goes_on_without_its_messages(stream, here):
    assert ended(here, "run", "cases/a.yaml", "-o", "out", stderr=stream()) == 0
    assert {path.name for path in (here / "out").iterdir()} == {"a.msh", "a.report.json"}


@pytest.mark.long
@pytest.mark.parametrize("stream", LOST)
def test_a_batch_goes_on_without_its_messages(stream, here):
    (here / "cases/wrong.yaml").write_text("spacing: 1\n")
    assert ended(here, "batch", "cases", "-o", "out", "-j", "1", stderr=stream()) == 2
    assert {path.stem for path in (here / "out").glob("*.msh")} == {"a", "b", "c"}


@pytest.mark.long
@needs_full
@pytest.mark.parametrize(("arguments", "exit_code"), [(["run", "no.yaml"], 5), (["run"], 2), (["check", "-"], 2)])
def test_a_failure_keeps_its_exit_code(arguments, exit_code, here):
    assert ended(here, *arguments, stderr=full()) == exit_code


@pytest.mark.long
@pytest.mark.parametrize("stream", LOST[:2])
def test_a_mesh_that_cannot_be_delivered_is_a_failure_even_without_messages(stream, here):
    output = stream()
    assert ended(here, "run", "cases/a.yaml", "-o", "-", stdout=output, stderr=output) == 5


@pytest.mark.long
@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--show-completion"], ["check", "cases/a.yaml"]])
@pytest.mark.parametrize(("stream", "lines"), [pytest.param(full, 1, marks=needs_full), (gone, 0)])
def test_text_that_cannot_be_delivered_is_a_failure_with_a_message_unless_its_reader_has_gone(
    stream, lines, arguments, here
):
    messages, writer = os.pipe()
    assert ended(here, *arguments, stdout=stream(), stderr=writer) == 5
    with os.fdopen(messages) as told:
        assert told.read().count("\n") == lines


@pytest.mark.long
def test_a_table_takes_any_encoding_and_tells_that_there_is_no_output(here):
    check = [sys.executable, "-m", "bubblemesh", "check", "cases/a.yaml"]
    text = "name: naïve\ndomain: {outer: {circle: {center: [0, 0], radius: 1}, label: größe}}\nspacing: 0.3\n"
    (here / "cases/a.yaml").write_text(text, encoding="utf-8")
    ascii_only = os.environ | {"PYTHONIOENCODING": "ascii"}
    assert (
        b"gr\\xf6\\xdfe" in subprocess.run(check, cwd=here, env=ascii_only, stdout=subprocess.PIPE, check=True).stdout
    )
    closed = subprocess.run(["sh", "-c", '"$@" >&-', "sh", *check], cwd=here, stderr=subprocess.PIPE, check=False)
    assert (closed.returncode, closed.stderr) == (5, b"error: the standard output is closed\n")


def test_what_was_buffered_is_given_up_as_well(tmp_path):
    reader, writer = os.pipe()
    with os.fdopen(writer, "w") as stream:
        expendable = Expendable(stream)
        assert expendable.write("not yet on its way") == 18
        os.close(reader)
        expendable.flush()
        assert expendable.write("and more\n") == 9
        assert expendable.fileno() == writer
    assert stream.closed
