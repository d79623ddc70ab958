"""Keys that mirror, scale, rotate, move and repeat whatever a case draws or takes from a file."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    model_validator,
)
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import (
    AS_GIVEN,
    MOST_COPIES,
    Choice,
    Copies,
    Number,
    Point,
    Positive,
    Strict,
    as_expression,
    list_of,
)
from bubblemesh.errors import CaseError
from bubblemesh.spacing.expression import Expression

NUMBERS_OF_COPIES = ("i", "j")


class TurnKeys(Strict):
    """A rotation about a point."""

    by: Number = Field(description="Angle in degrees, counter-clockwise.")
    about: Point = Field(default=(0.0, 0.0), description="Point [x, y] that stays where it is.")


Turn = Annotated[
    Annotated[Number, Tag("<degrees>")] | Annotated[TurnKeys, Tag("<turn>")],
    Discriminator(lambda value: "<turn>" if isinstance(value, dict | BaseModel) else "<degrees>"),
]


def _condition(text: str, parameters: Mapping[str, float]) -> Expression:
    if taken := [name for name in NUMBERS_OF_COPIES if name in parameters]:
        raise CaseError(f"{taken[0]!r} is the number of a copy here, and a parameter too: rename the parameter")
    return Expression.parse(text, parameters, names=NUMBERS_OF_COPIES)


Condition = Annotated[
    Expression, PlainValidator(as_expression(_condition), json_schema_input_type=float | str), AS_GIVEN
]


class GridKeys(Strict):
    """Copies in columns and rows."""

    grid: Annotated[tuple[Copies, Copies], list_of(2, "the numbers [nx, ny] of columns and rows")] = Field(
        description="Numbers [nx, ny] of columns and rows."
    )
    step: Point = Field(description="Distances [dx, dy] from column to column and from row to row.")
    where: Condition | None = Field(
        default=None, description="Which copies there are: an expression of their column i and row j, both from 0."
    )

    @model_validator(mode="after")
    def _not_too_many(self) -> "GridKeys":
        if self.grid[0] * self.grid[1] > MOST_COPIES:
            message = "makes {count} copies, more than {most}: ask for fewer"
            context = {"count": f"{self.grid[0] * self.grid[1]:,}", "most": f"{MOST_COPIES:,}"}
            raise PydanticCustomError("copies", message, context)
        return self


class AroundKeys(Strict):
    """Copies on a full turn around a point."""

    around: Point = Field(description="Point [x, y] that the copies lie around.")
    times: Copies = Field(description="Number of copies, at equal angles.")
    where: Condition | None = Field(
        default=None, description="Which copies there are: an expression of their number i from 0."
    )


REPEATS = Choice("a mapping", ("grid", "around"))

RepeatKeys = Annotated[
    Annotated[GridKeys, Tag("<grid>")] | Annotated[AroundKeys, Tag("<around>")],
    Discriminator(REPEATS.tag),
    BeforeValidator(REPEATS.checked),
]


class DrawnKeys(Strict):
    """Keys by which what is drawn is mirrored, scaled, rotated, moved and repeated, in this order."""

    mirror: Literal["x", "y"] | None = Field(
        default=None, description="Axis whose coordinate changes its sign: x turns left into right."
    )
    scale: Positive | None = Field(default=None, description="Factor of all lengths, seen from the origin.")
    rotate: Turn | None = Field(
        default=None,
        description="Angle in degrees, counter-clockwise about the origin; or {by: degrees, about: [x, y]}.",
    )
    move: Point | None = Field(default=None, description="Distances [dx, dy] to move by.")
    repeat: RepeatKeys | None = Field(
        default=None,
        description="Copies: {grid: [nx, ny], step: [dx, dy]} or {around: [x, y], times: n}, the first where it is.",
    )
