"""The sea in a box: what the shore in a file leaves of it."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationInfo
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import InputFile, Positive, PositiveArea, Strict, Text, evaluated

Kind = Literal["land", "sea", "lines"]


def _detail(value: Any, info: ValidationInfo) -> Any:
    if value is None or value == "auto":
        return value
    is_word = isinstance(value, str) and not any(letter.isdigit() for letter in value)
    length = value if is_word else evaluated(value, info)
    if isinstance(length, bool) or not isinstance(length, int | float) or length <= 0:
        raise PydanticCustomError("detail", "must be auto or a length above 0")
    return length


class ShorelineKeys(Strict):
    """The shore in a file, and how much of it is kept."""

    file: InputFile = Field(description="Name of the file, relative to the case file.")
    of: Kind = Field(
        default="land",
        description="What its shapes are: land, sea, or lines of the shore with the land on their left.",
    )
    layer: Text | None = Field(default=None, description="Layer to read; all by default.")
    smallest: PositiveArea | None = Field(
        default=None, description="Leave out islands, and parts of the sea, of less area than this."
    )
    detail: Annotated[Literal["auto"] | Positive | None, BeforeValidator(_detail)] = Field(
        default=None,
        description="Leave out vertices no farther than this from the shore; auto for a tenth of the spacing there.",
    )
    narrowest: Positive | None = Field(
        default=None,
        description="Close channels and bays narrower than so many of the spacings there.",
    )
