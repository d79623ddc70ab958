"""What a benchmark ran on."""

import os
import platform
import shutil
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("bubblemesh", "numpy", "scipy", "pythoncdt", "shapely", "gmsh", "netgen-mesher", "triangle")
PROCESSORS = Path("/proc/cpuinfo")


def machine() -> str:
    """Processor, cores and memory."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return f"{_processor()}, {os.cpu_count()} cores, {memory:.0f} GiB of memory, {platform.system()}"


def versions() -> str:
    """Python and the packages; those that are missing are said to be."""
    found = [f"Python {platform.python_version()}", *map(_version, PACKAGES)]
    return ", ".join([*found, "JIGSAW on the PATH" if shutil.which("jigsaw") else "no JIGSAW found on the PATH"])


def _processor() -> str:
    lines = PROCESSORS.read_text().splitlines() if PROCESSORS.exists() else []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())


def _version(package: str) -> str:
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return f"no {package}"
