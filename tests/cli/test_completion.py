"""What the shells are told when somebody presses the tabulator."""

import os
import subprocess
import sys

import pytest
from sweeps import sweep
from typer.testing import CliRunner

from bubblemesh.cli import app, completion
from bubblemesh.meshfiles.formats import FORMATS, FORMATS_FOR
from bubblemesh.packing.methods import METHODS
from bubblemesh.pictures.colouring import QUANTITIES
from bubblemesh.pictures.styles import STYLES

COMMANDS = ["run", "adapt", "batch", "check", "quality", "plot", "convert", "partition", "schema", "init"]


def called(**environment):
    """What the command gives, without any argument, in an environment."""
    return CliRunner().invoke(app, env=environment, prog_name="bubblemesh")


def separately(*arguments, **environment):
    """What it gives as a process of its own."""
    command = [sys.executable, "-m", "bubblemesh", *arguments]
    return subprocess.run(command, env=os.environ | environment, capture_output=True, text=True, check=False)


def at(line):
    """What bash tells of a line whose last word is to be completed."""
    count = len(line.split(" ")) - 1
    return {"COMP_WORDS": line, "COMP_CWORD": str(count), "_BUBBLEMESH_COMPLETE": "complete_bash"}


def in_bash(line):
    """Words that bash is given for a line whose last word is to be completed."""
    found = called(**at(line))
    assert found.stderr == ""
    return found.stdout.split()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("bubblemesh ", COMMANDS),
        ("bubblemesh q", ["quality"]),
        ("bubblemesh run --fo", ["--format", "--for"]),
        ("bubblemesh run plate.yaml --for ", [*FORMATS_FOR]),
        ("bubblemesh adapt --format ms", [name for name in FORMATS if name.startswith("ms")]),
        ("bubblemesh check --method ", [*METHODS]),
        ("bubblemesh plot plate.msh --color ", [*QUANTITIES]),
        ("bubblemesh run pl", []),  # so that the shell completes names of files
    ],
)
def test_bash_is_given_commands_options_and_choices(line, words):
    assert in_bash(line) == words


def test_a_shell_is_given_the_same_by_the_program():
    found = separately(**at("bubblemesh run --fo"))
    assert (found.stdout.split(), found.stderr) == (["--format", "--for"], "")


def test_zsh_and_fish_are_given_choices_and_else_complete_files():
    environment = {"_BUBBLEMESH_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": "bubblemesh run --for fr"}
    assert '"freefem"' in called(**environment).stdout
    environment |= {"_TYPER_COMPLETE_ARGS": "bubblemesh run pl"}
    assert called(**environment).stdout.strip() == "_files"
    environment = {"_BUBBLEMESH_COMPLETE": "complete_fish", "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    found = called(**environment, _TYPER_COMPLETE_ARGS="bubblemesh run --for fr")
    assert found.stdout.split() == ["freefem"]


@pytest.mark.parametrize("shell", sweep(["bash", "zsh", "fish"], quick=1))
def test_the_script_of_a_shell_calls_the_command(shell):
    # Typer asks for the shell's name as the option's value where it may not look for the shell by itself.
    found = separately("--show-completion", shell, _TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION="1")
    assert found.returncode == 0
    assert f"_BUBBLEMESH_COMPLETE=complete_{shell}" in found.stdout
    assert "bubblemesh" in found.stdout.split()


def test_completion_is_installed_in_the_home_folder(tmp_path):
    home = {"HOME": str(tmp_path), "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    found = separately("--install-completion", "bash", **home)
    assert found.returncode == 0
    (script,) = (tmp_path / ".bash_completions").iterdir()
    assert f"source '{script}'" in (tmp_path / ".bashrc").read_text()


def test_words_that_do_not_begin_so_are_left_out():
    assert completion.styles("p") == ["paper"]
    assert completion.styles("") == [*STYLES]
    assert completion.solvers("x") == []
