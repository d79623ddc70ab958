"""Regions and embedded lines and points of a case file."""

from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from bubblemesh.case.fields import Label, OneLabel, Point, Strict, listed
from bubblemesh.case.paths import PathLine
from bubblemesh.case.rings import Ring
from bubblemesh.case.spacing import SpacingValue

if TYPE_CHECKING:
    from bubblemesh.geometry import rings


SidePair = Annotated[tuple[Label, Label], listed(2, "a pair of labels")]


class Region(Strict):
    """A part of the domain with a name, and a spacing of its own if it is given one."""

    name: Label = Field(description="Name of the region in the mesh files.")
    ring: Ring = Field(description="The ring around the region; what lies outside the domain is left out.")
    spacing: SpacingValue | None = Field(default=None, description="Wanted edge length in the region.")


class EmbeddedLine(PathLine):
    """A line inside the domain that edges of the mesh follow: a crack, a wire."""

    def strand(self, default: str) -> "rings.OpenPath":
        """The line's geometry."""
        from bubblemesh.geometry import rings

        return rings.open_path(*self.pieces(), self.label or default)


class EmbeddedPoint(Strict):
    """A point inside the domain that is a node of the mesh: a well, a sensor."""

    at: Point = Field(description="The point [x, y].")
    label: OneLabel = None


class Parts(Strict):
    """What a domain may hold beside its rings."""

    regions: tuple[Region, ...] = Field(default=(), description="Parts of the domain with names of their own.")
    region: Label = Field(default="domain", description="Name of the domain, or of what regions leave of it.")
    lines: tuple[EmbeddedLine, ...] = Field(default=(), description="Lines that edges of the mesh follow.")
    periodic: tuple[SidePair, ...] = Field(default=(), description="Pairs of labels of sides whose nodes match.")
    points: tuple[EmbeddedPoint, ...] = Field(default=(), description="Points that are nodes of the mesh.")
