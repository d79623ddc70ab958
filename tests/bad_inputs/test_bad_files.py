"""Files and folders that cannot be read or written: an error with its place, and nothing lost."""

import errno
import io
import os
import re
import resource
import signal
import subprocess
import sys

import pytest
from bad_cases import SQUARE
from commands import command, contents, refused

from bubblemesh.case import load_case
from bubblemesh.readers.formats import FORMATS
from bubblemesh.run import destination, pipeline
from bubblemesh.run.pipeline import mesh_case

BOMB = "\n".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9 if i else 'x' * 9)}]" for i in range(20))


YAML = {
    "domain: [1\n": (2, "case.yaml:2: not valid YAML", "check the indentation"),
    SQUARE.format(1) + "spacin: 1\n": (2, "case.yaml:3: spacin: unknown key", "did you mean 'spacing'"),
    SQUARE.format(1) + "spacing: 1\n": (2, "case.yaml:3: the key 'spacing' is given twice", "first in line 2"),
    SQUARE.format("!!python/object:os.system x"): (2, "case.yaml:2: the tag", "remove it"),
    SQUARE.format("&a [*a]"): (2, "case.yaml:2: the alias *a is inside its own anchor", "write the values out"),
    "[" * 10_000: (2, "case.yaml:1: nested more than 100 deep", "a case needs far less"),
    BOMB: (2, "more than 5,000,000 values", "use fewer"),
    SQUARE.format(1) + "packing: {efort: best}\n": (2, "case.yaml:3: packing.efort", "'effort'"),
    SQUARE.format(1) + "packing: {effort: most}\n": (2, "case.yaml:3: packing.effort", "best"),
    SQUARE.format(1) + "method: bpm\npacking: {effort: best}\n": (2, "case.yaml:4: packing.effort", "bpm"),
    SQUARE.format(1) + "method: multilvl\n": (2, "case.yaml:3: method", "multilevel"),
    SQUARE.format(1) + 'output: {directory: "a\\0b"}\n': (2, "case.yaml:3: a null character in a text", "remove it"),
    "base: nowhere.yaml\n": (5, "case.yaml:1: base: nowhere.yaml: the case file cannot be read", "No such file"),
    "base: case.yaml\n": (2, "case.yaml:1: base: case.yaml extends itself", "remove one"),
    "": (2, "case.yaml:1: the file is empty", "give at least domain and spacing"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "answer"), YAML.items(), ids=[key[:30] for key in YAML])
def test_a_case_file_that_is_none(here, text, answer):
    code, place, advice = answer
    message = refused(here, text, code)
    assert place in message
    assert advice in message
    assert len(message) < 1500


@pytest.mark.parametrize("name", [".", "nowhere.yaml", "", "a" * 300, "case.yaml/x"])
def test_a_case_that_cannot_be_read(here, name):
    (here / "case.yaml").write_text(SQUARE.format(1))
    code, out, message = command("run", name)
    assert (code, out) == (5, "")
    assert message.startswith("error: ")
    assert "the case file cannot be read: " in message


NO_FILE = "it is no regular file, but a pipe or a device"
SOURCES = {
    **{ending: f"domain: {{file: pipe{ending}}}\nspacing: 0.1\n" for ending in FORMATS},
    **{
        f"{kind} {ending}": SQUARE.format(f"{{{kind}: {{file: pipe{ending}{keys}}}}}")
        for kind, ending, keys in (
            ("field", ".vtu", ""),
            ("field", ".msh", ""),
            ("field", ".ele", ""),
            ("raster", ".npy", ""),
            ("raster", ".npz", ""),
            ("image", ".png", ", bounds: [0, 0, 1, 1], finest: 0.1, coarsest: 0.2"),
            ("scattered", ".csv", ""),
        )
    },
    "base": "base: pipe\n",
}


@pytest.mark.parametrize("source", SOURCES)
def test_a_pipe_is_not_waited_for(here, source):
    os.mkfifo(re.search(r"pipe(\.\w+)?", SOURCES[source]).group())
    assert NO_FILE in refused(here, SOURCES[source], 5)


@pytest.mark.parametrize(
    ("name", "exit_code"),
    [
        ("/", 2),
        (".", 2),
        ("..", 2),
        ("/dev/zero", 5),
        ("/dev/tty", 5),
        ("sub/", 5),
        ("a" * 300, 5),
        ("a" * 300 + "/b", 5),
    ],
)
def test_a_file_that_is_none(here, name, exit_code):
    """Its name has no ending, or nothing else, and may not fit into the system."""
    (here / "sub").mkdir()
    field = refused(here, SQUARE.format(f'{{field: {{file: "{name}"}}}}'), exit_code)
    domain = refused(here, f'domain: {{file: "{name}"}}\nspacing: 0.1\n', exit_code)
    shapes = refused(here, f'domain: {{file: "{name}.shp"}}\nspacing: 0.1\n', 5)
    assert all(name.rstrip("/") in message for message in (field, domain, shapes))


@pytest.mark.parametrize("number", ["0x" + "f" * 5000, "0o" + "7" * 5000, "9" * 5000, "0b" + "1" * 5000])
@pytest.mark.parametrize("text", ["{}", "{} * x", "[{}]", "{{value: {}}}", "{{nodes: {}}}"])
def test_numbers_of_thousands_of_digits(here, text, number):
    assert len(refused(here, SQUARE.format(text.format(number)), 2)) < 1500


def test_a_pipe_or_a_device_is_no_case_file(here):
    os.mkfifo("pipe")
    for name in ("pipe", "/dev/zero"):
        code, _, message = command("run", name)
        assert code == 5
        assert f"{name}: the case file cannot be read: {NO_FILE}" in message
        assert "bubblemesh run -" in message
    for arguments in (("adapt", "case.yaml", "--solution", "pipe"), ("quality", "pipe"), ("plot", "pipe")):
        (here / "case.yaml").write_text(SQUARE.format(1))
        code, _, message = command(*arguments)
        assert code == 5
        assert f"pipe: the file cannot be read: {NO_FILE}" in message
        assert "bubblemesh run -" not in message


@pytest.mark.parametrize(
    "arguments",
    [
        ("quality", "a.msh", "a.msh"),
        ("partition", "a.msh", "2"),
        ("plot", "a.msh", "-o", "a.png"),
        ("adapt", "case.yaml", "--solution", "a.msh"),
    ],
)
def test_only_who_opens_a_file_tells_that_it_cannot_be_read(here, monkeypatch, arguments):
    (here / "case.yaml").write_text(SQUARE.format(1))
    for name in ("a.msh", "a.png"):
        (here / name).touch()
    monkeypatch.setattr(os, "access", lambda path, mode, **options: mode != os.R_OK)
    assert command(*arguments) == (5, "", "error: a.msh: is empty\n")


@pytest.mark.parametrize("arguments", [("quality",), ("partition", "2"), ("plot",)])
def test_a_mesh_on_the_standard_input_is_told_to_be_written_to_a_file(here, arguments):
    code, _, message = command(arguments[0], "-", *arguments[1:], stdin="")
    assert code == 5
    assert "-: a mesh is not read from the standard input: write it to a file" in message


SMALL = SQUARE.format(0.5) + "output: {formats: [msh, xdmf]}\npacking: {effort: fast}\n"


@pytest.mark.parametrize(
    ("output", "text"),
    [
        ("case.yaml/out/", "cannot write into case.yaml/out: Not a directory"),
        ("case.yaml/a.msh", "cannot write into case.yaml: it is not a folder"),
        ("old", "cannot write into old: it is not a folder"),
        ("link/", "cannot write into link: it is a symbolic link that leads nowhere"),
        ("round/", "cannot write into round: it is a symbolic link that leads nowhere"),
        ("full/", "cannot write full/case.msh: something that is not a file has this name"),
        ("a" * 300 + "/", "is too long a name: shorten it"),
        ("/proc/new/", "cannot write into /proc/new: "),
    ],
)
def test_a_place_that_cannot_be_written_is_told_before_the_work(here, monkeypatch, output, text):
    monkeypatch.setattr("bubblemesh.run.pipeline.prepare", None)
    (here / "case.yaml").write_text(SMALL)
    (here / "old").write_text("old")
    (here / "link").symlink_to("nowhere/at/all")
    (here / "round").symlink_to("round")
    (here / "full/case.msh").mkdir(parents=True)
    before = contents(here)
    code, out, message = command("run", "case.yaml", "-q", "-o", output)
    assert (code, out) == (5, "")
    assert text in message
    assert contents(here) == before


def test_a_picture_that_cannot_be_written_is_told_before_the_mesh_is_read(here):
    (here / "old").write_text("old")
    assert command("plot", "no.msh", "-o", "old/a.png") == (5, "", "error: cannot write into old: it is not a folder\n")


@pytest.mark.parametrize(
    ("name", "output"),
    [("漢" * 82, ()), ("é" * 200, ()), ("case", ("-o", "漢" * 82 + ".msh")), ("case", ("-o", "a" * 300 + ".msh"))],
)
def test_a_name_with_too_many_bytes_is_told_before_the_work(here, monkeypatch, name, output):
    monkeypatch.setattr("bubblemesh.run.pipeline.prepare", None)
    (here / "case.yaml").write_text(f"{SMALL}name: {name}\n")
    code, _, message = command("run", "case.yaml", "-q", *output)
    assert code == 2
    assert "files up to 255: shorten it" in message
    code, _, message = command("batch", "case.yaml", "-q", "-o", "a" * 300)
    assert code == 5
    assert "is too long a name: shorten it" in message


@pytest.mark.parametrize("name", ["case.msh", "case.xdmf", "case.report.json"])
def test_what_is_in_the_way_of_a_file_is_told_before_the_work(here, monkeypatch, name):
    monkeypatch.setattr("bubblemesh.run.pipeline.prepare", None)
    (here / "case.yaml").write_text(SMALL)
    (here / "full" / name).mkdir(parents=True)
    code, _, message = command("run", "case.yaml", "-q", "-o", "full/")
    assert (code, message) == (
        5,
        f"error: cannot write full/{name}: something that is not a file has this name\n",
    )


def test_a_missing_folder_is_made(here):
    (here / "case.yaml").write_text(SMALL)
    assert command("run", "case.yaml", "-q", "-o", "a/b/c/") == (0, "", "")
    assert (here / "a/b/c/case.msh").is_file()


class Faults:
    """Makes the file operation of a given number below a folder fail."""

    def __init__(self, folder, number, error):
        self.folder, self.number, self.error, self.count, self.failed = str(folder), number, error, 0, None

    def over(self, function, name):
        def wrapped(*args, **kwargs):
            path = str(args[0]) if args else ""
            writes = name != "open" or any(letter in str(args[1:2]) + kwargs.get("mode", "") for letter in "wxa+")
            there = name == "mkdir" and os.path.isdir(path)  # noqa: PTH112 - which os.mkdir is asked about again
            if path.startswith(self.folder) and writes and not there:
                self.count += 1
                if self.count == self.number:
                    self.failed = name
                    raise OSError(self.error, os.strerror(self.error), path)
            return function(*args, **kwargs)

        return wrapped


@pytest.mark.long
@pytest.mark.parametrize("error", [errno.EACCES, errno.ENOSPC])
@pytest.mark.parametrize("old", [True, False])
def test_whatever_fails_while_writing_old_files_stay_and_no_half_ones_are_left(here, monkeypatch, error, old):
    (here / "case.yaml").write_text(SMALL)
    result = mesh_case(load_case(here / "case.yaml"))
    monkeypatch.setattr(pipeline, "mesh_case", lambda *args, **options: result)
    # The look before the work goes another way if its first one fails.
    monkeypatch.setattr(destination, "require_writable", lambda folder, names: None)
    if old:
        assert command("run", "case.yaml", "-q", "-o", "out/")[0] == 0
    before = contents(here)
    operations = []
    for number in range(1, 100):
        faults = Faults(here / "out", number, error)
        with monkeypatch.context() as patched:
            for module, name in ((os, "mkdir"), (os, "replace"), (io, "open"), (os, "link")):
                patched.setattr(module, name, faults.over(getattr(module, name), name))
            code, _, message = command("run", "case.yaml", "-q", "-o", str(here / "out"))
        operations.append(faults.failed)
        if faults.failed in (None, "link"):  # a file system without links
            assert code == 0
            assert before.keys() <= contents(here).keys()
            if faults.failed is None:
                break
        else:
            assert code == 5, (faults.failed, message)
            assert os.strerror(error) in message
            assert "out" in message
            if "link" not in operations:
                assert contents(here) == before
            assert not [name for name in contents(here) if "bubblemesh-" in name]
    assert operations[-1] is None
    assert {"mkdir", "open", "replace"} <= set(operations)
    assert ("link" in operations) == old


@pytest.mark.long
@pytest.mark.parametrize("arguments", [["run", "case.yaml", "-q", "-o", "out"], ["init", "new.yaml"]])
def test_a_disk_that_is_full(here, arguments):
    (here / "case.yaml").write_text(SMALL)
    assert command("run", "case.yaml", "-q", "-o", "out")[0] == 0
    before = contents(here)

    def no_room():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))

    process = subprocess.run(
        [sys.executable, "-m", "bubblemesh", *arguments],
        capture_output=True,
        text=True,
        preexec_fn=no_room,
        check=False,
    )
    assert process.returncode == 5, process.stderr
    assert "Traceback" not in process.stderr
    assert process.stderr.startswith("error: ")
    assert contents(here) == before


@pytest.mark.parametrize("formats", ["[msh, msh]", "[msh, vtu, msh]"])
def test_the_same_output_named_twice(here, formats):
    (here / "case.yaml").write_text(SMALL.replace("[msh, xdmf]", formats))
    before = contents(here)
    code, _, message = command("run", "case.yaml")
    assert code == 2
    assert "output.formats: msh is there twice" in message
    assert contents(here) == before
