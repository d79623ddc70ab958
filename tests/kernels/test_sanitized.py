"""The compiled kernels under sanitizers, which end a test where memory is misused or the result is undefined in C."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import bubblemesh.kernels.library as kernels

SOURCE = Path(kernels.__file__).parent / "source"
HERE = Path(__file__).parent
TESTS = [
    "kernels/test_kernels_fuzz.py",
    "kernels/test_annealed.py",
    "kernels/test_bulge_distances.py",
    "kernels/test_ellipses.py",
    "kernels/test_enclosing.py",
    "kernels/test_linking.py",
    "kernels/test_lookup.py",
    "kernels/test_patches.py",
    "kernels/test_refining.py",
    "kernels/test_relaxing.py",
    "kernels/test_shapes.py",
]
TESTS += ["kernels/test_metric_grading.py", "kernels/test_hilbert.py", "kernels/test_spreading.py"]
TESTS += ["geometry/distance/test_nearest_chord.py"]
TESTS += ["packing/ellipses/test_ellipse_annealing.py", "packing/test_neighbours.py"]
CODE = """
import sys
import bubblemesh.kernels.library as kernels
sanitized = kernels.find_spec("bubblemesh.kernels.library")
sanitized.origin = sys.argv[1]
kernels.find_spec = lambda name: sanitized
import pytest
options = ["-q", "-x", "-s", "-p", "no:xdist", "-p", "no:cacheprovider", "-m", "", "-k", "not no_chord_is_nearer"]
sys.exit(pytest.main([*options, *sys.argv[2:]]))
"""
compiler = shutil.which("gcc")


def compiled(target, *sources):
    """A library of C files, with sanitizers."""
    flags = ["-std=c99", "-g", "-O1", "-ffp-contract=off", "-fno-omit-frame-pointer", "-shared", "-fPIC"]
    sanitizers = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    headers = [f"-I{sysconfig.get_path('include')}", f"-I{SOURCE}"]
    subprocess.run([compiler, *flags, *sanitizers, *headers, *sources, "-o", target, "-lm"], check=True)
    return target


def sanitizer():
    """Path of the library that has to be loaded before all others."""
    return subprocess.run([compiler, "-print-file-name=libasan.so"], capture_output=True, text=True).stdout.strip()


needs_sanitizers = pytest.mark.skipif(
    compiler is None or not Path(sanitizer()).is_absolute() or not sys.platform.startswith("linux"),
    reason="there is no gcc with sanitizers here",
)


def run(library, *arguments):
    environment = os.environ | {"LD_PRELOAD": sanitizer(), "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1"}
    command = [sys.executable, "-c", CODE, library, *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, cwd=HERE.parent)


@pytest.mark.long
@needs_sanitizers
def test_sanitizers_find_nothing_in_the_kernels(tmp_path):
    done = run(compiled(tmp_path / "kernels.so", *SOURCE.glob("*.c")), *TESTS)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert set(done.stdout.strip()) == {"."}  # none is skipped


@pytest.mark.long
@needs_sanitizers
def test_sanitizers_notice_a_step_beyond_an_array(tmp_path):
    """The kernel of gradients, made to write beside its work, does not pass."""
    text = (SOURCE / "shapes.c").read_text()
    assert "SUMS * n + 1" in text
    (tmp_path / "shapes.c").write_text(text.replace("SUMS * n + 1", "SUMS * n - 1"))
    others = [path for path in SOURCE.glob("*.c") if path.name != "shapes.c"]
    done = run(compiled(tmp_path / "kernels.so", tmp_path / "shapes.c", *others), "kernels/test_shapes.py")
    assert done.returncode != 0
    assert "heap-buffer-overflow" in done.stderr + done.stdout
