"""Errors and signals that end a command become a message and an exit code."""

import os
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import typer
from typer.core import TyperGroup

from bubblemesh.errors import INTERRUPTED, OUT_OF_MEMORY, BubblemeshError, FileError, LimitError, missing_library
from bubblemesh.files import MORE_FILES, TOO_MANY_FILES, reason, unwritten
from bubblemesh.messages import printable

SIGNALS = signal.SIGINT, signal.SIGTERM

USAGE_ERRORS = typer.BadParameter.__bases__  # options and arguments that do not fit, which Typer tells of

received: list[int] = []  # signals that ask to end


class Interrupted(BaseException):
    """A signal asks to end.

    Python itself ends a process by its signal, whatever the exit code, once a KeyboardInterrupt has met compiled code.
    """


@contextmanager
def signals_obeyed() -> Iterator[None]:
    """Ctrl-C, or a request to terminate, ends what runs inside with exit code 130 and no half files."""
    for number in SIGNALS:
        signal.signal(number, interrupt)
    sys.unraisablehook = _tell_of_dropped
    try:
        yield
    except Interrupted:  # before a command has begun
        typer.echo("error: interrupted", err=True)
        sys.exit(INTERRUPTED)
    finally:
        # What was asked for is done or given up: the exit code is not to change while Python shuts down.
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Note the signal, and leave whatever is running; what is being told is told to its end (see `heed`)."""
    received.append(number)
    if not _telling():
        raise Interrupted


def _telling() -> bool:
    """Whether a message is on its way to the terminal, which would show no other one if that ended in the middle."""
    console = sys.modules.get("bubblemesh.console")
    return getattr(getattr(console, "terminal", None), "busy", False)


def _tell_of_dropped(what: Any) -> None:
    """Tell of an exception where nobody can catch it, such as in a finalizer, unless it is a signal's (see `heed`)."""
    if what.exc_type is not Interrupted:
        sys.__unraisablehook__(what)


def heed() -> None:
    """Leave after all if a signal could not end what was running, or a library has dropped its exception.

    Pydantic does so between two types, Python in finalizers.
    """
    if received:
        raise Interrupted


@contextmanager
def reported() -> Iterator[None]:
    """Turn errors into a message and the exit code of their class; only an error of the program has a traceback."""
    try:
        yield
    except typer.Exit:
        raise
    except BubblemeshError as error:
        raise failed(str(error), error.exit_code) from None
    except (Interrupted, KeyboardInterrupt):
        raise failed("interrupted", INTERRUPTED) from None
    except MemoryError:
        raise failed(OUT_OF_MEMORY, LimitError.exit_code) from None
    except BrokenPipeError:  # of the standard output: the error stream gives up by itself
        # Whatever is still buffered cannot be delivered; closing the real stream would complain again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise failed("the reader of the standard output has gone", FileError.exit_code) from None
    except Exception as error:
        if received:  # a library that was being loaded may turn the interrupt into any other error
            raise failed("interrupted", INTERRUPTED) from None
        if getattr(error, "errno", None) in TOO_MANY_FILES:
            raise failed(f"{reason(error)}: {MORE_FILES}", FileError.exit_code) from None
        if missing := missing_library(error):
            raise failed(missing, FileError.exit_code) from None
        from bubblemesh import console

        console.tell(traceback.format_exc().rstrip())
        raise failed("this is an error of bubblemesh, not of the case: please report it") from None


def failed(message: str, exit_code: int = BubblemeshError.exit_code) -> typer.Exit:
    """Say why the command ends, and give the exception that ends it."""
    from bubblemesh import console

    console.fail(message)
    return typer.Exit(exit_code)


class Commands(TyperGroup):
    """The commands; what Typer itself writes, messages on options and help, ends as all others do."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Context of the command line as a whole."""
        with _as_ours():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that is named."""
        with _as_ours():
            return super().invoke(ctx)


@contextmanager
def _as_ours() -> Iterator[None]:
    """Have usage errors show what steers a terminal as escapes, and help that cannot be written a message."""
    try:
        yield
    except (BrokenPipeError, SystemExit) as end:
        if getattr(end, "code", 1) != 1:  # with which Rich ends the process where the reader has gone
            raise
        with reported():
            raise BrokenPipeError from None
    except OSError as error:
        with reported():
            raise unwritten("to the standard output", error) from error
    except Exception as error:
        if isinstance(error, USAGE_ERRORS):
            vars(error)["message"] = printable(str(vars(error)["message"]))
        raise
