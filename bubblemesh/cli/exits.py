"""Messages and exit codes for the errors and signals that end a command."""

import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import wraps
from types import FrameType
from typing import Any

import typer
from typer.core import TyperGroup

from bubblemesh.errors import INTERRUPTED, OUT_OF_MEMORY, BubblemeshError, FileError, LimitError, RequirementError
from bubblemesh.files import outer_cause, unwritten
from bubblemesh.messages import printable

SIGNALS = signal.SIGINT, signal.SIGTERM

USAGE_ERRORS = typer.BadParameter.__bases__  # errors of Typer on wrong options and arguments

# Words for a command that other programs use.
OTHER_WORDS = {
    "run": ("mesh", "generate", "make", "build", "pack"),
    "check": ("validate", "verify", "lint"),
    "quality": ("info", "stats", "compare", "report"),
    "plot": ("draw", "view", "show"),
    "convert": ("export",),
    "partition": ("split", "divide"),
    "adapt": ("refine", "remesh"),
    "batch": ("sweep",),
    "init": ("new", "template"),
}
CASE_ENDINGS = ".yaml", ".yml", ".json"

received: list[int] = []  # signals that ask to end


class Interrupted(BaseException):
    """A signal asks to end.

    It is not a KeyboardInterrupt: after one that has passed through compiled code, Python ends the process by the
    signal, whatever the exit code.
    """


@contextmanager
def signals_obeyed() -> Iterator[None]:
    """Within the block, Ctrl-C or a request to terminate ends the process with exit code 130, without half files."""
    for number in SIGNALS:
        signal.signal(number, interrupt)
    sys.unraisablehook = _tell_of_dropped
    try:
        yield
    except Interrupted:  # before a command has begun
        typer.echo("error: interrupted", err=True)
        sys.exit(INTERRUPTED)
    finally:
        # The work is done or given up: the exit code must not change while Python shuts down.
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Note the signal, and leave whatever is running; a message that is being printed is finished (see `heed`)."""
    received.append(number)
    if not _telling():
        raise Interrupted


def _telling() -> bool:
    """Whether a message is being printed: the terminal would stay silent if that ended in the middle."""
    console = sys.modules.get("bubblemesh.console")
    return getattr(getattr(console, "terminal", None), "busy", False)


def _tell_of_dropped(what: Any) -> None:
    """Print an exception that nobody can catch, such as in a finalizer, unless it is that of a signal (see `heed`)."""
    if what.exc_type is not Interrupted:
        sys.__unraisablehook__(what)


def heed() -> None:
    """Raise the exception of a signal now, if it could not be raised before or was dropped by a library.

    Pydantic drops exceptions when it tries several types, Python does so in finalizers.
    """
    if received:
        raise Interrupted


def reporting(command: Callable[..., None]) -> Callable[..., None]:
    """The command, with `reported` errors."""

    @wraps(command)
    def reporting_command(**arguments: Any) -> None:
        with reported(arguments.get("as_json", False)):
            command(**arguments)

    return reporting_command


@contextmanager
def reported(as_json: bool = False) -> Iterator[None]:
    """Turn errors into a message and the exit code of their class; only an error of the program has a traceback.

    With ``as_json`` the standard output gets both as well, if it has not got a report before.
    """
    try:
        yield
    except typer.Exit:
        raise
    except RequirementError as error:  # of what has a report
        raise failed(str(error), error.exit_code) from None
    except BubblemeshError as error:
        raise failed(str(error), error.exit_code, as_json) from None
    except (Interrupted, KeyboardInterrupt):
        raise failed("interrupted", INTERRUPTED) from None
    except MemoryError:
        raise failed(OUT_OF_MEMORY, LimitError.exit_code, as_json) from None
    except BrokenPipeError:  # of the standard output: the error stream drops its messages by itself
        _drop_output()
        raise failed("the reader of the standard output has gone", FileError.exit_code) from None
    except Exception as error:
        if received:  # a library that was being loaded may have turned the interrupt into any error
            raise failed("interrupted", INTERRUPTED) from None
        if outer := outer_cause(error):
            raise failed(str(outer), outer.exit_code, as_json) from None
        from bubblemesh import console

        console.tell(traceback.format_exc().rstrip())
        told = "this is an error of bubblemesh, not of the case: please report it"
        raise failed(told, as_json=as_json) from None


def _drop_output() -> None:
    """What is still buffered cannot be written, and closing the real stream would raise the error again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def failed(message: str, exit_code: int = BubblemeshError.exit_code, as_json: bool = False) -> typer.Exit:
    """Print why the command ends, and return the exception that ends it."""
    from bubblemesh import console

    console.fail(message)
    if as_json:
        from bubblemesh.cli.stdio import write_json

        with suppress(BubblemeshError, BrokenPipeError):  # of a standard output that cannot be written
            write_json({"exit_code": exit_code, "error": message})
    return typer.Exit(exit_code)


class Commands(TyperGroup):
    """The commands; errors while Typer itself writes, messages on options and help, end as all others do."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Context of the command line as a whole."""
        with _as_ours():
            return super().make_context(*arguments, **options)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is named; the error for a word that is none proposes one."""
        try:
            return super().resolve_command(ctx, args)
        except Exception as error:
            if isinstance(error, USAGE_ERRORS) and (meant := _meant_by(args)) is not None:
                vars(error)["message"] = f"No such command {args[0]!r}. Did you mean {meant!r}?"
            raise

    def invoke(self, ctx: Any) -> Any:
        """Run the command that is named."""
        with _as_ours():
            return super().invoke(ctx)


def _meant_by(words: Sequence[str]) -> str | None:
    """What was probably meant by words that begin with no command: one of another name, or a case to run."""
    word = words[0].lower()
    if word.endswith(CASE_ENDINGS):
        return f"bubblemesh run {words[0]}"
    return next((command for command, others in OTHER_WORDS.items() if word in others), None)


@contextmanager
def _as_ours() -> Iterator[None]:
    """Within the block, print control characters in usage errors as escapes, and report help that cannot be written."""
    try:
        yield
    except (BrokenPipeError, SystemExit) as end:
        if getattr(end, "code", 1) != 1:  # the code with which Rich ends the process if its reader has gone
            raise
        _drop_output()  # in silence: who reads the first lines of a help or a table alone has what was asked for
        raise typer.Exit(FileError.exit_code) from None
    except OSError as error:
        with reported():
            raise unwritten("to the standard output", error) from error
    except Exception as error:
        if isinstance(error, USAGE_ERRORS):
            vars(error)["message"] = printable(str(vars(error)["message"]))
        raise
