"""Solvers that are installed, and how tests run them."""

import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

SECONDS = 300
SYSTEM = {
    "controlDict": "startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1; writeInterval 1;\n",
    "fvSchemes": "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {}\n",
    "fvSolution": "solvers {}\n",
}
ETC = Path("/usr/share/openfoam")  # where Debian keeps what OpenFOAM's programs look for


def run(line, folder, **options):
    """Standard output of a solver that has to succeed."""
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=SECONDS, **options)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


def program(*names):
    """Path of a program; without it the test is skipped."""
    for name in names:
        if shutil.which(name):
            return shutil.which(name)
    pytest.skip(f"{names[0]} is not installed, so that its reading of the files is not tested")


@cache
def python_with(*modules):
    """A Python that has the modules, this one, another one on the path, or the system's; None without."""
    others = [str(Path(folder, "python3")) for folder in os.environ.get("PATH", "").split(os.pathsep)]
    for python in dict.fromkeys((sys.executable, *others, "/usr/bin/python3")):
        code = "import " + ", ".join(modules)
        if Path(python).exists() and subprocess.run([python, "-c", code], capture_output=True).returncode == 0:
            return python
    return None


def mfem_python():
    """A Python with MFEM; without it the test is skipped."""
    python = python_with("mfem.ser")
    if python is None:
        pytest.skip("the Python package mfem is not installed, so that MFEM's reading of the files is not tested")
    return python


def openfoam(folder, lines, system):
    """What OpenFOAM's programs print in a case folder with these files in ``system``."""
    (folder / "system").mkdir()
    for name, text in system.items():
        head = f"FoamFile {{version 2.0; format ascii; class dictionary; object {name};}}\n"
        (folder / "system" / name).write_text(head + text)
    environment = os.environ if "WM_PROJECT_DIR" in os.environ else {**os.environ, "WM_PROJECT_DIR": str(ETC)}
    return run(["bash", "-ec", lines], folder, env=environment)
