"""The help of all commands as Markdown: the second half of the site's page on commands."""

from typer.testing import CliRunner

from bubblemesh.cli import app

WIDTH = 96  # characters that a line of the site has room for


def command_options() -> str:
    """A section for each command, with its help as the terminal shows it."""
    names = [command.name or getattr(command.callback, "__name__", "") for command in app.registered_commands]
    sections = (f"### {name}\n\n```text\n{_help(name)}\n```\n" for name in names)
    return "\n".join(["## All options", "", "What `bubblemesh COMMAND --help` prints.", "", *sections])


def _help(name: str) -> str:
    printed = CliRunner().invoke(
        app, [name, "--help"], prog_name="bubblemesh", env={"COLUMNS": str(WIDTH), "TERMINAL_WIDTH": str(WIDTH)}
    )
    if printed.exit_code:
        raise SystemExit(f"bubblemesh {name} --help ends with exit code {printed.exit_code}")
    return "\n".join(line.rstrip() for line in printed.stdout.strip("\n").splitlines())
