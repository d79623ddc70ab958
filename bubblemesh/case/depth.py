"""Keys of a spacing that follows the depth of water."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BeforeValidator, Discriminator, Field, PlainValidator, Tag, ValidationInfo

from bubblemesh.case.fields import AS_GIVEN, Positive, Strict, as_expression, evaluated
from bubblemesh.spacing.expression import Expression, is_raster_name


def _parsed(text: str, parameters: Mapping[str, float]) -> Expression:
    """An expression; the bare name of a raster stands for it."""
    bare = text.strip()
    return Expression.parse(f"raster.{bare}" if is_raster_name(bare, parameters) else text, parameters)


def _time(value: object, info: ValidationInfo) -> object:
    return evaluated(value, info, "time")


Depth = Annotated[Expression, PlainValidator(as_expression(_parsed), json_schema_input_type=float | str), AS_GIVEN]
_Duration = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
Duration = Annotated[_Duration, BeforeValidator(_time, json_schema_input_type=_Duration | str)]


class NodeDepthKeys(Strict):
    """The depth that the mesh is written with."""

    of: Depth | None = Field(
        default=None, description="The name of a raster, or an expression; by default that of waves, slope or courant."
    )
    over: Literal["node", "cell"] = Field(
        default="node",
        description="Whether it is that at each node, or the mean over the node's cell, a third of each triangle.",
    )


# A plain expression stands for a mapping with this expression and defaults for the other keys.
AnyNodeDepth = Annotated[
    Annotated[Depth, Tag("<plain>")] | Annotated[NodeDepthKeys, Tag("<keys>")],
    Discriminator(lambda value: "<keys>" if isinstance(value, dict | NodeDepthKeys) else "<plain>"),
]


class DepthKeys(Strict):
    """A depth."""

    depth: Depth = Field(
        description="Depth of water in metres: the name of a raster, a number, or an expression such as -raster.height."
    )
    shallowest: Positive = Field(default=1.0, description="What is less deep counts as this depth, in metres.")


class WaveKeys(DepthKeys):
    """Nodes in the length of long waves."""

    period: Duration = Field(description="Period of the waves, in seconds: 12.42 h for the tide.")
    per_length: Positive = Field(description="Nodes that a wave's length gets at least.")


class SlopeKeys(DepthKeys):
    """Nodes on slopes of the bed."""

    per_slope: Positive = Field(description="Nodes while the depth changes by 2 pi times itself.")
    filter: Positive | None = Field(
        default=None, description="Length over which depths are compared: by default 1/200 of the domain."
    )


class CourantKeys(DepthKeys):
    """Bound on the Courant number of long waves."""

    dt: Duration = Field(description="Time step of the model, in seconds.")
    largest: Positive = Field(description="Largest Courant number: the spacing is nowhere so fine that it is above.")
