"""Pages of the site as a reader follows them: files are saved under the names that they begin with, steps run.

A page may say, in a remark before a block, that the block is not to be run: ``<!-- setup -->`` for what sets up the
environment, ``<!-- not run: why -->`` for what takes more than a folder and this package, ``<!-- needs: NAME -->`` for
what takes a program or a module, which is run where it is installed.
"""

import os
import re
import shutil
import subprocess
import sys
from contextlib import chdir, redirect_stdout
from importlib.util import find_spec
from io import StringIO
from typing import NamedTuple

BLOCK = re.compile(r"(?:^<!-- ([a-z ]+)(?:: ?(.+?))? -->\n)?^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"(?:#|\*\*) ([\w./-]+\.\w+)\n")


class Block(NamedTuple):
    """A fenced block of a page, with the mark before it."""

    mark: str  # setup, not run, needs, or nothing
    detail: str  # what comes after the mark: a reason, or a name
    language: str
    text: str

    @property
    def name(self):
        """Name of the file that it shows; None if it is not one."""
        found = NAMED.match(self.text)
        return found and found[1]

    @property
    def runs(self):
        """Whether a reader of the page can do it on this machine."""
        there = self.mark == "needs" and (shutil.which(self.detail) or find_spec(self.detail))
        return bool(there) or self.mark in ("", "begin", "end")


def all_blocks(page):
    """All fenced blocks of a page."""
    return [Block(*(part or "" for part in parts)) for parts in BLOCK.findall(page.read_text(encoding="utf-8"))]


def blocks(page):
    """Language and text of each block of a page that is to be run."""
    return [(block.language, block.text) for block in all_blocks(page) if block.runs]


def followed(page, folder):
    """Do in ``folder`` what the page says, and give (shown, printed) of each block that shows what a step prints.

    Programs without a name are parts of one session. Parts of cases, which have no name, are left to the reader.
    """
    programs = folder / ".bin"
    programs.mkdir()
    for name, module in {"bubblemesh": "-m bubblemesh", "python": ""}.items():
        (programs / name).write_text(f'#!/bin/bash\nexec {sys.executable} {module} "$@"\n')
        (programs / name).chmod(0o755)
    environment = os.environ | {"PATH": f"{programs}:{os.environ['PATH']}", "COLUMNS": "100"}
    printed, pairs, session = "", [], {"__name__": "session"}
    for block in all_blocks(page):
        if not block.runs:
            continue
        if block.name:
            (folder / block.name).parent.mkdir(exist_ok=True)
            (folder / block.name).write_text(block.text, encoding="utf-8")
        elif block.language == "text":
            pairs.append((block.text, printed))
        elif block.language == "sh":
            step = ["bash", "-euo", "pipefail", "-c", block.text]
            done = subprocess.run(step, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
            assert done.returncode == 0, f"{block.text}\n{done.stderr}"
            printed = done.stdout or done.stderr
        elif block.language == "python":
            with chdir(folder), redirect_stdout(StringIO()) as out:
                exec(compile(block.text, page.name, "exec"), session)
            printed = out.getvalue()
        else:
            assert block.language == "yaml", f"what is this block of {page.name}? {block.text}"
    return pairs
