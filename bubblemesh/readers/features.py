"""What every reader makes of a file: features with areas, closed rings and curves that may form rings."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.errors import CaseError
from bubblemesh.geometry.rings import ArcTo, LineTo, Ring, SplineTo
from bubblemesh.labels import FORBIDDEN, is_writable
from bubblemesh.messages import place

# Fourth powers of coordinates, which the triangulation's predicates take, must stay finite.
LARGEST = 1e70

SHOWN = 80  # characters

Point = tuple[float, float]
Piece = LineTo | ArcTo | SplineTo


class Stroke(NamedTuple):
    """A curve from ``start`` along ``pieces``, closed or a part of a ring; ``name`` is what messages call it."""

    start: Point
    pieces: tuple[Piece, ...]
    name: str

    @property
    def end(self) -> Point:
        return end_of(self.pieces[-1])


@dataclass(frozen=True)
class Feature:
    """One thing of a file.

    Attributes
    ----------
    name : str
        What messages call it.
    layer : str or None
    properties : mapping
        By which a case may choose it.
    areas : tuple of tuple of Ring
        Outer rings, each with its holes.
    rings : tuple of Ring
        Closed curves; how they nest tells which are holes.
    strokes : tuple of Stroke
        Curves that form rings together.
    notes : tuple of str
        On what was left out of it.
    """

    name: str
    layer: str | None = None
    properties: Mapping[str, Any] = field(default_factory=dict)
    areas: tuple[tuple[Ring, ...], ...] = ()
    rings: tuple[Ring, ...] = ()
    strokes: tuple[Stroke, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Content:
    """The features of a file, notes on what was changed or left out, and points (k, 2) that mark holes, if it has any.

    ``unit`` is the unit of length that the file names.
    """

    features: tuple[Feature, ...]
    notes: tuple[str, ...] = ()
    holes: tuple[Point, ...] | None = None
    unit: str | None = None


def end_of(piece: Piece) -> Point:
    """The point at which a piece ends."""
    x, y = piece.through[-1] if isinstance(piece, SplineTo) else piece.to
    return float(x), float(y)


def checked(points: Sequence[Sequence[float]], name: str) -> list[Point]:
    """The points as pairs of numbers, z left out.

    Raises
    ------
    CaseError
        If a coordinate is no finite number.
    """
    try:
        array = np.array([(point[0], point[1]) for point in points], float).reshape(-1, 2)
    except (TypeError, ValueError, IndexError):
        raise CaseError(f"{name}: coordinates must be pairs of numbers") from None
    bad = np.flatnonzero(~(np.abs(array) <= LARGEST).all(axis=1))
    if len(bad):
        k = int(bad[0])
        raise CaseError(
            f"{name}: point {k + 1} at {place(array[k])}: coordinates must be finite and at most {LARGEST:g}"
        )
    return [(x, y) for x, y in array.tolist()]


def label_of(properties: Mapping[str, Any], *keys: str) -> str | None:
    """The text or number of the first of the keys, in any case, that has one."""
    values = {str(key).lower(): value for key, value in properties.items()}
    for key in keys:
        text = _as_text(values.get(key))
        if text:
            return text
    return None


def feature_name(number: int, properties: Mapping[str, Any], *keys: str) -> str:
    """What messages call a feature: its number, and the first of the keys that has a short printable value."""
    shown = label_of(properties, *keys)
    return (
        f"feature {number} ({shown})" if shown and shown.isprintable() and len(shown) <= SHOWN else f"feature {number}"
    )


def _as_text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}" if math.isfinite(value) else ""
    return str(value).strip() if isinstance(value, str | int) and not isinstance(value, bool) else ""


def fitting(label: str | None, name: str) -> tuple[str | None, tuple[str, ...]]:
    """The label if mesh files can hold it; else none, and a note."""
    if label is None or is_writable(label):
        return label, ()
    return None, (f"{name}: {label[:40]!r} is no label, since it is too long or has {FORBIDDEN} in it",)


def line(points: Sequence[Point], name: str, label: str | None = None) -> Stroke:
    """The stroke of straight lines through ``points``, at least two."""
    return Stroke(points[0], tuple(LineTo(point, label) for point in points[1:]), name)
