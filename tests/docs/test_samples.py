"""Generated files under version control: few, small, and made by a command."""

import importlib.util
import subprocess

import pytest
from paths import ROOT

from bubblemesh.meshfiles.formats import FORMATS

MOST_BYTES = 3_000_000
MOST_BYTES_OF_A_PICTURE = 60_000
GENERATED = ("sample_outputs", "docs/figures")


@pytest.fixture(scope="module")
def tracked():
    """Paths of all generated files that are under version control."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", *GENERATED], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("this is no checkout of the repository")
    return [ROOT / name for name in listed.stdout.split("\0") if name]


@pytest.fixture(scope="module")
def make():
    """The script that makes the samples."""
    spec = importlib.util.spec_from_file_location("make_samples", ROOT / "sample_outputs/make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_generated_files_are_small(tracked):
    sizes = {path: path.stat().st_size for path in tracked if path.exists()}
    assert sum(sizes.values()) <= MOST_BYTES
    pictures = {path: size for path, size in sizes.items() if path.suffix in (".png", ".svg")}
    assert len(pictures) > 10
    assert [path for path, size in pictures.items() if size > MOST_BYTES_OF_A_PICTURE] == []


def test_there_is_one_small_mesh_in_every_format(tracked):
    names = [path.name for path in tracked if path.parent.name == "files"]
    for form in FORMATS.values():
        for ending in form.files:
            assert any(name.endswith(ending) for name in names), ending


@pytest.mark.long
def test_a_sample_is_made(make, tmp_path):
    row = make.sample(make.QUICKSTART, tmp_path)
    assert "configs/quickstart.yaml" in row
    content = (tmp_path / "plate.png").read_bytes()
    assert content.startswith(b"\x89PNG")
    assert len(content) <= MOST_BYTES_OF_A_PICTURE
    assert row in (ROOT / "sample_outputs/README.md").read_text()


@pytest.mark.long
def test_every_format_is_made(make, tracked, tmp_path):
    make.every_format(make.QUICKSTART, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {p.name for p in tracked if p.parent.name == "files"}
