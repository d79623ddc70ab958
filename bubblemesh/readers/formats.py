"""A file chosen by its ending, and what a case takes of it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from glob import escape
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from bubblemesh.errors import BubblemeshError, CaseError, FileError, GeometryError
from bubblemesh.files import local_copy, require_readable
from bubblemesh.geometry.rings import Ring
from bubblemesh.messages import meant
from bubblemesh.readers.chains import chained
from bubblemesh.readers.features import Content, Feature
from bubblemesh.readers.nesting import nested

METRES = {
    "m": 1.0,
    "km": 1e3,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "in": 0.0254,
    "ft": 0.3048,
    "mil": 2.54e-5,
}


class Reader(NamedTuple):
    """Where the function is that reads a format, the extra that installs what it needs, and files that belong to it."""

    function: str
    extra: str | None = None
    beside: tuple[str, ...] = ()


READERS = {
    ".geojson": Reader("simple_features.read_geojson"),
    ".json": Reader("simple_features.read_geojson"),
    ".wkt": Reader("simple_features.read_wkt"),
    ".csv": Reader("tables.read_table"),
    ".dat": Reader("tables.read_table"),
    ".tsv": Reader("tables.read_table"),
    ".txt": Reader("tables.read_table"),
    ".xy": Reader("tables.read_table"),
    ".poly": Reader("triangle.read_poly", beside=(".node",)),
    ".dxf": Reader("dxf.read_dxf", "dxf"),
    ".svg": Reader("svg.read_svg", "svg"),
    ".shp": Reader("gis.read_gis", "gis", (".shx", ".dbf", ".prj", ".cpg")),
    ".gpkg": Reader("gis.read_gis", "gis"),
}
CHOOSES_LAYER = ("gis.read_gis",)  # readers that read one layer only


@dataclass(frozen=True)
class Selection:
    """What a case takes of a file.

    Attributes
    ----------
    layers : tuple of str
        Only features on these layers; empty for all.
    feature : int or mapping, optional
        Number of the one feature, from 0, or the properties of those to take.
    scale : float
        By which the file's lengths are multiplied.
    unit : str, optional
        The file's unit of length, in place of ``scale``; the case's is the metre.
    join : float, optional
        Ends of curves nearer than this meet, in the file's unit.
    """

    layers: tuple[str, ...] = ()
    feature: int | Mapping[str, Any] | None = None
    scale: float = 1.0
    unit: str | None = None
    join: float | None = None

    @property
    def factor(self) -> float:
        """By which the file's lengths are multiplied."""
        return self.scale if self.unit is None else METRES[self.unit]

    def of(self, features: Sequence[Feature]) -> list[Feature]:
        """The features to take.

        Raises
        ------
        CaseError
            If there is none of them; the text lists what there is.
        """
        found = list(features)
        for layer in self.layers:
            known = sorted({str(one.layer) for one in features if one.layer is not None})
            if layer not in known:
                advice = meant(layer, known) if known else "it has no layers, leave layer out"
                raise CaseError(f"it has no layer {layer!r}: {advice}")
        if self.layers:
            found = [one for one in found if one.layer in self.layers]
        if isinstance(self.feature, int):
            if self.feature >= len(found):
                advice = f"a number from 0 to {len(found) - 1}" if found else "another layer, this one has none"
                raise CaseError(f"it has no feature {self.feature}: give {advice}")
            return [found[self.feature]]
        for key, value in (self.feature or {}).items():
            known = sorted({name for one in found for name in one.properties})
            if key not in known:
                advice = meant(key, known) if known else "there are no properties, give a number"
                raise CaseError(f"no feature has the property {key!r}: {advice}")
            values = [one.properties.get(key) for one in found]
            found = [one for one, has in zip(found, values, strict=True) if has == value or str(has) == str(value)]
            if not found:
                there = dict.fromkeys(str(has) for has in values)
                raise CaseError(f"no feature has {key}: {value}: {meant(str(value), list(there)[:20])}")
        return found


def read_rings(path: Path, chosen: Selection) -> list[Ring]:
    """Closed rings of a file, however they nest; the first has the notes on the whole file.

    Raises
    ------
    FileError, CaseError, GeometryError
        With the file and the feature, point or line.
    """

    def rings_of(areas: list[tuple[Ring, ...]], loose: list[Ring], content: Content) -> list[Ring]:
        holed = next((area for area in areas if len(area) > 1), None)
        if holed is not None:
            raise GeometryError(
                f"an area with {len(holed) - 1} holes is no ring: give it as domain: {{file: {path.name}}}"
            )
        return [*(area[0] for area in areas), *loose]

    return _read(path, chosen, rings_of)


def read_area(path: Path, chosen: Selection) -> list[Ring]:
    """Outer ring and holes of the one area of a file; the first has the notes on the whole file.

    Raises
    ------
    FileError, CaseError, GeometryError
        With the file and the feature, point or line.
    """

    def rings_of(areas: list[tuple[Ring, ...]], loose: list[Ring], content: Content) -> list[Ring]:
        if len(areas) == 1 and not loose:
            return list(areas[0])
        outer, holes = nested([*(ring for area in areas for ring in area), *loose], content.holes)
        return [outer, *holes]

    return _read(path, chosen, rings_of)


def files_of(path: Path) -> list[Path]:
    """The file, and those that belong to it: the parts of a shapefile, the nodes of a ``.poly`` file."""
    reader = READERS.get(path.suffix.lower())
    beside = () if reader is None else reader.beside
    others = path.parent.glob(f"{escape(path.stem)}.*") if beside else ()
    return [path, *sorted(other for other in others if other.suffix.lower() in beside and other.stem == path.stem)]


def _read(
    path: Path, chosen: Selection, rings_of: Callable[[list[tuple[Ring, ...]], list[Ring], Content], list[Ring]]
) -> list[Ring]:
    try:
        content = _content(path, chosen)
        features = chosen.of(content.features)
        joined, gaps = chained([stroke for one in features for stroke in one.strokes], chosen.join)
        areas = [area for one in features for area in one.areas]
        loose = [*(ring for one in features for ring in one.rings), *joined]
        if not areas and not loose:
            raise CaseError("there is no ring in it: give closed curves, or lines that meet")
        rings = rings_of(areas, loose, content)
    except BubblemeshError as error:
        raise type(error)(f"{path}: {error}") from None
    notes = [*content.notes, *dict.fromkeys(note for one in features for note in one.notes), *gaps]
    if chosen.unit and content.unit and chosen.unit != content.unit:
        notes.append(f"its header gives lengths in {content.unit}, the case in {chosen.unit}: the case counts")
    first, *others = (
        replace(
            ring.scaled(chosen.factor),
            notes=_named(path, ring.notes),
            origin=f"{path.name}: {ring.origin}{'' if chosen.factor == 1 else f', lengths times {chosen.factor:g}'}",
        )
        for ring in rings
    )
    return [replace(first, notes=(*_named(path, notes), *first.notes)), *others]


def _named(path: Path, notes: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"{path.name}: {note}" for note in notes)


def _content(path: Path, chosen: Selection) -> Content:
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise FileError(f"no known geometry format: the name must end in {', '.join(READERS)}")
    path = local_copy(path)
    require_readable(path)
    module, function = reader.function.split(".")
    try:
        read = getattr(import_module(f"bubblemesh.readers.{module}"), function)
    except ModuleNotFoundError as error:
        if reader.extra is None or (error.name or "").startswith("bubblemesh"):
            raise
        raise FileError(
            f'{(error.name or "").partition(".")[0]} is needed to read it: pip install "bubblemesh[{reader.extra}]"'
        ) from None
    if reader.function in CHOOSES_LAYER:
        if len(chosen.layers) > 1:
            raise CaseError("one layer of such a file can be read: give one")
        return read(path, next(iter(chosen.layers), None))
    return read(path)
