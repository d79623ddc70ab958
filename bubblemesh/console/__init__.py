"""The terminal, and what its displays share.

Messages and progress go to the error stream. The standard output is for what a command is run for: data, and the tables
of commands that make nothing else.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from io import TextIOWrapper
from typing import Any, Self

from rich.console import Console, ConsoleOptions, Group, RenderableType
from rich.live import Live
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from bubblemesh.errors import FileError
from bubblemesh.files import unwritten
from bubblemesh.messages import printable


class Terminal(Console):
    """A console with styles of its own only: texts are shown as they are, control characters in them as escapes.

    It is ``busy`` while it prints: an exception at that time would leave it silent. The options are those of
    `rich.console.Console`.
    """

    busy = False

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, highlight=False, soft_wrap=True, **options)

    def print(self, *objects: Any, **options: Any) -> None:
        """Print as `rich.console.Console` does."""
        self.busy = True
        try:
            super().print(*objects, **options)
        finally:
            self.busy = False

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        """Pieces of text with their styles."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else printable(text), style, control)


class StandardOutput(Terminal):
    """The standard output, for tables: what cannot be encoded is shown as escapes."""

    def print(self, *objects: Any, **options: Any) -> None:
        """Print as a terminal does; FileError if the standard output is closed or cannot be written."""
        if sys.stdout is None:
            raise FileError("the standard output is closed")
        if isinstance(sys.stdout, TextIOWrapper):
            sys.stdout.reconfigure(errors="backslashreplace")
        try:
            super().print(*objects, **options)
        except BrokenPipeError:
            raise
        except OSError as error:
            raise unwritten("to the standard output", error) from error


terminal = Terminal(stderr=True)
output = StandardOutput()


def warn(messages: Sequence[str]) -> None:
    """Print warnings."""
    for message in messages:
        _print_after("warning: ", "yellow", message)


def fail(message: str) -> None:
    """Print the error that ends a command."""
    _print_after("error: ", "bold red", message)


def _print_after(kind: str, style: str, message: str) -> None:
    # Further lines are indented, so that a line break in a file's name does not look like a new message.
    terminal.print(Text.assemble((kind, style), message.replace("\n", "\n  ")))


def tell(text: str) -> None:
    """Print lines as they are."""
    terminal.print(Text(text))


def new_table(**options: Any) -> Table:
    """A table without columns and frame, in the common style of the terminal."""
    return Table(box=None, header_style="bold", pad_edge=False, **options)


class Display:
    """Lines that are drawn again and again while the block runs; only on a terminal, and not if it is quiet.

    ``heed`` is called as the work goes on, and may end it by an exception. The options are those of `rich.live.Live`,
    which asks for the first picture at once.
    """

    def __init__(self, quiet: bool, heed: Callable[[], None] = lambda: None, **options: Any) -> None:
        self.quiet = quiet
        self.heed = heed
        self.ended = False
        live = Live(get_renderable=self.picture, console=terminal, **options)
        self.live = live if terminal.is_terminal and not quiet else None

    def picture(self) -> Group:
        """The lines to draw now."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        if self.live is not None:
            self.live.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.ended = True
        if self.live is not None:
            self.live.stop()
