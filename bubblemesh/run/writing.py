"""A case is meshed, and the result is written, within the limits of the case."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, NamedTuple, Protocol

from bubblemesh.case import Case
from bubblemesh.errors import located
from bubblemesh.run.destination import Destination, StreamDestination
from bubblemesh.run.limits import within_limits
from bubblemesh.run.packing import OnRound, OnShare
from bubblemesh.run.pipeline import Result, SlicedResult
from bubblemesh.run.report import RoundRow

Meshing = Callable[[OnRound, OnShare], Result | SlicedResult]


class Watcher(Protocol):
    """One who follows the packing."""

    def show(self, row: RoundRow) -> None:
        """A round has ended."""

    def advance(self, share: float) -> None:
        """A share of the packing is done."""


class Written(NamedTuple):
    """Result of a run, and its report as written."""

    result: Result | SlicedResult
    report: dict[str, Any]


def mesh_and_write(
    meshing: Meshing,
    case: Case,
    source: str,
    place: Destination | StreamDestination,
    watching: AbstractContextManager[Watcher],
) -> Written:
    """Mesh a case and write the result to a place; ``watching`` is entered while it is meshed.

    Whether the mesh is what the case requires is the ``verdict`` of the result. Errors begin with the ``source``, the
    name of the case's file. FileError if the result cannot be written, if possible before the work.
    """

    def written() -> Written:
        with watching as watcher, located(source, case.origin):

            def on_share(share: float) -> None:
                watcher.advance(share)
                place.load()  # while workers pack other parts, if there are any

            result = meshing(watcher.show, on_share)
        return Written(result, place.write_result(result))

    place.require_writable()
    return within_limits(case, written, f"{source}: ")
