"""The path ring of a case file: a point, then lines and curves."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import Choice, OneLabel, Point, Strict, described, filled


class LinePiece(Strict):
    """A straight line of a path."""

    to: Point = Field(description="End [x, y] of the line.")
    label: OneLabel = None


class ArcKeys(Strict):
    """Measures of a circular arc."""

    to: Point = Field(description="End [x, y] of the arc.")
    center: Point = Field(description="Center [x, y] of the arc's circle.")
    turn: Literal["left", "right"] = Field(description="left runs counter-clockwise, right clockwise.")


class ArcPiece(Strict):
    """A circular arc of a path."""

    arc: ArcKeys = Field(description="The arc's end, center and turn.")
    label: OneLabel = None


class SplineKeys(Strict):
    """Measures of a spline."""

    through: Annotated[tuple[Point, ...], BeforeValidator(filled)] = Field(
        description="Points [x, y] that the spline passes; the last is its end.", json_schema_extra={"minItems": 1}
    )


class SplinePiece(Strict):
    """A cubic spline of a path."""

    spline: SplineKeys = Field(description="The spline's points.")
    label: OneLabel = None


PIECES = Choice("a point [x, y], or a mapping", ("to", "arc", "spline"))


def _checked_entry(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else PIECES.checked(value)


def _entry_tag(value: Any) -> str:
    return "<point>" if isinstance(value, list | tuple) else PIECES.tag(value)


def _starting_at_point(value: Any) -> Any:
    if isinstance(value, list | tuple) and value and not isinstance(value[0], list | tuple):
        context = {"found": described(value[0])}
        raise PydanticCustomError("start", "must begin with a point [x, y] (found {found})", context)
    return value


Entry = Annotated[
    Annotated[Point, Tag("<point>")]
    | Annotated[LinePiece, Tag("<to>")]
    | Annotated[ArcPiece, Tag("<arc>")]
    | Annotated[SplinePiece, Tag("<spline>")],
    Discriminator(_entry_tag),
    BeforeValidator(_checked_entry),
]


class PathLine(Strict):
    """A line of straight and curved pieces."""

    path: Annotated[tuple[Entry, ...], BeforeValidator(_starting_at_point), BeforeValidator(filled)] = Field(
        description="A point, then points, lines, arcs and splines; a ring closes by itself.",
        json_schema_extra={"minItems": 1},
    )
    label: OneLabel = None


class PathRing(PathLine):
    """A ring of lines and curves."""
