"""The terminal and what its displays share; all goes to the error stream, which leaves the output to data."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Self

from rich.console import Console, ConsoleOptions, Group, RenderableType
from rich.live import Live
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from bubblemesh.messages import printable


class Terminal(Console):
    """A console to which only its own styles speak: what steers a terminal in a text is shown as an escape.

    It is ``busy`` while it prints: an exception then would leave it silent.
    """

    busy = False

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


terminal = Terminal(stderr=True, highlight=False, soft_wrap=True)


def warn(messages: Sequence[str]) -> None:
    """Tell of compromises that the user should know of."""
    for message in messages:
        _print_after("warning: ", "yellow", message)


def fail(message: str) -> None:
    """Tell why the command ends without what it was asked for."""
    _print_after("error: ", "bold red", message)


def _print_after(kind: str, style: str, message: str) -> None:
    # Further lines are set in: a line break in a file's name makes no message of its own.
    terminal.print(Text.assemble((kind, style), message.replace("\n", "\n  ")))


def tell(text: str) -> None:
    """Show lines as they are."""
    terminal.print(Text(text))


def new_table(**options: Any) -> Table:
    """A table without columns and frame, as all tables of the terminal begin."""
    return Table(box=None, header_style="bold", pad_edge=False, **options)


class Display:
    """A picture that is drawn anew while something runs inside of it; only on a terminal, and not if it is quiet.

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
