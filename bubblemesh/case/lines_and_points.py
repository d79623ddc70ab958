"""Lines and points embedded in the domain of a case file, drawn there or taken from other files."""

from typing import Annotated

from pydantic import BeforeValidator, Discriminator, Field, Tag

from bubblemesh.case.drawing import DrawnKeys, OutsideKeys
from bubblemesh.case.fields import Choice, OneLabel, Point, Positive, Strict, Text
from bubblemesh.case.geometry_files import FollowedKeys, SelectedFile
from bubblemesh.case.shapes import PathLine


class JoinedKeys(Strict):
    """Key of lines whose ends may miss what they should meet."""

    join: Positive | None = Field(
        default=None,
        description="Ends nearer than this to another line, to the boundary or to a region are moved onto it, in the "
        "lengths in which the line is given.",
    )


class EmbeddedLine(PathLine, JoinedKeys, OutsideKeys):
    """A line inside the domain that edges of the mesh follow: a crack, a wire."""


class LineFile(FollowedKeys, JoinedKeys, SelectedFile, OutsideKeys):
    """Lines of a file, and the sides of its rings, that edges of the mesh follow."""

    simplify: Positive | None = Field(
        default=None,
        description="Leave out vertices of straight sides that are no farther than this, in the file's lengths, from "
        "the line left.",
    )
    label: OneLabel = None


class JoinedPointKeys(Strict):
    """Key of points that may miss what they should lie on."""

    join: Positive | None = Field(
        default=None,
        description="The point is moved onto the boundary, a line or a region's side that is nearer than this, in the "
        "lengths in which it is given.",
    )


class EmbeddedPoint(DrawnKeys, JoinedPointKeys, OutsideKeys):
    """A point inside the domain that is a node of the mesh: a well, a sensor."""

    at: Point = Field(description="The point [x, y].")
    label: OneLabel = None


class PointFile(SelectedFile, JoinedPointKeys, OutsideKeys):
    """Points of a file that are nodes of the mesh."""

    name: Text | None = Field(default=None, description="Property or column of the file that labels each point.")
    label: OneLabel = None


LINES, POINTS = Choice("a mapping", ("path", "file")), Choice("a mapping", ("at", "file"))

LineKeys = Annotated[
    Annotated[EmbeddedLine, Tag("<path>")] | Annotated[LineFile, Tag("<file>")],
    Discriminator(LINES.tag),
    BeforeValidator(LINES.checked),
]
PointKeys = Annotated[
    Annotated[EmbeddedPoint, Tag("<at>")] | Annotated[PointFile, Tag("<file>")],
    Discriminator(POINTS.tag),
    BeforeValidator(POINTS.checked),
]
