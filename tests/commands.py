"""The command line run inside the tests, and what it may not do to the files around it."""

from contextlib import chdir
from types import SimpleNamespace

from typer.testing import CliRunner

from bubblemesh.cli import app


def contents(folder):
    """Names and bytes of all files below a folder, and the names of the folders."""
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def command(*arguments, stdin=None):
    """Exit code, standard output and standard error of a command, which may not end in a traceback."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], input=stdin)
    assert "Traceback" not in result.stderr, result.stderr
    assert result.exit_code != 1, result.stderr
    return result.exit_code, result.stdout, result.stderr


def within(*arguments, folder):
    """Run a command in ``folder``, as a process of its own would, its streams as bytes; this is sooner done."""
    with chdir(folder):
        result = CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "200"})
    return SimpleNamespace(returncode=result.exit_code, stdout=result.stdout_bytes, stderr=result.stderr_bytes)


def refused(folder, text, exit_code, *options, check=True):
    """The message of a case that `run` and `check` refuse with the exit code, without touching a file.

    A message names the case, then the place, and what to do about it comes last.
    """
    (folder / "case.yaml").write_text(text, encoding="utf-8")
    before = contents(folder)
    code, out, message = command("run", "case.yaml", "-o", "out", *options)
    assert (code, out) == (exit_code, ""), message
    assert message.startswith("error: case.yaml"), message
    if check:
        assert command("check", "case.yaml", *options) == (exit_code, "", message)
    assert contents(folder) == before
    return message
