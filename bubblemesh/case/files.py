"""Rings and domains of a case that other files hold."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, BeforeValidator, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from bubblemesh.case.data_terms import DataTerm
from bubblemesh.case.fields import OneLabel, Positive, Strict
from bubblemesh.case.followed import Traced
from bubblemesh.readers.selection import Selection, Unit

if TYPE_CHECKING:
    from bubblemesh.geometry import rings


def _one_or_more(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


def _feature(value: Any) -> Any:
    whole = isinstance(value, int) and not isinstance(value, bool) and value >= 0
    if not whole and not (isinstance(value, dict) and value):
        raise PydanticCustomError("feature", "must be a number from 0 on, or a property with its value")
    return value


class InFile(Traced, Strict):
    """A file, and what to take of it."""

    file: Annotated[str, Field(min_length=1)] = Field(description="Name of the file, relative to the case file.")
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

    def selection(self) -> Selection:
        """What to take of the file."""
        return Selection(self.layer, self.feature, self.scale or 1.0, self.units, self.join)


class FileRing(InFile):
    """Rings of another file; `outer` takes one, an entry of `holes` all that are chosen."""

    def rings(self) -> "list[rings.Ring]":
        """The rings' geometry."""
        from bubblemesh.readers.formats import read_rings

        found = read_rings(Path(self.file), self.selection())
        return [self.traced(ring.labelled(self.label)) for ring in found]


class FileDomain(InFile):
    """The area that the rings of another file bound."""

    hole_label: OneLabel = None

    def rings(self) -> "tuple[rings.Ring, list[rings.Ring]]":
        """Geometry of the outer ring and of the holes."""
        from bubblemesh.readers.formats import read_area

        outer, *holes = read_area(Path(self.file), self.selection())
        return (
            self.traced(outer.labelled(self.label)),
            [self.traced(hole.labelled(self.hole_label)) for hole in holes],
        )


def named_files(model: BaseModel) -> Iterator[Path]:
    """The files that a case, or a part of it, names, with those that belong to them."""
    from bubblemesh.readers.formats import files_of

    if isinstance(model, InFile):
        yield from files_of(Path(model.file))
    if isinstance(model, DataTerm):
        yield from model.files()
    for _, value in model:
        for part in value if isinstance(value, tuple) else [value]:
            if isinstance(part, BaseModel):
                yield from named_files(part)
