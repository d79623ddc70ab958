"""The rings of a case file: one model for each shape, chosen by the key that names it."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
)
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import Choice, Label, Number, OneLabel, Point, Positive, Strict, listed
from bubblemesh.case.files import FileRing
from bubblemesh.case.followed import Traced
from bubblemesh.case.paths import PathRing
from bubblemesh.errors import GeometryError

if TYPE_CHECKING:
    from bubblemesh.geometry import rings

# Each method imports the geometry by itself: it needs SciPy, which `bubblemesh schema` should not wait for.


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


class PolygonRing(Traced, Strict):
    """A polygon; each of its corners is a node, unless `corners` says otherwise."""

    polygon: tuple[Point, ...] = Field(description="Corners [x, y] in order, turning either way.")
    label: OneLabel = None
    labels: SideLabels = None

    def ring(self) -> "rings.Ring":
        """The ring's geometry."""
        from bubblemesh.geometry import rings

        if not self.polygon:
            raise GeometryError("a polygon has no points: give at least three")
        return self.traced(rings.polygon(self.polygon, self.labels, self.label))


class RectangleRing(Strict):
    """A rectangle with sides along the axes."""

    rectangle: Annotated[
        tuple[Number, Number, Number, Number], listed(4, "the numbers [x0, y0, x1, y1] of two opposite corners")
    ] = Field(description="Two opposite corners as [x0, y0, x1, y1]; its sides are bottom, right, top and left.")
    label: OneLabel = None
    labels: SideLabels = None

    def ring(self) -> "rings.Ring":
        """The ring's geometry."""
        from bubblemesh.geometry import rings

        return rings.rectangle(*self.rectangle, labels=self.labels, label=self.label)


class Circle(Strict):
    """Measures of a circle."""

    center: Point = Field(description="Center [x, y].")
    radius: Positive = Field(description="Radius, in the domain's length unit.")


class CircleRing(Strict):
    """A circle."""

    circle: Circle = Field(description="The circle's center and radius.")
    label: OneLabel = None

    def ring(self) -> "rings.Ring":
        """The ring's geometry."""
        from bubblemesh.geometry import rings

        return rings.circle(self.circle.center, self.circle.radius, self.label)


class Ellipse(Strict):
    """Measures of an ellipse."""

    center: Point = Field(description="Center [x, y].")
    radii: Annotated[tuple[Positive, Positive], listed(2, "two positive numbers")] = Field(
        description="Lengths of the two half axes."
    )
    angle: Number = Field(default=0.0, description="Angle from the x axis to the first half axis, in degrees.")


class EllipseRing(Strict):
    """An ellipse."""

    ellipse: Ellipse = Field(description="The ellipse's center, radii and angle.")
    label: OneLabel = None

    def ring(self) -> "rings.Ring":
        """The ring's geometry."""
        from bubblemesh.geometry import rings

        return rings.ellipse(self.ellipse.center, self.ellipse.radii, self.ellipse.angle, self.label)


def rings_of(model: "Ring") -> "list[rings.Ring]":
    """The geometry of one ring, or of all that a file holds."""
    return model.rings() if isinstance(model, FileRing) else [model.ring()]


SHAPES = Choice("a mapping", ("polygon", "rectangle", "circle", "ellipse", "path", "file"))

Ring = Annotated[
    Annotated[PolygonRing, Tag("<polygon>")]
    | Annotated[RectangleRing, Tag("<rectangle>")]
    | Annotated[CircleRing, Tag("<circle>")]
    | Annotated[EllipseRing, Tag("<ellipse>")]
    | Annotated[PathRing, Tag("<path>")]
    | Annotated[FileRing, Tag("<file>")],
    Discriminator(SHAPES.tag),
    BeforeValidator(SHAPES.checked),
]
