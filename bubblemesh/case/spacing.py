"""The spacing request of a case file: one value, or several terms of which the smallest counts."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    model_validator,
)
from pydantic_core import PydanticCustomError

from bubblemesh.case.data_terms import DataTerm, DataTerms, function_terms
from bubblemesh.case.depth import CourantKeys, SlopeKeys, WaveKeys
from bubblemesh.case.faults import checked
from bubblemesh.case.fields import (
    AS_GIVEN,
    Choice,
    Count,
    Label,
    Number,
    Once,
    OneOrMore,
    Point,
    Positive,
    Strict,
    as_expression,
    several,
)
from bubblemesh.errors import CaseError
from bubblemesh.spacing.expression import Expression

Value = float | Expression
PLAIN = (int, float, str, Expression)
FUNCTION = "spacing.function"  # key of a program


class Growing(Strict):
    """Spacing near something."""

    size: Positive = Field(description="Spacing there.")
    growth: Positive | None = Field(
        default=None, description="Growth per length away from it: by default that of the mapping, else 0.2."
    )
    until: Annotated[Number, Field(ge=0)] = Field(
        default=0.0, description="Distance up to which the spacing stays at its size."
    )


class NearLabel(Growing):
    """Spacing near all that has a label."""

    label: OneOrMore[Label] = Field(description="Labels of sides, interfaces, embedded lines or points.")


class NearEnds(Growing):
    """Spacing near the free ends of embedded lines, such as the tips of cracks."""

    ends: OneOrMore[Label] = Field(
        description="Labels of embedded lines: the ends at which no other line, boundary or region is."
    )


class NearPoint(Growing):
    """Spacing near a point, which need be no node."""

    point: Point = Field(description="The point [x, y].")


def _long(line: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if len(set(line)) < 2:
        raise PydanticCustomError("line", "must have two different points at least")
    return line


class NearLine(Growing):
    """Spacing near a line, which edges of the mesh need not follow."""

    line: Annotated[tuple[Point, ...], AfterValidator(_long)] = Field(
        description="Points [x, y] with straight lines between them."
    )


PLACES = Choice("a mapping", ("label", "ends", "point", "line"))

NearTerm = Annotated[
    Annotated[NearLabel, Tag("<label>")]
    | Annotated[NearEnds, Tag("<ends>")]
    | Annotated[NearPoint, Tag("<point>")]
    | Annotated[NearLine, Tag("<line>")],
    Discriminator(PLACES.tag),
    BeforeValidator(PLACES.checked),
]


ExpressionText = Annotated[
    Expression, PlainValidator(as_expression(Expression.parse), json_schema_input_type=str), AS_GIVEN, Once()
]


def _one_of(*types: type, wording: str) -> BeforeValidator:
    """Check for the types of a spacing, with a message that names all of them."""

    def check(value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, types):
            raise PydanticCustomError("spacing", "must be {wording}", {"wording": wording})
        return value

    return BeforeValidator(check)


def _tag(value: Any) -> str:
    if isinstance(value, dict | BaseModel):
        return "<terms>"
    return "<text>" if isinstance(value, str | Expression) else "<number>"


SpacingValue = Annotated[
    Annotated[Positive, Tag("<number>")] | Annotated[ExpressionText, Tag("<text>")],
    Discriminator(_tag),
    _one_of(*PLAIN, wording="a number or an expression in x and y"),
    Once(),
]


class PlaceTerms(Strict):
    """Terms by values at places that the case itself names."""

    value: SpacingValue | None = Field(default=None, description="A number, or an expression in x and y.")
    near: OneOrMore[NearTerm] | None = Field(
        default=None, description="Size near something, growing with the distance from it, or a list of such."
    )
    labels: dict[Label, Positive] = Field(
        default={}, description="Sizes at what has the labels, growing with the distance from there."
    )
    regions: dict[Label, SpacingValue] = Field(default={}, description="Largest spacings within regions, by name.")


class SpacingTerms(DataTerms, PlaceTerms):
    """Terms of which the smallest counts, and what limits it."""

    per_circle: Annotated[Positive, Field(ge=3)] | None = Field(
        default=None, description="Nodes that a full turn of the boundary's curves gets at least."
    )
    across: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=100)] | None = Field(
        default=None,
        description="Spacings that fit across the narrowest parts of the domain at least: by default 1, where that "
        "does not take many times the nodes; 0 for none.",
    )
    waves: WaveKeys | None = Field(default=None, description="Nodes in the length of long waves: sqrt(g h) T / n.")
    slope: SlopeKeys | None = Field(default=None, description="Nodes on slopes of the bed: 2 pi h / (n |grad h|).")
    courant: CourantKeys | None = Field(default=None, description="Bound on the Courant number of long waves.")
    scale: Positive = Field(default=1.0, description="Factor of the smallest term.")
    minimum: Positive | None = Field(default=None, description="The spacing is nowhere finer, but where it has to be.")
    maximum: Positive | None = Field(default=None, description="The spacing is nowhere coarser.")
    growth: Positive | None = Field(default=None, description="Largest growth of the spacing per length.")
    nodes: Annotated[Count, Field(ge=3)] | None = Field(
        default=None, description="Number of nodes of the mesh, within 2 %: decides on the scale."
    )

    @property
    def basis(self) -> tuple[str, Value | None]:
        """Key and value of the basic term: the value, or the maximum if there are neither a value nor data."""
        if self.value is None and not self.data:
            return "maximum", self.maximum
        return "value", self.value

    @model_validator(mode="after")
    def _consistent(self) -> "SpacingTerms":
        if self.minimum is not None and self.maximum is not None and self.minimum > self.maximum:
            raise PydanticCustomError("spacing_range", "minimum must not be above maximum")
        everywhere = self.value, self.maximum, self.near, self.waves
        if all(term is None for term in everywhere) and not (self.data or self.labels or self.regions):
            raise PydanticCustomError("spacing_open", "must have a value or a maximum, for where no other term counts")
        return self


AnySpacing = Annotated[
    Annotated[Positive, Tag("<number>")]
    | Annotated[ExpressionText, Tag("<text>")]
    | Annotated[SpacingTerms, Tag("<terms>")],
    Discriminator(_tag),
    _one_of(*PLAIN, dict, BaseModel, wording="a number, an expression in x and y, or a mapping of terms"),
]


def _callable(value: Any) -> Any:
    if not callable(value):
        raise PydanticCustomError("function", "must be a function of arrays x and y")
    return value


class ProgramTerms(SpacingTerms):
    """Terms given by a program, among them functions."""

    function: OneOrMore[Annotated[Callable[..., Any], BeforeValidator(_callable)]] | None = Field(
        default=None, description="A function of arrays x and y, or a list of such."
    )

    @property
    def data(self) -> dict[str, tuple[DataTerm, ...]]:
        """The terms of each kind, by its key."""
        functions = function_terms(several(self.function), FUNCTION)
        return super().data | ({"function": functions} if functions else {})


class _GivenSpacing(Strict):
    """Mapping around terms given by a program; messages begin with its key."""

    spacing: ProgramTerms = Field(description="The terms.")


def checked_terms(spacing: Mapping[str, Any]) -> SpacingTerms:
    """Terms given by a program as a mapping; CaseError, each line of which names a key, if they are invalid."""
    for key, value in spacing.items():
        if key != "function" and callable(value) and not isinstance(value, Expression):
            raise CaseError(f"spacing.{key}: is a function, or data like one: give it as 'function'")
    return checked(_GivenSpacing, {"spacing": dict(spacing)}).spacing


def as_terms(spacing: Value | SpacingTerms) -> SpacingTerms:
    """The terms of a spacing; a plain value, which has been checked, is the only term."""
    return spacing if isinstance(spacing, SpacingTerms) else SpacingTerms.model_construct(value=spacing)
