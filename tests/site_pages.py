"""Pages of the site as a reader follows them: files are saved under the names that they begin with, shell steps run."""

import os
import re
import subprocess
import sys

BLOCK = re.compile(r"(<!-- setup -->\n)?^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"(?:#|\*\*) ([\w.-]+\.\w+)\n")


def blocks(page):
    """Language and text of each block of a page, but for what sets up the environment."""
    return [(language, text) for setup, language, text in BLOCK.findall(page.read_text(encoding="utf-8")) if not setup]


def followed(page, folder):
    """Do in ``folder`` what the page says, and give (shown, printed) of each block that shows what a step prints."""
    programs = folder / ".bin"
    programs.mkdir()
    for name, module in {"bubblemesh": "-m bubblemesh", "python": ""}.items():
        (programs / name).write_text(f'#!/bin/bash\nexec {sys.executable} {module} "$@"\n')
        (programs / name).chmod(0o755)
    environment = os.environ | {"PATH": f"{programs}:{os.environ['PATH']}", "COLUMNS": "100"}
    printed, pairs = "", []
    for language, text in blocks(page):
        if language == "text":
            pairs.append((text, printed))
        elif language == "sh":
            step = ["bash", "-euo", "pipefail", "-c", text]
            done = subprocess.run(step, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
            assert done.returncode == 0, f"{text}\n{done.stderr}"
            printed = done.stdout
        else:
            name = NAMED.match(text)
            assert name, f"this block of {page.name} does not begin with the name of a file: {text}"
            (folder / name[1]).write_text(text, encoding="utf-8")
    return pairs
