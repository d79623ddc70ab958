"""Coordinate reference systems that files of one domain name: without a projection they have to be the same."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, FileError
from bubblemesh.geometry.systems import known_system, same_places
from bubblemesh.readers.degrees import is_geographic
from bubblemesh.readers.features import FeatureCollection

RANGE_OF_DEGREES = np.array([360.0, 90.0])


class _Named(NamedTuple):
    """A file, the system that it names, and the box (2, 2) of its coordinates."""

    file: str
    system: str
    box: Floats


_named: ContextVar[list[_Named] | None] = ContextVar("named", default=None)


@contextmanager
def one_system() -> Iterator[None]:
    """Within the block, refuse files that are in another system than the first one that names its system."""
    token = _named.set([])
    try:
        yield
    finally:
        _named.reset(token)


def require_one_system(path: Path, content: FeatureCollection, points: Floats) -> None:
    """Check that points (n, 2) of a file are in the system of those before it; CaseError if they are surely not.

    Systems that the library does not know, or that it cannot compare since it is not installed, are ignored.
    """
    named = _named.get()
    if named is None or len(points) == 0:
        return
    box = np.array([points.min(axis=0), points.max(axis=0)])
    for first in named[:1]:
        if content.system is None and content.degrees is None:
            _require_metres(first, box)
        elif (
            content.system is not None and content.system != first.system and not _agree(first, content.system, points)
        ):
            raise CaseError(
                f"its coordinates are in {_name(content.system)}, those of {first.file} in {_name(first.system)}: take "
                "one of them to the system of the other by ogr2ogr -t_srs"
            )
    if content.system is not None:
        named.append(_Named(path.name, content.system, box))


def _require_metres(first: _Named, box: Floats) -> None:
    """Refuse a file without a system whose coordinates are in the range of degrees, away from those of a projection."""
    apart = (box[0] > first.box[1]).any() or (box[1] < first.box[0]).any()
    if apart and (np.abs(box) <= RANGE_OF_DEGREES).all() and _is_geographic(first.system) is False:
        raise CaseError(
            f"all of its coordinates are in the range of degrees, and those of {first.file} are in "
            f"{_name(first.system)}: take it to that system by ogr2ogr -t_srs"
        )


def _agree(first: _Named, system: str, points: Floats) -> bool:
    try:
        return same_places(first.system, system, points)
    except (CaseError, FileError):
        return True


def _is_geographic(system: str) -> bool | None:
    try:
        return bool(known_system(system).is_geographic)
    except (CaseError, FileError):
        return is_geographic(system)


def _name(system: str) -> str:
    """Name of a system in messages, with its code if it has one."""
    try:
        known = known_system(system)
    except (CaseError, FileError):
        return system if len(system) < 40 else "another system"
    code = ":".join(known.to_authority() or ())
    return str(known.name) if code in ("", known.name) else f"{known.name} ({code})"
