"""The domain of a case file: its rings, its regions, and the lines and points embedded in it."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import (
    Choice,
    InputFile,
    Label,
    Number,
    OneLabel,
    Point,
    Positive,
    Strict,
    described,
    filled,
    listed,
)
from bubblemesh.case.spacing import SpacingValue
from bubblemesh.readers.selection import Unit

SidePair = Annotated[tuple[Label, Label], listed(2, "a pair of labels")]


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
    """Number of sides; None where the shape is itself in error."""
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


class FollowedKeys(Strict):
    """Keys by which the straight sides of a ring are followed as curves."""

    corners: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=180)] | None = Field(
        default=None, description="Only vertices that turn by more degrees are nodes; the rest is spaced anew."
    )
    smooth: bool = Field(default=False, description="With corners: follow a spline through the vertices between them.")
    tolerance: Positive | None = Field(
        default=None, description="With corners: largest distance of the mesh from the ring as given."
    )

    @field_validator("smooth", "tolerance")
    @classmethod
    def _with_corners(cls, value: Any, info: ValidationInfo) -> Any:
        if value and info.data.get("corners", 0.0) is None:
            raise PydanticCustomError("traced", "needs corners: give the angle above which vertices stay nodes")
        return value


class PolygonRing(FollowedKeys):
    """A polygon; each of its corners is a node, unless `corners` says otherwise."""

    polygon: tuple[Point, ...] = Field(description="Corners [x, y] in order, turning either way.")
    label: OneLabel = None
    labels: SideLabels = None


class RectangleRing(Strict):
    """A rectangle with sides along the axes."""

    rectangle: Annotated[
        tuple[Number, Number, Number, Number], listed(4, "the numbers [x0, y0, x1, y1] of two opposite corners")
    ] = Field(description="Two opposite corners as [x0, y0, x1, y1]; its sides are bottom, right, top and left.")
    label: OneLabel = None
    labels: SideLabels = None


class CircleKeys(Strict):
    """Measures of a circle."""

    center: Point = Field(description="Center [x, y].")
    radius: Positive = Field(description="Radius, in the domain's length unit.")


class CircleRing(Strict):
    """A circle."""

    circle: CircleKeys = Field(description="The circle's center and radius.")
    label: OneLabel = None


class EllipseKeys(Strict):
    """Measures of an ellipse."""

    center: Point = Field(description="Center [x, y].")
    radii: Annotated[tuple[Positive, Positive], listed(2, "two positive numbers")] = Field(
        description="Lengths of the two half axes."
    )
    angle: Number = Field(default=0.0, description="Angle from the x axis to the first half axis, in degrees.")


class EllipseRing(Strict):
    """An ellipse."""

    ellipse: EllipseKeys = Field(description="The ellipse's center, radii and angle.")
    label: OneLabel = None


def _one_or_more(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


def _feature(value: Any) -> Any:
    whole = isinstance(value, int) and not isinstance(value, bool) and value >= 0
    if not whole and not (isinstance(value, dict) and value):
        raise PydanticCustomError("feature", "must be a number from 0 on, or a property with its value")
    return value


class GeometryFile(FollowedKeys):
    """A file with rings, and what to take of it."""

    file: InputFile = Field(description="Name of the file, relative to the case file.")
    layer: Annotated[tuple[str, ...], BeforeValidator(_one_or_more)] = Field(
        default=(), description="Layer to read, or a list of layers; all by default."
    )
    feature: Annotated[int | dict[str, Any] | None, BeforeValidator(_feature)] = Field(
        default=None, description="Number of the feature from 0, or a property with its value such as {name: Corsica}."
    )
    units: Unit | None = Field(default=None, description="The file's unit of length, for a case in metres.")
    scale: Positive | None = Field(default=None, description="Factor from the file's lengths to the case's.")
    join: Positive | None = Field(
        default=None, description="Ends of curves nearer to each other than this meet, in the file's lengths."
    )
    label: OneLabel = None

    @field_validator("scale")
    @classmethod
    def _without_units(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None and info.data.get("units") is not None:
            raise PydanticCustomError("scale", "and units exclude each other: give one of the two")
        return value


class FileRing(GeometryFile):
    """Rings of another file; `outer` takes one, an entry of `holes` all that are chosen."""


RINGS = Choice("a mapping", ("polygon", "rectangle", "circle", "ellipse", "path", "file"))

RingKeys = Annotated[
    Annotated[PolygonRing, Tag("<polygon>")]
    | Annotated[RectangleRing, Tag("<rectangle>")]
    | Annotated[CircleRing, Tag("<circle>")]
    | Annotated[EllipseRing, Tag("<ellipse>")]
    | Annotated[PathRing, Tag("<path>")]
    | Annotated[FileRing, Tag("<file>")],
    Discriminator(RINGS.tag),
    BeforeValidator(RINGS.checked),
]


class RegionKeys(Strict):
    """A part of the domain with a name, and a spacing of its own if it is given one."""

    name: Label = Field(description="Name of the region in the mesh files.")
    ring: RingKeys = Field(description="The ring around the region; what lies outside the domain is left out.")
    spacing: SpacingValue | None = Field(default=None, description="Wanted edge length in the region.")


class EmbeddedLine(PathLine):
    """A line inside the domain that edges of the mesh follow: a crack, a wire."""


class EmbeddedPoint(Strict):
    """A point inside the domain that is a node of the mesh: a well, a sensor."""

    at: Point = Field(description="The point [x, y].")
    label: OneLabel = None


class InnerKeys(Strict):
    """Keys of a domain beside its rings."""

    regions: tuple[RegionKeys, ...] = Field(default=(), description="Parts of the domain with names of their own.")
    region: Label = Field(default="domain", description="Name of the domain, or of what regions leave of it.")
    lines: tuple[EmbeddedLine, ...] = Field(default=(), description="Lines that edges of the mesh follow.")
    periodic: tuple[SidePair, ...] = Field(default=(), description="Pairs of labels of sides whose nodes match.")
    points: tuple[EmbeddedPoint, ...] = Field(default=(), description="Points that are nodes of the mesh.")


class RingDomain(InnerKeys):
    """The domain: one outer ring with holes, regions, and what is embedded."""

    outer: RingKeys = Field(description="The ring around the domain.")
    holes: tuple[RingKeys, ...] = Field(default=(), description="Rings inside the outer one, not meshed within.")


class FileDomain(GeometryFile, InnerKeys):
    """The area that the rings of another file bound, with regions and what is embedded."""

    hole_label: OneLabel = None


DOMAINS = Choice("a mapping", ("outer", "file"))

DomainKeys = Annotated[
    Annotated[RingDomain, Tag("<outer>")] | Annotated[FileDomain, Tag("<file>")],
    Discriminator(DOMAINS.tag),
    BeforeValidator(DOMAINS.checked),
]
