"""Files with geometry in a case file: which features to use, and how their rings are followed."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from bubblemesh.case.drawing import DrawnKeys
from bubblemesh.case.fields import Filled, InputFile, Number, OneLabel, Positive, Strict, Text
from bubblemesh.case.repair import RepairKeys
from bubblemesh.readers.selection import Open, PartChoice, Unit


class FollowedKeys(Strict):
    """Keys by which the straight sides of a ring are followed as curves."""

    corners: Annotated[Number, Field(ge=0, le=180)] | None = Field(
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


def _one_or_more(value: Any) -> Any:
    """Names as a tuple of texts; YAML may read one as a whole number, as each DXF file has a layer 0."""
    names = value if isinstance(value, list) else [value] if isinstance(value, str | int) else value
    if not isinstance(names, list):
        return names
    return [str(name) if isinstance(name, int) and not isinstance(name, bool) else name for name in names]


def _feature(value: Any) -> Any:
    whole = isinstance(value, int) and not isinstance(value, bool) and value >= 0
    if not whole and not (isinstance(value, dict) and value):
        raise PydanticCustomError("feature", "must be a number from 0 on, or a property with its value")
    return value


def _part(value: Any) -> Any:
    whole = isinstance(value, int) and not isinstance(value, bool) and value >= 0
    if not whole and value not in ("largest", "all", None):
        raise PydanticCustomError("part", "must be largest, all, or a number from 0 on")
    return value


def _unit(value: Any) -> Any:
    return "in" if value == "inch" else value


class SelectedFile(DrawnKeys):
    """A file with geometry, and what to take of it."""

    file: InputFile = Field(description="Name of the file, relative to the case file.")
    layer: Annotated[tuple[Text, ...], BeforeValidator(_one_or_more)] = Field(
        default=(), description="Layer to read, or a list of layers; all by default."
    )
    feature: Annotated[int | dict[str, Filled] | None, BeforeValidator(_feature)] = Field(
        default=None, description="Number of the feature from 0, or a property with its value such as {name: Corsica}."
    )
    units: Annotated[Unit | None, BeforeValidator(_unit, json_schema_input_type=Unit | Literal["inch"] | None)] = Field(
        default=None, description="The file's unit of length, for a case in metres."
    )

    @field_validator("units")
    @classmethod
    def _without_scale(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None and info.data.get("scale") is not None:
            raise PydanticCustomError("scale", "and scale exclude each other: give one of the two")
        return value


class GeometryFile(FollowedKeys, RepairKeys, SelectedFile):
    """A file with rings, and what to take of it."""

    part: Annotated[PartChoice | None, BeforeValidator(_part)] = Field(
        default=None, description="Of separate areas the largest, all, or one by its number from 0, the largest first."
    )
    join: Positive | None = Field(
        default=None, description="Ends of curves nearer to each other than this meet, in the file's lengths."
    )
    open: Open | None = Field(default=None, description="With skip, curves that form no ring are left out.")
    label: OneLabel = None
