"""``~`` at the start of paths: the home folder, as shells have it."""

from pathlib import Path

import pytest

import bubblemesh
from bubblemesh.files import with_home
from bubblemesh.run.output import OutputOptions, destination

RING = "x,y\n0,0\n1,0\n0,1\n"


@pytest.fixture
def home(tmp_path, monkeypatch):
    folder = tmp_path / "h{o}me"
    (folder / "work").mkdir(parents=True)
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(folder))
    monkeypatch.chdir(tmp_path)
    (folder / "ring.csv").write_text(RING)
    return folder


@pytest.mark.parametrize("path", ["a/~", "./~/a", "~no such user/a", "~a\0b/c", ""])
def test_other_paths_are_as_they_were(path, home):
    assert with_home(path) == path


@pytest.mark.parametrize("keys", ["{file: ~/ring.csv}", "{outer: {file: ~/ring.csv}}"])
def test_files_and_folders_of_a_case_may_be_in_the_home_folder(keys, home):
    (home / "base.yaml").write_text(f"domain: {keys}\nspacing: 0.3\noutput: {{directory: ~/out}}\n")
    (home / "work" / "case.yaml").write_text("base: ~/base.yaml\n")
    case = bubblemesh.load_case("~/work/case.yaml")
    assert destination(case, "case.yaml", OutputOptions()).folder == home / "out"
    mesh = bubblemesh.mesh_case(case).mesh
    mesh.write("~/mesh.vtu")
    assert bubblemesh.Mesh.read("~/mesh.vtu").points.shape == mesh.points.shape
    assert [path.name for path in Path().iterdir()] == ["h{o}me"]
