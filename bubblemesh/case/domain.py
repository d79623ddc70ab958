"""The domain of a case file: its rings, its regions, and the lines and points embedded in it."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, Discriminator, Field, Tag

from bubblemesh.case.data_terms import ValueBounds
from bubblemesh.case.drawing import DrawnKeys
from bubblemesh.case.fields import (
    Choice,
    Label,
    OneLabel,
    OneOrMore,
    Point,
    Positive,
    PositiveArea,
    Strict,
    Text,
    list_of,
    not_empty,
)
from bubblemesh.case.geometry_files import GeometryFile
from bubblemesh.case.lines_and_points import LineKeys, PointKeys
from bubblemesh.case.repair import RepairKeys
from bubblemesh.case.shapes import RingKeys
from bubblemesh.case.shoreline import ShorelineKeys
from bubblemesh.case.spacing import SpacingValue

SidePair = Annotated[tuple[Label, Label], list_of(2, "a pair of labels")]


class RegionKeys(DrawnKeys):
    """A part of the domain with a name, and a spacing of its own if it is given one."""

    name: Label = Field(description="Name of the region in the mesh files.")
    ring: RingKeys = Field(description="The ring around the region; what lies outside the domain is left out.")
    spacing: SpacingValue | None = Field(default=None, description="Wanted edge length in the region.")
    largest: PositiveArea | None = Field(default=None, description="Largest area of a triangle in the region.")


def _is_list_of_points(value: Any) -> bool:
    return isinstance(value, list | tuple) and isinstance(next(iter(value), ()), list | tuple)


OneOrMorePoints = Annotated[
    Annotated[Point, Tag("<one>")] | Annotated[tuple[Point, ...], BeforeValidator(not_empty), Tag("<several>")],
    Discriminator(lambda value: "<several>" if _is_list_of_points(value) else "<one>"),
]


class RegionSeed(DrawnKeys):
    """A part of the domain that lines, rings and the outline enclose around a point, or several such parts."""

    name: Label = Field(description="Name of the region in the mesh files.")
    at: OneOrMorePoints = Field(description="Point [x, y] in the region, or a list of points in its parts.")
    spacing: SpacingValue | None = Field(default=None, description="Wanted edge length in the region.")
    largest: PositiveArea | None = Field(default=None, description="Largest area of a triangle in the region.")

    @property
    def points(self) -> tuple[tuple[float, float], ...]:
        """The point, or the points, in the region."""
        at: Any = self.at
        return at if _is_list_of_points(at) else (at,)


class RegionFile(GeometryFile):
    """Features of a file that share borders, as regions named by one of their properties."""

    name: Text = Field(description="Property whose values name the regions: NAME, for example, or layer.")
    spacing: SpacingValue | None = Field(default=None, description="Wanted edge length in each of the regions.")
    largest: PositiveArea | None = Field(default=None, description="Largest area of a triangle in each of the regions.")


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, dict | BaseModel) else value


REGIONS = Choice("a mapping", ("ring", "at", "file"))

RegionEntry = Annotated[
    Annotated[RegionKeys, Tag("<ring>")] | Annotated[RegionSeed, Tag("<at>")] | Annotated[RegionFile, Tag("<file>")],
    Discriminator(REGIONS.tag),
    BeforeValidator(REGIONS.checked),
]


def _has_file(value: Any) -> bool:
    return "file" in (
        type(value).model_fields if isinstance(value, BaseModel) else value if isinstance(value, dict) else ()
    )


Regions = RegionFile | tuple[RegionEntry, ...]


class InnerKeys(Strict):
    """Keys of a domain beside its rings."""

    regions: Annotated[tuple[RegionEntry, ...], BeforeValidator(_as_list, json_schema_input_type=Regions)] = Field(
        default=(), description="Parts of the domain with names of their own, drawn, around points, or from files."
    )
    overlaps: Literal["refused", "later"] = Field(
        default="refused", description="Where regions overlap: an error, or that of the later one in the list."
    )
    region: Label = Field(default="domain", description="Name of the domain, or of what regions leave of it.")
    lines: tuple[LineKeys, ...] = Field(default=(), description="Lines that edges of the mesh follow.")
    periodic: tuple[SidePair, ...] = Field(
        default=(), description="Pairs of labels of sides whose nodes match, shifted or turned."
    )
    periodic_tolerance: Positive | None = Field(
        default=None,
        description="Length by which two periodic sides may differ: the second one becomes the first one moved.",
    )
    points: tuple[PointKeys, ...] = Field(default=(), description="Points that are nodes of the mesh.")


Outer = OneOrMore[RingKeys]


class RingDomain(RepairKeys, InnerKeys):
    """The domain: an outer ring or several with holes, regions, and what is embedded."""

    outer: Outer = Field(description="The ring around the domain, or a list of rings around separate pieces of it.")
    holes: tuple[RingKeys, ...] = Field(default=(), description="Rings inside an outer one, not meshed within.")


class FileDomain(GeometryFile, InnerKeys):
    """The area that the rings of another file bound, with regions and what is embedded."""

    hole_label: OneLabel = None


class RegionDomain(InnerKeys):
    """The area that the regions of files cover together, with what is embedded in it."""


class ShoreDomain(InnerKeys):
    """The sea in a box, which the shore in a file bounds."""

    box: ValueBounds = Field(description="Box [x0, y0, x1, y1] whose sides in the sea are the label open.")
    shoreline: ShorelineKeys = Field(description="Shore that bounds the sea: the labels land and island.")


DOMAINS = Choice("a mapping", ("outer", "file", "box"))


def _of_regions(value: Any) -> bool:
    """Whether a domain is given by the regions of a file, without rings of its own."""
    if isinstance(value, BaseModel):
        return isinstance(value, RegionDomain)
    if not isinstance(value, dict) or any(key in value for key in DOMAINS.keys):
        return False
    regions = _as_list(value.get("regions"))
    return isinstance(regions, list | tuple) and any(_has_file(entry) for entry in regions)


DomainKeys = Annotated[
    Annotated[RingDomain, Tag("<outer>")]
    | Annotated[FileDomain, Tag("<file>")]
    | Annotated[ShoreDomain, Tag("<box>")]
    | Annotated[RegionDomain, Tag("<regions>")],
    Discriminator(lambda value: "<regions>" if _of_regions(value) else DOMAINS.tag(value)),
    BeforeValidator(lambda value: value if _of_regions(value) else DOMAINS.checked(value)),
]
