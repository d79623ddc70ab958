"""What docs/solvers.md shows: its code blocks, and its cases meshed as it says."""

import re
import subprocess
import sys

from paths import ROOT
from solver_programs import SECONDS

PAGE = (ROOT / "docs" / "solvers.md").read_text()


def blocks(heading, language):
    """Code blocks of a section of the page."""
    (section,) = re.findall(rf"^## {heading}\n(.*?)(?=^## |\Z)", PAGE, flags=re.DOTALL | re.MULTILINE)
    return re.findall(rf"```{language}\n(.*?)```", section, flags=re.DOTALL)


def commands(heading):
    """Runs of the command line that a section names."""
    (section,) = re.findall(rf"^## {heading}\n(.*?)(?=^## |\Z)", PAGE, flags=re.DOTALL | re.MULTILINE)
    return re.findall(r"`bubblemesh (run disc\.yaml .*?)`", section)


def prepare(heading, folder, *more):
    """Write the case of the page and run the command of a section."""
    (command,) = commands(heading)
    meshed(folder, *command.split()[1:], *more)


def meshed(folder, case, *options):
    """Write the page's cases and mesh one of them."""
    for text in re.findall(r"```yaml\n(# .*?)```", PAGE, flags=re.DOTALL):
        (folder / text[2:].split()[0]).write_text(text)
    line = [sys.executable, "-m", "bubblemesh", "run", case, *options, "--quiet"]
    subprocess.run(line, cwd=folder, check=True, capture_output=True, timeout=SECONDS)
