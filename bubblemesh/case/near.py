"""Spacing of a case file that grows with the distance from a label, a point or a line."""

from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import LARGEST, Choice, Label, Point, Positive, Strict

__all__ = ["Near", "NearLabel", "NearLine", "NearPoint"]


class Growing(Strict):
    """Spacing near something."""

    size: Positive = Field(description="Spacing there.")
    growth: Positive | None = Field(
        default=None, description="Growth per length away from it: by default that of the mapping, else 0.2."
    )
    until: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=LARGEST)] = Field(
        default=0.0, description="Distance up to which the spacing stays at its size."
    )


class NearLabel(Growing):
    """Spacing near all that has a label."""

    label: Label = Field(description="Label of sides, interfaces, embedded lines or points.")


class NearPoint(Growing):
    """Spacing near a point, which need be no node."""

    point: Point = Field(description="The point [x, y].")


def _long(line: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if len(set(line)) < 2:
        raise PydanticCustomError("line", "must have two different points at least")
    return line


class NearLine(Growing):
    """Spacing near a line, which edges of the mesh need not follow."""

    line: Annotated[tuple[Point, ...], AfterValidator(_long)] = Field(
        description="Points [x, y] with straight lines between them."
    )


PLACES = Choice("a mapping", ("label", "point", "line"))

Near = Annotated[
    Annotated[NearLabel, Tag("<label>")] | Annotated[NearPoint, Tag("<point>")] | Annotated[NearLine, Tag("<line>")],
    Discriminator(PLACES.tag),
    BeforeValidator(PLACES.checked),
]
