"""The formats by the endings of files, and the rings of the features that a case takes from a file.

A new format is a module beside this one, and its rows in `FORMATS`.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.errors import CaseError, FileError, prefixed
from bubblemesh.files import beside, local_copy, require_readable
from bubblemesh.geometry.map_projection import UNPROJECTED, MapProjection
from bubblemesh.geometry.paths import Area, Point, Ring
from bubblemesh.geometry.similarity import Similarity
from bubblemesh.messages import counted, given_coordinates, shown, tell_places_of
from bubblemesh.readers.areas import areas_by_nesting, chosen_areas
from bubblemesh.readers.contents import parsed_once
from bubblemesh.readers.degrees import degrees_notes
from bubblemesh.readers.features import Feature, FeatureCollection, vertices_of
from bubblemesh.readers.outlines import bounding, joining_of
from bubblemesh.readers.projection import projected_features
from bubblemesh.readers.regions import OF_ANY_FEATURE, largest_by_name, named_areas, named_points
from bubblemesh.readers.selection import METRES, Purpose, Selection


class GeometryFormat(NamedTuple):
    """How files with an ending are read."""

    read: str  # module and function, imported when needed, that returns the `FeatureCollection` of a path
    extra: str | None = None  # extra of the package that it needs
    beside: tuple[str, ...] = ()  # endings of further files that belong to the file
    one_layer: bool = False  # whether the function reads one layer, its last argument
    selects: bool = False  # whether it takes the selection as well, and reads only geometry that is selected
    lines: str | None = None  # function for open lines, if a list of points may be lines or rings
    points: str | None = None  # function for points, likewise
    has_inner_lines: bool = False  # whether files may have lines within the domain that they describe
    of_maps: bool = False  # whether its coordinates are mostly places on the earth


LISTS = GeometryFormat("point_lists.read_rings", lines="point_lists.read_lines", points="point_lists.read_points")


FORMATS = {
    ".geojson": GeometryFormat("simple_features.read_geojson", selects=True, of_maps=True),
    ".json": GeometryFormat("simple_features.read_geojson", selects=True, of_maps=True),
    ".topojson": GeometryFormat("simple_features.read_geojson", selects=True, of_maps=True),
    ".geojsonl": GeometryFormat("simple_features.read_geojson_lines", selects=True, of_maps=True),
    ".geojsons": GeometryFormat("simple_features.read_geojson_lines", selects=True, of_maps=True),
    ".ndjson": GeometryFormat("simple_features.read_geojson_lines", selects=True, of_maps=True),
    ".wkt": GeometryFormat("simple_features.read_wkt"),
    ".wkb": GeometryFormat("simple_features.read_wkb"),
    ".csv": LISTS,
    ".dat": LISTS,
    ".tsv": LISTS,
    ".txt": LISTS,
    ".xy": LISTS,
    ".poly": GeometryFormat("triangle.read_poly", beside=(".node",), has_inner_lines=True),
    ".node": GeometryFormat("triangle.read_nodes"),
    ".dxf": GeometryFormat("dxf.read_dxf", "dxf"),
    ".svg": GeometryFormat("svg.svg.read_svg", "svg"),
    ".shp": GeometryFormat(
        "gis.read_shapefile", "gis", (".shx", ".dbf", ".prj", ".cpg"), one_layer=True, selects=True, of_maps=True
    ),
    ".gpkg": GeometryFormat("gis.read_geopackage", "gis", one_layer=True, selects=True, of_maps=True),
}


def is_of_maps(path: Path) -> bool:
    """Whether the coordinates of a file, by its ending, are mostly places on the earth."""
    known = FORMATS.get(path.suffix.lower())
    return known is not None and known.of_maps


PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".gif", ".bmp")
# For formats that are not read, how to convert such a file.
ELSEWHERE = {
    (".kml", ".kmz", ".gml", ".gpx", ".fgb", ".gdb", ".osm", ".pbf", ".tab", ".mif", ".e00", ".parquet"): (
        "convert it by ogr2ogr {0}.geojson {1}, or export it from QGIS"
    ),
    (".dwg", ".dgn", ".step", ".stp", ".iges", ".igs", ".brep", ".sat", ".ipt", ".sldprt", ".fcstd"): (
        "export its outline as {0}.dxf from a drawing program"
    ),
    (".ai", ".eps", ".pdf", ".cdr", ".wmf", ".emf"): "export it as {0}.svg from a drawing program",
    PICTURES: "trace its outlines to {0}.svg, as Inkscape does",
    (".gz", ".svgz", ".bz2", ".xz", ".zip", ".7z"): "unpack {1} first",
}


class RegionPoint(NamedTuple):
    """A point of a file in a region with a name, and notes on the whole file."""

    at: Point
    name: str
    notes: tuple[str, ...]


class Chosen(NamedTuple):
    """Part of a file that a case takes: areas with their holes, rings that may be nested, points in holes, notes."""

    areas: list[Area]
    loose: list[Ring]
    hole_points: Sequence[Point] | None
    notes: list[str]
    factor: float  # from the file's lengths to the case's


def read_areas(path: Path, selection: Selection, projection: MapProjection = UNPROJECTED) -> list[Area]:
    """The area of a file, by the nesting of its rings, or the areas in the selection's part, the largest first.

    The first ring has the notes on the whole file. FileError, CaseError or GeometryError with the file and the feature,
    point or line.
    """
    with prefixed(path):
        chosen = _chosen(path, selection, projection, is_map=is_of_maps(path), single=selection.part is None)
        areas = areas_by_nesting(chosen.areas, chosen.loose, chosen.hole_points)
        part = selection.part
        if selection.repair is not None:
            part = "all" if part is None and len(areas) == 1 else part  # a repair may make several pieces of one area
            areas = selection.repair(areas)
        areas = chosen_areas(areas, part)
    return _finished(path, chosen.factor, areas, chosen.notes)


def read_shapes(
    path: Path, selection: Selection, projection: MapProjection = UNPROJECTED, united: bool = False, nested: bool = True
) -> list[Area]:
    """Areas and closed rings of a file, nested or not, or those in the selection's part.

    A repair mends each by itself; with ``united`` those that overlap become one, after they have nested if they are
    ``nested``. The first ring has the notes on the whole file; the same errors as `read_areas`.
    """
    with prefixed(path):
        chosen = _chosen(path, selection, projection)
        areas = [*chosen.areas, *map(Area, chosen.loose)]
        repair = selection.repair
        if repair is not None and united and repair.mend:
            areas = repair(areas_by_nesting(chosen.areas, chosen.loose, None) if nested else areas)
        elif repair is not None:
            areas = repair(areas, united=False)
        if selection.part is not None:
            areas = chosen_areas(areas, selection.part)
    return _finished(path, chosen.factor, areas, chosen.notes)


def read_regions(
    path: Path,
    selection: Selection,
    key: str,
    projection: MapProjection = UNPROJECTED,
    limits: bool = True,
    ordered: bool = False,
) -> list[Area] | list[RegionPoint]:
    """Areas of a file whose features share borders, named by their property ``key``, or by their layer for "layer".

    With ``limits`` they have the largest areas of triangles that the file gives; if they are ``ordered``, later ones
    cover earlier ones of other names. The first ring has the notes on the
    whole file. If all named features are points they are returned, the first one with the notes. The same errors as
    `read_areas`, and GeometryError if neighbours overlap.
    """
    with prefixed(path):
        if path.suffix.lower() in (*PICTURES, ".npy", ".npz"):
            raise FileError(
                f"{path.suffix} is not read: rasterio.features.shapes makes polygons of an image with labels, which "
                'share their borders: "Images with labels" in docs/regions.md has a program for it'
            )
        content = read_content(path, selection, "points")  # a ring in a list of points would have no name
        if key not in OF_ANY_FEATURE:
            content.require_properties()
        features = projected_features(path, content, selection, projection)
        size, size_notes = _measured(content, features, selection, projection)
        points = named_points(features, key)
        if points:
            factor, notes = selection.factor(content), [*content.notes, *size_notes]
            told = tuple(f"{path.name}: {note}" for note in notes)
            return [
                RegionPoint((x * factor, y * factor), name, () if k else told)
                for k, ((x, y), name) in enumerate(points)
            ]
        areas, notes = named_areas(features, key, selection, size, ordered)
        if selection.repair is not None:
            areas = selection.repair.of_neighbours(areas)
        given = largest_by_name(features, key) if limits else {}
        areas = [replace(area, largest=given.get(str(area.name))) for area in areas]
    size_notes += _limit_notes([area.largest for area in areas if area.largest is not None])
    return _finished(path, selection.factor(content), areas, [*content.notes, *notes, *size_notes])


def _limit_notes(limits: Sequence[float]) -> list[str]:
    """Note on the largest areas of triangles that a file gives for regions."""
    if not limits:
        return []
    values = f"{min(limits):g}" if min(limits) == max(limits) else f"{min(limits):g} to {max(limits):g}"
    return [f"largest areas of triangles are those of the file in {counted(len(limits), 'region')} ({values})"]


def files_of(path: Path) -> list[Path]:
    """The file, and those that belong to it: the parts of a shapefile, the nodes of a ``.poly`` file."""
    known = FORMATS.get(path.suffix.lower())
    return [path, *beside(path, () if known is None else known.beside)]


def _chosen(
    path: Path, selection: Selection, projection: MapProjection, is_map: bool = False, single: bool = False
) -> Chosen:
    """Part of a file that the selection takes, with curves that meet joined into rings.

    For messages ``is_map`` is that of `degrees_notes`, and ``single`` that of `bounding`.
    """
    content = read_content(path, selection)
    features = projected_features(path, content, selection, projection)
    size, size_notes = _measured(content, features, selection, projection, is_map)
    found = bounding(features, joining_of(selection, size), whole=selection.feature is None, single=single)
    areas = [Area(outer, tuple(holes)) for outer, *holes in found.areas]
    notes = [*content.notes, *found.notes, *size_notes]
    if selection.join is not None and found.areas and not any(one.curves for one in features):
        notes.append(
            f"join: {selection.join:g} does nothing here, as it is for ends of lines, and there are only polygons: "
            f"repair: {{gap: {selection.join:g}}} closes gaps between these"
        )
    holes = None if content.hole_points is None else tuple(map(projection.point, content.hole_points))
    return Chosen(areas, found.loose, holes, notes, selection.factor(content))


def _measured(
    content: FeatureCollection,
    features: Sequence[Feature],
    selection: Selection,
    projection: MapProjection,
    is_map: bool = False,
) -> tuple[float, list[str]]:
    """Size of the features, by which messages round places from now on, and notes on their unit.

    ``is_map`` is that of `degrees_notes`.
    """
    points = vertices_of(features)
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    tell_places_of(size)
    degrees = content.degrees if projection.system is None else False
    return size, [*degrees_notes(points, degrees, is_map), *length_notes(content, selection)]


def length_notes(content: FeatureCollection, selection: Selection) -> Iterator[str]:
    """Notes on the unit of length that a case gives, if the file has another one or does not name any."""
    if selection.unit and content.unit and selection.unit != content.unit:
        yield f"its header gives lengths in {content.unit}, the case in {selection.unit}: the case counts"
    if selection.unit and content.physical and content.physical.assumed:
        yield (
            "it has no width or height with a unit beside a viewBox: 96 of its lengths are an inch; if they are in "
            f"{selection.unit}, set scale: {METRES[selection.unit]:g} in place of units"
        )


@given_coordinates()
def read_content(path: Path, selection: Selection, purpose: Purpose = "rings") -> FeatureCollection:
    """Content of a file; the purpose decides how lists of points are read. FileError or CaseError."""
    known = FORMATS.get(path.suffix.lower())
    if known is None:
        ways = (way for endings, way in ELSEWHERE.items() if path.suffix.lower() in endings)
        advice = next(
            (f"{path.suffix} is not read: {way.format(shown(path.stem), shown(path.name))}; " for way in ways), ""
        )
        raise FileError(f"no known geometry format: {advice}the name must end in {', '.join(FORMATS)}")
    path = local_copy(path)
    require_readable(path)
    read_as = {"lines": known.lines, "points": known.points}.get(purpose) or known.read
    module, _, function = read_as.rpartition(".")
    try:
        read: Any = getattr(import_module(f"bubblemesh.readers.{module}"), function)
    except ModuleNotFoundError as error:
        if known.extra is None or (error.name or "").startswith("bubblemesh"):
            raise
        library = (error.name or "").partition(".")[0]
        raise FileError(f'{library} is needed to read it: pip install "bubblemesh[{known.extra}]"') from None
    if known.one_layer and len(selection.layers) > 1:
        raise CaseError("one layer of such a file can be read: give one")
    layer = [next(iter(selection.layers), None)] if known.one_layer else []
    arguments = [*([selection] if known.selects else []), *layer]
    return parsed_once((path, read_as, selection.layers, repr(selection.feature)), lambda: read(path, *arguments))


def _finished(path: Path, factor: float, areas: Sequence[Area], notes: Iterable[str]) -> list[Area]:
    """The areas in the case's lengths, with the file in front of the origins and the notes of rings."""
    times = "" if factor == 1 else f", lengths times {factor:g}"
    by = Similarity.of(scale=factor)
    left = [*notes]

    def finished(ring: Ring) -> Ring:
        named = tuple(f"{path.name}: {note}" for note in (*left, *ring.notes))
        left.clear()
        origin = f"{path.name}: {ring.origin}{times}"
        return replace(ring, notes=named, origin=origin)

    return [area.moved(by).mapped(finished) for area in areas]
