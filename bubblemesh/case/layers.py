"""Boundary layers of a case file: thin cells along walls, whose heights grow away from them."""

from typing import Any, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from bubblemesh.case.faults import checked
from bubblemesh.case.fields import Growth, Label, Layers, OneOrMore, Positive, Strict

GROWTH = 1.2  # default


class LayerKeys(Strict):
    """Layers on the walls of one label or several: two of first, count and thickness tell how high they are."""

    on: OneOrMore[Label] = Field(description="Labels of sides, interfaces or embedded lines that get layers.")
    first: Positive | None = Field(default=None, description="Height of the first layer.")
    growth: Growth = Field(default=GROWTH, description="Ratio of the heights of successive layers, from 1 to 2.")
    count: Layers | None = Field(default=None, description="Number of layers.")
    thickness: Positive | None = Field(
        default=None,
        description="Height of all layers; with first, the growth is changed so that a whole number of them fits.",
    )
    until: Literal["isotropic"] | None = Field(
        default=None, description="isotropic: layers follow each other until they are as high as wide; needs first."
    )
    corners: Literal["fans", "plain"] = Field(
        default="fans", description="Whether columns fan out around convex corners, or one column stands there."
    )
    ends: Literal["follow", "taper"] = Field(
        default="follow",
        description="Where the wall goes on without layers: the last column follows it, or layers end one by one.",
    )
    cells: Literal["triangles", "quads"] = Field(
        default="triangles", description="Whether cells stay quadrilaterals in the formats that can hold them."
    )
    region: Label | None = Field(
        default=None, description="Region that gets the layers, for labels with regions on both sides."
    )

    @model_validator(mode="after")
    def _two_of_three(self) -> Self:
        given = [name for name in ("first", "count", "thickness") if getattr(self, name) is not None]
        if self.until is not None:
            if given != ["first"]:
                raise PydanticCustomError("layers", "until: isotropic goes with first, and without count and thickness")
            if self.growth == 1:
                raise PydanticCustomError("layers", "until: isotropic needs a growth above 1")
        elif len(given) != 2:
            raise PydanticCustomError("layers", "must have two of first, count and thickness, or first and until")
        elif self.first is not None and self.thickness is not None and self.first > self.thickness:
            raise PydanticCustomError("layers", "the first layer must not be higher than all of them: raise thickness")
        return self


class _GivenLayers(Strict):
    """Mapping around layers given by a program; messages begin with its key."""

    layers: tuple[LayerKeys, ...] = Field(description="The layers.")


def layer_entries(entries: Any) -> tuple[LayerKeys, ...]:
    """Layers given by a program as a list of dictionaries; CaseError, each line of which names a key, if invalid."""
    return checked(_GivenLayers, {"layers": entries}).layers
