"""The path ring of a case file: a point, then lines and curves."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import Choice, OneLabel, Point, Strict, described, filled

if TYPE_CHECKING:
    from bubblemesh.geometry import rings


class LinePiece(Strict):
    """A straight line of a path."""

    to: Point = Field(description="End [x, y] of the line.")
    label: OneLabel = None

    def piece(self) -> "rings.LineTo":
        """The line's geometry."""
        from bubblemesh.geometry import rings

        return rings.LineTo(self.to, self.label)


class Arc(Strict):
    """Measures of a circular arc."""

    to: Point = Field(description="End [x, y] of the arc.")
    center: Point = Field(description="Center [x, y] of the arc's circle.")
    turn: Literal["left", "right"] = Field(description="left runs counter-clockwise, right clockwise.")


class ArcPiece(Strict):
    """A circular arc of a path."""

    arc: Arc = Field(description="The arc's end, center and turn.")
    label: OneLabel = None

    def piece(self) -> "rings.ArcTo":
        """The arc's geometry."""
        from bubblemesh.geometry import rings

        return rings.ArcTo(self.arc.to, self.arc.center, self.arc.turn == "left", self.label)


class Spline(Strict):
    """Measures of a spline."""

    through: Annotated[tuple[Point, ...], BeforeValidator(filled)] = Field(
        description="Points [x, y] that the spline passes; the last is its end.", json_schema_extra={"minItems": 1}
    )


class SplinePiece(Strict):
    """A cubic spline of a path."""

    spline: Spline = Field(description="The spline's points.")
    label: OneLabel = None

    def piece(self) -> "rings.SplineTo":
        """The spline's geometry."""
        from bubblemesh.geometry import rings

        return rings.SplineTo(self.spline.through, self.label)


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

    def pieces(self) -> "tuple[tuple[float, float], list[rings.LineTo | rings.ArcTo | rings.SplineTo]]":
        """The first point, and the geometry of the pieces from there."""
        from bubblemesh.geometry import rings

        start, *rest = self.path
        assert isinstance(start, tuple)
        return start, [rings.LineTo(entry) if isinstance(entry, tuple) else entry.piece() for entry in rest]


class PathRing(PathLine):
    """A ring of lines and curves."""

    def ring(self) -> "rings.Ring":
        """The ring's geometry."""
        from bubblemesh.geometry import rings

        return rings.path(*self.pieces(), self.label)
