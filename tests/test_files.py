"""Files of users: what is read of them, and what is said of those that cannot be."""

import errno
import io

import pytest

from bubblemesh.errors import CaseError, FileError, LimitError, prefixed
from bubblemesh.files import (
    case_text,
    local_copies,
    local_copy,
    opened,
    read_bytes,
    read_text,
    require_readable,
    unwritten,
)


def test_text_is_utf8_with_or_without_its_mark(tmp_path):
    path = tmp_path / "a.txt"
    for content in ("ä\n".encode(), "ä\n".encode("utf-8-sig")):
        path.write_bytes(content)
        assert read_text(path) == "ä\n"


def test_bytes_that_are_no_text_are_told_with_their_line(tmp_path):
    (tmp_path / "a.txt").write_bytes(b"1\n2\n\xfc\n")
    with pytest.raises(CaseError, match=r"^line 3: not UTF-8 text \(found byte 0xfc\)"):
        read_text(tmp_path / "a.txt")
    (tmp_path / "a.txt").write_bytes(b"1\n" + 50_000_000 * b"\0")
    with pytest.raises(CaseError, match=r"^line 2: not UTF-8 text \(found byte 0x00\)"):
        read_text(tmp_path / "a.txt")
    with pytest.raises(CaseError, match=r"^<stdin>:1: not UTF-8 text"):
        case_text(io.BytesIO(b"\xfc"), "<stdin>")


@pytest.mark.parametrize("name", ["none", "", "a" * 300, "a\0b"])
def test_a_file_that_the_system_does_not_give(tmp_path, name):
    for read in (read_bytes, read_text, opened):
        with pytest.raises(FileError, match=r"^the file cannot be read: \w+"):
            read(tmp_path / name)


def test_a_case_is_read_up_to_a_limit(monkeypatch):
    monkeypatch.setattr("bubblemesh.files.opening.MOST_BYTES", 3)
    assert case_text(io.BytesIO(b"a: "), "a.yaml") == "a: "
    with pytest.raises(LimitError, match=r"^a\.yaml: the case file has more than the 0 MB that are read"):
        case_text(io.BytesIO(b"a: 1"), "a.yaml")


def test_what_a_library_may_open(tmp_path, monkeypatch):
    path = tmp_path / "a.dxf"
    with pytest.raises(FileError, match="No such file"):
        require_readable(path)
    with pytest.raises(FileError, match="it is a folder"):
        require_readable(tmp_path)
    path.write_bytes(b"1234")
    require_readable(path)
    monkeypatch.setattr("bubblemesh.files.opening.MOST_BYTES", 3)
    with pytest.raises(LimitError, match="the file has 0 MB"):
        require_readable(path)


def test_copies_stand_in_for_files_within_their_block(tmp_path):
    here, beside = tmp_path / "a.poly", tmp_path / "a.node"
    with local_copies({str(here): b"there", str(beside): b"too"}):
        assert read_bytes(here) == b"there"
        assert local_copy(here).parent == local_copy(beside).parent
    assert local_copy(here) == here
    with pytest.raises(FileError):
        read_bytes(here)


def test_what_could_not_be_copied_has_its_error(tmp_path):
    here, beside = tmp_path / "a.poly", tmp_path / "a.node"
    here.write_text("it is here by now")
    with local_copies({str(here): FileError("it was not there"), str(beside): b"too"}):
        assert read_bytes(beside) == b"too"
        for path in (here, local_copy(here)):
            with pytest.raises(FileError, match=r"^once: it was not there$"), prefixed("once"):
                read_bytes(path)
    assert read_bytes(here) == b"it is here by now"


def test_a_disk_that_takes_a_part_of_a_file():
    assert str(unwritten("a.msh", OSError(errno.ENOSPC, "No space left"))) == "cannot write a.msh: No space left"
    assert str(unwritten("a.msh", OSError("9 requested and 1 written"))).endswith("written (is the disk full?)")
