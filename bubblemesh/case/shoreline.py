"""The sea in a box: what the shore in a file leaves of it."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import InputFile, Positive, PositiveArea, Strict, Text

Kind = Literal["land", "sea", "lines"]


def _detail(value: Any) -> Any:
    if isinstance(value, str) and value not in ("auto",) and not any(letter.isdigit() for letter in value):
        raise PydanticCustomError("detail", "must be auto or a length")
    return value


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
