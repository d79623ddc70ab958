"""Metrics of a case file: spacings that depend on the direction, of which the smallest counts in each direction."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from bubblemesh.case.data_terms import DataTerm, ValueBounds
from bubblemesh.case.faults import checked
from bubblemesh.case.fields import Choice, InputFile, Label, Number, OneOrMore, Positive, Strict, Text, several
from bubblemesh.case.spacing import ExpressionText, SpacingValue
from bubblemesh.spacing.expression import Expression


def _tag(value: Any) -> str:
    return "<text>" if isinstance(value, str | Expression) else "<number>"


def _any_value(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str | Expression):
        raise PydanticCustomError("metric", "must be a number or an expression in x and y")
    return value


AnyValue = Annotated[
    Annotated[Number, Tag("<number>")] | Annotated[ExpressionText, Tag("<text>")],
    Discriminator(_tag),
    BeforeValidator(_any_value),
]
Aspect = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1, le=10_000)]
ASPECT = 1000.0  # largest aspect of ellipses by default


class MetricTerm(Strict):
    """A metric, with a limit on how long its ellipses are."""

    aspect: Aspect = Field(default=ASPECT, description="Largest ratio of the sizes along and across.")
    gradation: Positive | None = Field(
        default=None, description="Largest growth of the sizes over a length of 1 in the metric, such as 0.3 at jumps."
    )


class DirectedMetric(MetricTerm):
    """Sizes along a direction and across it."""

    angle: AnyValue = Field(description="Direction of the long side, in radians from the x axis: atan2(dy, dx).")
    across: SpacingValue = Field(description="Spacing across it.")
    along: SpacingValue | None = Field(default=None, description="Spacing along it: by default that of the case.")


class TensorMetric(MetricTerm):
    """Entries of the tensor M, in which an edge v has the length sqrt(v M v): 1 if it is as long as wanted."""

    m11: AnyValue = Field(description="Entry for x and x: 1/d^2 where d is the spacing in all directions.")
    m12: AnyValue = Field(default=0.0, description="Entry for x and y.")
    m22: AnyValue = Field(description="Entry for y and y.")


class WallMetric(MetricTerm):
    """Sizes across walls and along them, from there on into the domain."""

    like: Literal["boundary"] = Field(description="boundary: ellipses lie along the nearest wall.")
    label: OneOrMore[Label] = Field(description="Labels of sides, interfaces or embedded lines.")
    across: Positive = Field(description="Spacing across, at the wall.")
    growth: Positive = Field(default=0.2, description="Growth of the spacing across, per length away from the wall.")
    along: SpacingValue | None = Field(default=None, description="Spacing along it: by default that of the case.")


class FieldMetric(MetricTerm, DataTerm):
    """Tensors at the nodes of a triangle mesh, as m11, m12, m22 or whole matrices, or rasters m11, m12 and m22."""

    file: InputFile = Field(description="Name of the file, relative to the case file; of .mesh the .sol beside it.")
    name: Text | None = Field(default=None, description="Name of the data at nodes; needed if several may be one.")
    bounds: ValueBounds | None = Field(
        default=None, description="Rectangle [x0, y0, x1, y1] that the pixels of arrays fill; else those named x and y."
    )


METRIC_KINDS = Choice("a mapping", ("angle", "m11", "like", "file"))

AnyMetric = Annotated[
    Annotated[DirectedMetric, Tag("<angle>")]
    | Annotated[TensorMetric, Tag("<m11>")]
    | Annotated[WallMetric, Tag("<like>")]
    | Annotated[FieldMetric, Tag("<file>")],
    Discriminator(METRIC_KINDS.tag),
    BeforeValidator(METRIC_KINDS.checked),
]


class _GivenMetric(Strict):
    """Mapping around metrics given by a program; messages begin with its key."""

    metric: OneOrMore[AnyMetric] = Field(description="The metric, or several.")


def metric_entries(metric: Any) -> tuple[AnyMetric, ...]:
    """Metrics given by a program as one or several dictionaries; CaseError, whose lines name keys, if invalid."""
    return several(checked(_GivenMetric, {"metric": metric}).metric)
