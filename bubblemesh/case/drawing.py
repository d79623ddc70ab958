"""Keys that mirror, scale, rotate, move and repeat whatever a case draws or takes from a file."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    ValidationInfo,
    model_validator,
)
from pydantic_core import PydanticCustomError

from bubblemesh.arrays import Integers
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
    described,
    fault_of,
    list_of,
)
from bubblemesh.case.parameters import parts_by_braces
from bubblemesh.errors import CaseError
from bubblemesh.files import require_name
from bubblemesh.records import record
from bubblemesh.spacing.expression import Expression

NUMBERS_OF_COPIES = ("i", "j")
NAME = "name"  # stands for the name of what is repeated


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


@record
class CopyName:
    """The name of each copy: a text with expressions of its numbers i and j in braces; {name} is what is repeated."""

    given: str
    parts: tuple[str | Expression | None, ...]  # None stands for the name of what is repeated

    @classmethod
    def parse(cls, text: str, parameters: Mapping[str, float]) -> Self:
        """The name that a text gives; CaseError if it holds something else in braces."""
        known = parts_by_braces(text)
        return cls(text, tuple(part if inner is None else _part(inner, parameters) for part, inner in known))

    def of_copies(self, i: Integers, j: Integers) -> list[Callable[[str | None], str]]:
        """For each copy, by its numbers (n,), the function that makes its name of that of what is repeated."""
        columns = [
            [f"{value:.12g}" for value in (part(i.astype(float), j.astype(float)) + 0.0 * i).tolist()]
            if isinstance(part, Expression)
            else [part] * len(i)
            for part in self.parts
        ]
        return [partial(self._name, parts) for parts in zip(*columns, strict=True)]

    def _name(self, parts: Sequence[str | None], name: str | None) -> str:
        """Text of the parts with a name; CaseError if there is none, or the text can be none in mesh files."""
        if name is None and None in parts:
            raise CaseError(f"repeat.name: {self.given!r}: what is repeated has no name: give it a label")
        return require_name("".join(part if part is not None else str(name) for part in parts), "repeat.name")


def _part(inner: str, parameters: Mapping[str, float]) -> Expression | None:
    """What stands in braces: an expression, or None for the name of what is repeated."""
    if inner.strip() != NAME:
        return _condition(inner, parameters)
    if NAME in parameters:
        raise CaseError(f"{NAME!r} is the name of what is repeated here, and a parameter too: rename the parameter")
    return None


def _copy_name(value: Any, info: ValidationInfo) -> CopyName:
    if isinstance(value, CopyName):
        return value
    if not isinstance(value, str):
        raise PydanticCustomError("name", "must be a text (found {found})", {"found": described(value)})
    try:
        return CopyName.parse(value, {} if info.context is None else info.context)
    except CaseError as error:
        raise fault_of(error, "text") from None


class OutsideKeys(Strict):
    """Key of what may lie outside of the domain."""

    outside: Literal["error", "skip"] = Field(
        default="error", description="What lies outside of the domain is an error, or left out by skip."
    )


class CopiesKeys(OutsideKeys):
    """Keys of copies, however they are placed."""

    name: Annotated[CopyName, PlainValidator(_copy_name, json_schema_input_type=str), AS_GIVEN] | None = Field(
        default=None,
        description="Name of each copy, by its numbers i and j, and by that of the original: slot-{i}, {name}-{i+1}.",
    )


class GridKeys(CopiesKeys):
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


class AroundKeys(CopiesKeys):
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
