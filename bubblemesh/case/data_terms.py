"""Data terms of a spacing, given as values: on a mesh, on a grid, by a picture, at points.

A new term takes a model here with its key in `DataTerms`, a function in ``spacing/terms``, and a row in
``problem/data_terms.py`` that makes the function of the model.
"""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import InputFile, Number, OneOrMore, Positive, Strict, Text, list_of, not_empty, several

Corners = tuple[float, float, float, float]


def _ordered(bounds: Corners) -> Corners:
    x0, y0, x1, y1 = bounds
    if not (x0 < x1 and y0 < y1):
        raise PydanticCustomError("bounds", "must be [x0, y0, x1, y1] with x0 below x1 and y0 below y1")
    return bounds


ValueBounds = Annotated[
    tuple[Number, Number, Number, Number],
    list_of(4, "the numbers [x0, y0, x1, y1] of the lower left and upper right corners"),
    AfterValidator(_ordered),
]
Sample = Annotated[tuple[Number, Number, Positive], list_of(3, "a point with its spacing, [x, y, d]")]


class DataTerm(Strict):
    """Values of a spacing; with a key ``file`` if they may be in one."""

    def files(self) -> Iterator[Path]:
        """Files that the term names, and further files that belong to these."""
        name = getattr(self, "file", None)
        if name is not None:
            # Imported here since few cases have data.
            from bubblemesh.meshfiles.sources.table import files_beside

            yield Path(name)
            yield from files_beside(Path(name))


class Tabulated(DataTerm):
    """Values, and what they are multiplied by."""

    scale: Positive = Field(default=1.0, description="Factor from the values to the spacing.")


class DataFile(Tabulated):
    """Values in a file."""

    file: InputFile = Field(description="Name of the file, relative to the case file.")


class FieldTerm(DataFile):
    """Data of a triangle mesh."""

    name: Text | None = Field(default=None, description="Name of the data at nodes or of cells; needed if it has more.")


class RasterTerm(DataFile):
    """An array over a rectangle."""

    name: Text | None = Field(
        default=None,
        description="Name of the array in an .npz or NetCDF file, or of the band of a GeoTIFF; needed if it has more.",
    )
    bounds: ValueBounds | None = Field(
        default=None, description="Rectangle [x0, y0, x1, y1] that the pixels fill; else the file's arrays x and y."
    )
    origin: Literal["lower", "upper"] = Field(
        default="lower", description="Whether the first row is the lowest or the highest one within the bounds."
    )

    @property
    def known_as(self) -> str:
        """Name of the variable in expressions: the one given, or that of the file without its ending."""
        return self.name or Path(self.file).stem


class ImageTerm(DataTerm):
    """A picture over a rectangle: the darker, the finer."""

    file: InputFile = Field(description="Name of the picture, relative to the case file.")
    bounds: ValueBounds = Field(description="Rectangle [x0, y0, x1, y1] that the picture fills, its first row on top.")
    finest: Positive = Field(description="Spacing where the picture is black.")
    coarsest: Positive = Field(description="Spacing where the picture is white.")

    @model_validator(mode="after")
    def _consistent(self) -> "ImageTerm":
        if self.finest > self.coarsest:
            raise PydanticCustomError("spacing_range", "finest must not be above coarsest")
        return self


class ScatteredTerm(Tabulated):
    """Values at points."""

    file: InputFile | None = Field(
        default=None, description="Name of a table with the columns x, y and d, relative to the case file."
    )
    points: Annotated[tuple[Sample, ...], BeforeValidator(not_empty)] | None = Field(
        default=None, description="Points with their spacings, [x, y, d]."
    )

    @model_validator(mode="after")
    def _either(self) -> "ScatteredTerm":
        if (self.file is None) == (self.points is None):
            raise PydanticCustomError("scattered", "must have one of the keys file and points")
        return self


class FunctionTerm(DataTerm):
    """A function of the place, which a program gives, and the key that has it."""

    function: Callable[..., Any] = Field(description="Function of arrays x and y.")
    key: str = Field(description="Key in messages.")


def function_terms(functions: Sequence[Callable[..., Any]], key: str) -> tuple[DataTerm, ...]:
    """Terms of the functions that a program gives for a key; of several each has a number in it."""
    keys = [key] if len(functions) == 1 else [f"{key}.{number}" for number in range(len(functions))]
    return tuple(FunctionTerm(function=each, key=own) for each, own in zip(functions, keys, strict=True))


class DataTerms(Strict):
    """Data terms of a spacing by their keys: one of a kind, or a list of such."""

    field: OneOrMore[FieldTerm] | None = Field(
        default=None, description="Data at the nodes or of the cells of a mesh, or a list of such."
    )
    raster: OneOrMore[RasterTerm] | None = Field(default=None, description="An array over a rectangle, or a list.")
    image: OneOrMore[ImageTerm] | None = Field(default=None, description="A picture over a rectangle, or a list.")
    scattered: OneOrMore[ScatteredTerm] | None = Field(
        default=None, description="Values at points with triangles between them, or a list of such."
    )

    @property
    def data(self) -> dict[str, tuple[DataTerm, ...]]:
        """The terms of each kind, by its key."""
        terms = {key: several(getattr(self, key)) for key in DataTerms.model_fields}
        return {key: models for key, models in terms.items() if models}
