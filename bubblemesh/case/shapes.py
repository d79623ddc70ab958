"""Rings and lines of a case file: polygons, rectangles, circles, ellipses, paths, and rings of other files."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, ValidationInfo
from pydantic_core import PydanticCustomError

from bubblemesh.case.drawing import DrawnKeys
from bubblemesh.case.fields import (
    Choice,
    Label,
    Number,
    OneLabel,
    Point,
    Positive,
    Strict,
    described,
    list_of,
    not_empty,
)
from bubblemesh.case.geometry_files import FollowedKeys, GeometryFile
from bubblemesh.case.repair import RepairKeys

LONGEST_ELLIPSE = 7e4  # in terms of its width: chords along a longer one cross each other


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

    through: Annotated[tuple[Point, ...], BeforeValidator(not_empty)] = Field(
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


PathEntry = Annotated[
    Annotated[Point, Tag("<point>")]
    | Annotated[LinePiece, Tag("<to>")]
    | Annotated[ArcPiece, Tag("<arc>")]
    | Annotated[SplinePiece, Tag("<spline>")],
    Discriminator(_entry_tag),
    BeforeValidator(_checked_entry),
]


class PathLine(DrawnKeys):
    """A line of straight and curved pieces."""

    path: Annotated[tuple[PathEntry, ...], BeforeValidator(_starting_at_point), BeforeValidator(not_empty)] = Field(
        description="A point, then points, lines, arcs and splines; a ring closes by itself.",
        json_schema_extra={"minItems": 1},
    )
    label: OneLabel = None


class PathRing(PathLine):
    """A ring of lines and curves."""


def _one_per_side(labels: Sequence[str] | None, info: ValidationInfo) -> Sequence[str] | None:
    if labels is None:
        return labels
    if info.data.get("label") is not None:
        raise PydanticCustomError("labels", "and label exclude each other: give one of the two")
    sides = _sides(info.data)
    if sides is not None and len(labels) != sides:
        context = {"labels": len(labels), "sides": sides}
        raise PydanticCustomError("labels", "must be one per side: {labels} labels for {sides} sides", context)
    return labels


def _sides(shape: Mapping[str, Any]) -> int | None:
    """Number of sides; None if the shape itself has an error."""
    if "rectangle" in shape:
        return 4
    points = shape.get("polygon")
    # A polygon may repeat its first point at its end.
    return len(points) - (len(points) > 1 and points[0] == points[-1]) if points else None


SideLabels = Annotated[
    tuple[Label, ...] | None,
    Field(description="One boundary name for each side, the first for the side from the first corner."),
    AfterValidator(_one_per_side),
]


class PolygonRing(FollowedKeys, RepairKeys, DrawnKeys):
    """A polygon; each of its corners is a node, unless `corners` says otherwise."""

    polygon: tuple[Point, ...] = Field(description="Corners [x, y] in order, turning either way.")
    label: OneLabel = None
    labels: SideLabels = None


class RectangleRing(DrawnKeys):
    """A rectangle with sides along the axes."""

    rectangle: Annotated[
        tuple[Number, Number, Number, Number], list_of(4, "the numbers [x0, y0, x1, y1] of two opposite corners")
    ] = Field(description="Two opposite corners as [x0, y0, x1, y1]; its sides are bottom, right, top and left.")
    label: OneLabel = None
    labels: SideLabels = None


class CircleKeys(Strict):
    """Measures of a circle."""

    center: Point = Field(description="Center [x, y].")
    radius: Positive = Field(description="Radius, in the domain's length unit.")


class CircleRing(DrawnKeys):
    """A circle."""

    circle: CircleKeys = Field(description="The circle's center and radius.")
    label: OneLabel = None


def _not_flat(radii: tuple[float, float]) -> tuple[float, float]:
    if max(radii) > LONGEST_ELLIPSE * min(radii):
        text = "must differ by a factor of {most} at most: draw so flat an ellipse as a line, under lines"
        raise PydanticCustomError("flat", text, {"most": f"{LONGEST_ELLIPSE:,.0f}"})
    return radii


class EllipseKeys(Strict):
    """Measures of an ellipse."""

    center: Point = Field(description="Center [x, y].")
    radii: Annotated[tuple[Positive, Positive], list_of(2, "two positive numbers"), AfterValidator(_not_flat)] = Field(
        description="Lengths of the two half axes."
    )
    angle: Number = Field(default=0.0, description="Angle from the x axis to the first half axis, in degrees.")


class EllipseRing(DrawnKeys):
    """An ellipse."""

    ellipse: EllipseKeys = Field(description="The ellipse's center, radii and angle.")
    label: OneLabel = None


class FileRing(GeometryFile):
    """Rings of another file; `outer` takes one, an entry of `holes` all that are chosen."""


Operands = Annotated[
    tuple["RingKeys", ...],
    BeforeValidator(not_empty),
    Field(json_schema_extra={"minItems": 1}),  # checked by `not_empty`
]


class OverlaidKeys(FollowedKeys, DrawnKeys):
    """Keys of a ring that is made of other ones; its sides keep their labels."""

    label: OneLabel = None


class UnionRing(OverlaidKeys):
    """The area that any of several rings encloses."""

    union: Operands = Field(description="Rings that overlap or have sides in common.")


class MinusRing(OverlaidKeys):
    """The area that the first of several rings encloses, and none of the others."""

    minus: Operands = Field(description="A ring, then those that are taken away from it.")


class IntersectionRing(OverlaidKeys):
    """The area that all of several rings enclose."""

    intersection: Operands = Field(description="Rings that overlap.")


RINGS = Choice(
    "a mapping", ("polygon", "rectangle", "circle", "ellipse", "path", "file", "union", "minus", "intersection")
)

# Rings that are not made of other rings.
PlainKeys = RectangleRing | CircleRing | EllipseRing | PathRing | FileRing

RingKeys = Annotated[
    Annotated[PolygonRing, Tag("<polygon>")]
    | Annotated[RectangleRing, Tag("<rectangle>")]
    | Annotated[CircleRing, Tag("<circle>")]
    | Annotated[EllipseRing, Tag("<ellipse>")]
    | Annotated[PathRing, Tag("<path>")]
    | Annotated[FileRing, Tag("<file>")]
    | Annotated[UnionRing, Tag("<union>")]
    | Annotated[MinusRing, Tag("<minus>")]
    | Annotated[IntersectionRing, Tag("<intersection>")],
    Discriminator(RINGS.tag),
    BeforeValidator(RINGS.checked),
]
