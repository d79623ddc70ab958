"""The domain of a case file: its rings, its regions, and the lines and points embedded in it."""

from typing import Annotated

from pydantic import BeforeValidator, Discriminator, Field, Tag

from bubblemesh.case.drawing import DrawnKeys
from bubblemesh.case.embedded import LineKeys, PointKeys
from bubblemesh.case.fields import Choice, Label, OneLabel, Strict, filled, listed
from bubblemesh.case.geometry_files import GeometryFile
from bubblemesh.case.shapes import RingKeys
from bubblemesh.case.spacing import SpacingValue

SidePair = Annotated[tuple[Label, Label], listed(2, "a pair of labels")]


class RegionKeys(DrawnKeys):
    """A part of the domain with a name, and a spacing of its own if it is given one."""

    name: Label = Field(description="Name of the region in the mesh files.")
    ring: RingKeys = Field(description="The ring around the region; what lies outside the domain is left out.")
    spacing: SpacingValue | None = Field(default=None, description="Wanted edge length in the region.")


class InnerKeys(Strict):
    """Keys of a domain beside its rings."""

    regions: tuple[RegionKeys, ...] = Field(default=(), description="Parts of the domain with names of their own.")
    region: Label = Field(default="domain", description="Name of the domain, or of what regions leave of it.")
    lines: tuple[LineKeys, ...] = Field(default=(), description="Lines that edges of the mesh follow.")
    periodic: tuple[SidePair, ...] = Field(default=(), description="Pairs of labels of sides whose nodes match.")
    points: tuple[PointKeys, ...] = Field(default=(), description="Points that are nodes of the mesh.")


Outer = Annotated[
    Annotated[RingKeys, Tag("<ring>")] | Annotated[tuple[RingKeys, ...], BeforeValidator(filled), Tag("<rings>")],
    Discriminator(lambda value: "<rings>" if isinstance(value, list | tuple) else "<ring>"),
]


class RingDomain(InnerKeys):
    """The domain: an outer ring or several with holes, regions, and what is embedded."""

    outer: Outer = Field(description="The ring around the domain, or a list of rings around separate pieces of it.")
    holes: tuple[RingKeys, ...] = Field(default=(), description="Rings inside an outer one, not meshed within.")


class FileDomain(GeometryFile, InnerKeys):
    """The area that the rings of another file bound, with regions and what is embedded."""

    hole_label: OneLabel = None


DOMAINS = Choice("a mapping", ("outer", "file"))

DomainKeys = Annotated[
    Annotated[RingDomain, Tag("<outer>")] | Annotated[FileDomain, Tag("<file>")],
    Discriminator(DOMAINS.tag),
    BeforeValidator(DOMAINS.checked),
]
