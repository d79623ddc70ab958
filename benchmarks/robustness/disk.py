"""A disk that is full from the n-th write on: ``python -m benchmarks.robustness disk``, for every n until all fits.

A small library, compiled here and put before the system's, lets writes into a folder fail: also those of NumPy's
``tofile`` and of HDF5. Whatever the n-th write is, the command ends with exit code 5 and without a traceback, the files
are as they were before, rows of a summary are whole and true, and ``--resume`` finishes a batch when there is room.
"""

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.robustness.commands import command, compiled, damage
from benchmarks.robustness.trials import tell

LIBRARY = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static long count;

static int full(void) {
    const char *from = getenv("FULL_FROM");
    if (!from || __sync_add_and_fetch(&count, 1) < atol(from)) return 0;
    if (count == atol(from)) syscall(SYS_write, 2, "the disk is full\n", 17);
    errno = ENOSPC;
    return 1;
}

static int counts(const char *path) {
    const char *folder = getenv("FULL_FOLDER");
    return folder && strncmp(path, folder, strlen(folder)) == 0;
}

static int refused(int file) {
    char link[64], path[4096];
    struct stat status;
    if (fstat(file, &status) || !S_ISREG(status.st_mode)) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    long length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return counts(path) && full();
}

#define REAL(name) __typeof__(&name) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)
#define FAILS(type, name, signature, values, check, value) \
    type name signature { REAL(name); return (check) ? value : real values; }

FAILS(ssize_t, write, (int f, const void *b, size_t n), (f, b, n), refused(f), -1)
FAILS(ssize_t, pwrite, (int f, const void *b, size_t n, off_t o), (f, b, n, o), refused(f), -1)
FAILS(ssize_t, pwrite64, (int f, const void *b, size_t n, off64_t o), (f, b, n, o), refused(f), -1)
FAILS(ssize_t, writev, (int f, const struct iovec *b, int n), (f, b, n), refused(f), -1)
FAILS(size_t, fwrite, (const void *b, size_t s, size_t n, FILE *f), (b, s, n, f), refused(fileno(f)), 0)
FAILS(int, fsync, (int f), (f), refused(f), -1)
FAILS(int, rename, (const char *a, const char *b), (a, b), b[0] == '/' ? counts(b) && full() : full(), -1)
FAILS(int, mkdir, (const char *p, mode_t m), (p, m), counts(p) && full(), -1)
"""
CASE = """\
domain: {outer: {rectangle: [0, 0, 1, 1]}}
spacing: 0.4
method: accelerated
schedule: {rounds: 1, iterations: 5}
output: {formats: [msh, xdmf, nodes.npz, med]}
"""
COMMANDS = {
    "run": ("run", "a.yaml", "-q", "--history", "--report", "-o", "out/"),
    "batch": ("batch", "a.yaml", "-q", "-j", "1", "--resume", "--report", "-o", "out/"),
}
FULL = "the disk is full"
FILE_ERROR = 5
MOST = 5000  # writes of a command


def trials(kind: str, library: Path, step: int = 1, first: int = 1) -> Iterator[tuple[str, list[str]]]:
    """The write from which on all fail, and what is wrong then; from a first one to that with room for all."""
    for number in range(first, MOST, step):
        with tempfile.TemporaryDirectory(prefix="disk-") as name:
            folder = Path(name).resolve()
            (folder / "a.yaml").write_text(CASE)
            before = _contents(folder, kind)
            code, message, _ = command(folder, *COMMANDS[kind], environment=_full(library, number, folder))
            if FULL not in message:
                yield "room for all", [] if code == 0 else [f"exit code {code}: {message}"]
                return
            problems = [] if code == FILE_ERROR else [f"exit code {code}: {message}"]
            problems += [f"a traceback: {message}"] if "Traceback" in message else []
            after = _contents(folder, kind)
            # Rows that are whole may be there, and files of cases that they tell of.
            problems += (
                [f"{after.keys() ^ before.keys()} have come or gone"] if kind == "run" and after != before else []
            )
            problems += damage(folder, strict=True)
            code, message, _ = command(folder, *COMMANDS["batch"])
            problems += [] if code == 0 else [f"going on ends with {code}: {message}"]
            yield f"write {number}", problems


def _full(library: Path, number: int, folder: Path) -> dict[str, str]:
    return {"LD_PRELOAD": str(library), "FULL_FROM": str(number), "FULL_FOLDER": str(folder)}


def _contents(folder: Path, kind: str) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def main(arguments: list[str]) -> None:
    """Let every write fail, and tell what is wrong afterwards."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kinds", default=",".join(COMMANDS))
    parser.add_argument("--first", type=int, default=1, help="the write to begin with")
    parser.add_argument("--step", type=int, default=1, help="every so many-th write only")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="disk-") as folder:
        library = compiled(Path(folder), LIBRARY)
        tell((f"disk, {kind}", trials(kind, library, options.step, options.first)) for kind in options.kinds.split(","))
