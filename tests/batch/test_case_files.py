"""Which case files the paths of a command line mean."""

import errno
import os

import pytest
from batch_cases import write
from batches import (
    SMALL,
)

from bubblemesh.batch import case_files
from bubblemesh.errors import CaseError, FileError


@pytest.fixture
def tree(here):
    write(here, b=SMALL, a=SMALL, sub__c=SMALL, sub__deep__d=SMALL, _base=SMALL, sub___e=SMALL, _private__f=SMALL)
    write(here, **{".hidden": SMALL, ".git__g": SMALL})
    (here / "sub/h.yml").write_text(SMALL)
    (here / "notes.txt").write_text("no case")
    (here / "z").mkdir()
    return here


@pytest.mark.parametrize(
    ("paths", "expected"),
    [
        (["."], ["a.yaml", "b.yaml", "sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml"]),
        (["sub", "a.yaml"], ["sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml", "a.yaml"]),
        (["*.yaml"], ["_base.yaml", "a.yaml", "b.yaml"]),
        (["**/[cd].yaml"], ["sub/c.yaml", "sub/deep/d.yaml"]),
        (["s*"], ["sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml"]),
        (
            ["b.yaml", "./b.yaml", ".", "sub/../a.yaml"],
            ["b.yaml", "a.yaml", "sub/c.yaml", "sub/h.yml", "sub/deep/d.yaml"],
        ),
        (["_base.yaml", "notes.txt"], ["_base.yaml", "notes.txt"]),  # who is named is meant
        (["missing.yaml"], ["missing.yaml"]),  # a case that fails
    ],
)
def test_folders_patterns_and_names_mean_these_files(paths, expected, tree):
    assert case_files(paths) == expected


def test_a_link_to_a_folder_is_followed_where_it_is_named_only(tree):
    (tree / "z/link").symlink_to(tree / "sub/deep")
    (tree / "z/x.yaml").write_text(SMALL)
    assert case_files(["z"]) == ["z/x.yaml"]
    assert case_files(["z/link"]) == ["z/link/d.yaml"]


def test_a_file_whose_name_looks_like_a_pattern_is_that_file(here):
    write(here, **{"a[1]": SMALL, "a1": SMALL})
    assert case_files(["a[1].yaml"]) == ["a[1].yaml"]


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("z", "z: no case file is in this folder: their names end in .yaml or .yml"),
        ("*.json", r"\*.json: no file fits this pattern"),
        ("z*", r"z\*: no file fits"),
        ("-", "use bubblemesh run -"),
    ],
)
def test_nothing_to_mesh_is_an_error(path, message, tree):
    with pytest.raises(CaseError, match=message):
        case_files([path, "a.yaml"])


def test_a_folder_that_cannot_be_read_is_an_error(tree, monkeypatch):
    def refuse(path):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(os, "scandir", refuse)
    with pytest.raises(FileError, match="sub: the folder cannot be read: Permission denied"):
        case_files(["sub"])
