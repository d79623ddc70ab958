"""Coordinate reference systems of a case: what its coordinates are, and in which they are written."""

from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field

from bubblemesh.case.fields import Strict, Text


def _named(value: Any) -> Any:
    """The name of a system that is given by its number."""
    return f"EPSG:{value}" if isinstance(value, int) and not isinstance(value, bool) else value


System = Annotated[Text, Field(min_length=1), BeforeValidator(_named)]


class CrsKeys(Strict):
    """Coordinate reference systems; lengths are in metres then."""

    # `from` cannot be a name in Python.
    model_config = ConfigDict(serialize_by_alias=True)

    source: System = Field(
        alias="from", description="System of all coordinates in the case and its files, such as EPSG:4326 for degrees."
    )
    to: System = Field(
        default="auto", description="System of the mesh that is written; auto for a local projection in metres."
    )
