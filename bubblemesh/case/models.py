"""The models of the case file, their JSON Schema, made from their descriptions, and the template of a case."""

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    model_validator,
)
from pydantic_core import PydanticCustomError

from bubblemesh.case.crs import CrsKeys
from bubblemesh.case.depth import AnyNodeDepth, NodeDepthKeys
from bubblemesh.case.domain import DomainKeys
from bubblemesh.case.faults import Origin
from bubblemesh.case.fields import (
    Constant,
    Count,
    FileName,
    Folder,
    Fraction,
    GroupId,
    Label,
    OneOrMore,
    Parts,
    Positive,
    PositiveArea,
    Strict,
    not_empty,
)
from bubblemesh.case.layers import LayerKeys
from bubblemesh.case.metric import AnyMetric
from bubblemesh.case.spacing import AnySpacing, SpacingTerms, as_terms
from bubblemesh.errors import CaseError
from bubblemesh.meshfiles.formats import FORMATS_FOR, FormatName, Solver, formats_for
from bubblemesh.process.memory_limit import unlimited_memory
from bubblemesh.spacing.expression import check_parameter_name

MULTILEVEL = "multilevel"  # the method of cases that name none
IN_METRIC = "ellipses"  # the method that packs in a metric


def _parameter_name(name: str) -> str:
    try:
        check_parameter_name(name)
    except CaseError as error:
        raise PydanticCustomError("parameter", "{problem}", {"problem": str(error)}) from None
    return name


# When a case is checked, expressions become numbers.
Parameter = Annotated[Constant, BeforeValidator(lambda value: value, json_schema_input_type=Constant | str)]


Solvers = Annotated[
    Annotated[Solver, Tag("<one>")] | Annotated[tuple[Solver, ...], Field(min_length=1), Tag("<several>")],
    Discriminator(lambda value: "<several>" if isinstance(value, list | tuple) else "<one>"),
]


def _each_once(formats: tuple[FormatName, ...]) -> tuple[FormatName, ...]:
    twice = next((name for name in formats if formats.count(name) > 1), None)
    if twice is not None:
        raise PydanticCustomError("twice", "{name} is there twice: name it once", {"name": twice})
    return formats


class Output(Strict):
    """Files to write, and where."""

    # `for` cannot be a name in Python.
    model_config = ConfigDict(serialize_by_alias=True)

    formats: Annotated[tuple[FormatName, ...], AfterValidator(_each_once)] = Field(
        default=("msh", "vtu"), min_length=1, description="Mesh formats to write."
    )
    solver: Solvers | None = Field(
        default=None, alias="for", description="Solver that reads the mesh, or a list of them, in place of its formats."
    )
    order: Literal[1, 2] = Field(
        default=1, description="Order of the triangles: 2 adds a node on each edge, on the boundary's true curve."
    )
    open: OneOrMore[Label] | None = Field(
        default=None,
        description="Labels of open water, for formats of coasts; else those named open, or open_, open- and more.",
    )
    ids: dict[Label, GroupId] | None = Field(
        default=None,
        description="Ids that the files give labels, regions and points, by their names: {inlet: 7, copper: 3}; others "
        "have numbers from 1.",
    )
    depth: AnyNodeDepth | None = Field(
        default=None,
        description="Depth that the mesh is written with, in formats that hold it: the name of a raster, a number, "
        "an expression, or both of the keys below; by default that of waves, slope or courant.",
    )
    partition: Count | None = Field(
        default=None, description="Number of parts for a parallel solver, whose files tell the part of each triangle."
    )
    report: bool = Field(default=False, description="Whether to write a page to look at, NAME.html, beside the mesh.")
    directory: Folder | None = Field(default=None, description="Folder of the files, relative to the case file.")

    @property
    def node_depth(self) -> NodeDepthKeys:
        """The keys of the depth."""
        return self.depth if isinstance(self.depth, NodeDepthKeys) else NodeDepthKeys(of=self.depth)

    @model_validator(mode="before")
    @classmethod
    def _formats_of_solver(cls, data: Any) -> Any:
        named = data.get("for") if isinstance(data, dict) else None
        solvers = [str(solver) for solver in (named if isinstance(named, list | tuple) else [named])]
        if not solvers or any(solver not in FORMATS_FOR for solver in solvers):
            return data
        formats = formats_for(solvers)
        given = data.get("formats", formats)
        if not isinstance(given, list | tuple | str | None):
            return data  # the key's own check refuses it
        if tuple(given or ()) != formats:
            raise PydanticCustomError("excluding", "formats and for exclude each other: give one of the two")
        return data | {"formats": formats}


class Limits(Strict):
    """Limits on the size of a case, and on the time and the memory that it takes."""

    max_nodes: Count = Field(default=2_000_000, description="Largest number of nodes that a mesh may need.")
    seconds: Positive | None = Field(
        default=None,
        description="Time after which the packing ends with the mesh as it is, and any other stage without one.",
    )
    max_memory_mb: Positive | None = Field(
        default=None, description="Megabytes of memory that the process may hold (on Linux only)."
    )


# Limits of untrusted cases: the case may lower them, options of the command line may raise them.
UNTRUSTED: Mapping[str, int] = {"max_nodes": 200_000, "seconds": 300, "max_memory_mb": 2000}


NotNegative = Annotated[int, Field(strict=True, ge=0)]


class Requirements(Strict):
    """The quality that a mesh must reach for the run to succeed."""

    quality_min: Fraction | None = Field(
        default=None, description="Least quality of any triangle, 1 being equilateral."
    )
    quality_mean: Fraction | None = Field(default=None, description="Least mean quality of the triangles.")
    angle_min: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=60)] | None = Field(
        default=None, description="Least angle of any triangle, in degrees."
    )
    angle_max: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=60, le=180)] | None = Field(
        default=None, description="Largest angle of any triangle, in degrees."
    )
    valence_max: Count | None = Field(default=None, description="Largest number of edges at any node.")
    dead_ends_max: NotNegative | None = Field(
        default=None, description="Largest number of triangles with two sides on closed boundaries."
    )
    cut_off_max: NotNegative | None = Field(
        default=None, description="Largest number of triangles that are joined to the open sea by a point only."
    )


class RangeKeys(Strict):
    """Values of a swept key at equal steps."""

    # `from` cannot be a name in Python.
    model_config = ConfigDict(serialize_by_alias=True)

    start: float = Field(alias="from", description="First value.")
    to: float = Field(description="Last value, if a step ends there.")
    step: float | None = Field(default=None, description="Step from value to value.")
    count: int | None = Field(default=None, description="Number of values, the last one included; in place of step.")


class Case(Strict):
    """A meshing case: a domain, a spacing and how to mesh."""

    base: str | None = Field(default=None, description="Case file to extend, relative to this one.")
    name: FileName | None = Field(
        default=None, description="Stem of the output files, by default that of the case file."
    )
    parameters: dict[Annotated[str, AfterValidator(_parameter_name)], Parameter] = Field(
        default={},
        description="Constants, or expressions of others, that expressions name, and texts in braces: part-{r}.dxf.",
    )
    crs: CrsKeys | None = Field(
        default=None,
        description="Coordinate reference systems, for places on the earth: lengths are in metres, and may have units.",
    )
    domain: DomainKeys = Field(description="The domain to mesh.")
    spacing: AnySpacing = Field(
        description="Wanted edge length: a number, an expression in x, y and the parameters, or several terms."
    )
    metric: OneOrMore[AnyMetric] | None = Field(
        default=None,
        description="Spacing that depends on the direction, below that of the case, or a list: packed by ellipses.",
    )
    layers: Annotated[tuple[LayerKeys, ...], BeforeValidator(not_empty)] | None = Field(
        default=None, description="Boundary layers: thin cells along walls, a list with an entry for each kind."
    )
    angle_min: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=30)] | None = Field(
        default=None,
        description="Least angle of the triangles in degrees, but in sharper corners: nodes are added where they need "
        "it.",
    )
    largest: PositiveArea | None = Field(
        default=None, description="Largest area of a triangle: the spacing is finer, and nodes are added, if need be."
    )
    overconstrained: Literal["split"] | None = Field(
        default=None,
        description="What becomes of triangles with all their nodes on the boundary: split gives each a node inside.",
    )
    parts: Parts | None = Field(
        default=None,
        description="Number of parts to pack side by side and join, or auto; else the mesh is made in one piece.",
    )
    method: str = Field(
        default=MULTILEVEL, description="Name of the packing method; a case with a metric has ellipses."
    )
    packing: dict[str, Any] = Field(default={}, description="Options of the packing method, such as seed.")
    schedule: dict[str, Any] = Field(default={}, description="Rounds and iterations of the published methods.")
    output: Output = Field(default=Output(), description="What to write, and where.")
    limits: Limits = Field(default=Limits(), description="What stops a case that is too large.")
    sweep: dict[str, list[Any] | RangeKeys] | None = Field(
        default=None,
        description="Values or ranges for keys such as packing.w2, for a case of each combination (batch only).",
    )
    require: Requirements = Field(default=Requirements(), description="The quality that the mesh must reach.")

    @model_validator(mode="before")
    @classmethod
    def _method_of_metric(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("metric") is None or "method" in data:
            return data
        return data | {"method": IN_METRIC}

    _origin: Origin = PrivateAttr(default_factory=Origin)
    _warnings: tuple[str, ...] = PrivateAttr(default=())

    @property
    def origin(self) -> Origin:
        """Places of the keys, if the case comes from a file."""
        return self._origin

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings on keys that were left out on loading, or that have no effect on this system."""
        return (*self._warnings, *unlimited_memory(self.limits.max_memory_mb))

    @property
    def root(self) -> Path | None:
        """Folder that contains all files of an untrusted case; None for a trusted one."""
        return self._origin.root

    def loaded(self, origin: Origin, warnings: tuple[str, ...]) -> "Case":
        """Copy of the case with its origin, and warnings on loading it."""
        case = self.model_copy()
        case._origin, case._warnings = origin, warnings
        return case

    @property
    def spacing_terms(self) -> SpacingTerms:
        """The terms of the spacing; a plain value is the only term."""
        return as_terms(self.spacing)


def case_template() -> str:
    """The commented case file that ``bubblemesh init`` writes."""
    return files(__package__).joinpath("template.yaml").read_text(encoding="utf-8")


def case_schema() -> dict[str, Any]:
    """The JSON Schema of the case file, for editors, with the methods and all keys that a method may use."""
    # Imported here since the methods need SciPy, for which reading a case should not wait.
    from bubblemesh.packing.configure import all_options
    from bubblemesh.packing.methods import METHODS

    schema = Case.model_json_schema()
    properties = schema["properties"]
    properties["method"]["enum"] = list(METHODS)
    for section in ("packing", "schedule"):
        properties[section] |= {"properties": {}, "additionalProperties": False}
    for option in all_options():
        properties[option.section]["properties"][option.key] = {"description": option.meaning, **option.schema}
    # Keys that are required may come from the base, if there is one.
    schema["anyOf"] = [{"required": schema.pop("required")}, {"required": ["base"]}]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_with_overlaps(schema)}


def _with_overlaps(schema: Any) -> Any:
    """Schema with ``anyOf`` in place of ``oneOf``, since a value may fit several alternatives of a choice.

    Pydantic writes ``oneOf`` where a function chooses the model, even if, say, a text is both a name and an expression.
    """
    if isinstance(schema, list):
        return [_with_overlaps(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {"anyOf" if key == "oneOf" else key: _with_overlaps(part) for key, part in schema.items()}
