"""Quantities with units in a case whose coordinates are places on the earth: 200 m, 5 km2, 12.42 h."""

import re
from typing import Literal

from bubblemesh.errors import CaseError

Dimension = Literal["length", "area", "time"]

UNITS: dict[Dimension, dict[str, float]] = {
    "length": {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3, "nmi": 1852.0, "in": 0.0254, "inch": 0.0254, "ft": 0.3048},
    "area": {"m2": 1.0, "ha": 1e4, "km2": 1e6},
    "time": {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0},
}
DIMENSIONS: dict[str, Dimension] = {unit: kind for kind, units in UNITS.items() for unit in units}
TOO_SMALL = ("um", "µm", "μm", "nm", "mil")  # units that are known for what they are, and not read on the earth
QUANTITY = re.compile(r"((?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?) ?([a-zµμ]+2?)")

QUANTITY_WITHIN = re.compile(rf"(?<![\w.]){QUANTITY.pattern}(?!\w)")


def quantity_within(text: str) -> re.Match[str] | None:
    """The first number with a unit within a longer text, if there is one."""
    found = (one for one in QUANTITY_WITHIN.finditer(text) if one[2] in DIMENSIONS)
    return next(found, None)


def is_quantity(text: str) -> bool:
    """Whether a text is a number with a unit."""
    found = QUANTITY.fullmatch(text)
    return found is not None and (found[2] in DIMENSIONS or found[2] in TOO_SMALL)


def value_of(text: str, dimension: Dimension | None, *, allowed: bool) -> float:
    """Value of a quantity in metres, square metres or seconds.

    CaseError if units are not allowed, or if it is of another dimension than is wanted; None is any.
    """
    found = QUANTITY.fullmatch(text)
    assert found is not None
    number, unit = float(found[1]), found[2]
    if not allowed:
        raise CaseError(
            f"{text} has a unit: give the number alone, in the unit of the coordinates; units are for places on the "
            "earth, with crs: {from: EPSG:4326}"
        )
    kind = DIMENSIONS.get(unit)
    if kind is None or dimension not in (None, kind):
        wanted = dimension or "length"
        raise CaseError(f"{text} is no {wanted}: give one in {', '.join(UNITS[wanted])}")
    return number * UNITS[kind][unit]
