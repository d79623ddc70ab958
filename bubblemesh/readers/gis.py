"""Shapefiles and GeoPackages: features in layers.

The library behind them, GDAL, opens files of any format that it knows, also those that lead to other files or to the
network. So it gets no path, but only bytes, after a check that they begin like a shapefile or a GeoPackage.
"""

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from io import BytesIO
from itertools import repeat
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pyogrio

from bubblemesh.errors import BubblemeshError, CaseError
from bubblemesh.files import beside, read_bytes
from bubblemesh.messages import shown
from bubblemesh.process.shared import warnings_are
from bubblemesh.readers.degrees import is_geographic
from bubblemesh.readers.features import (
    NO_HEIGHTS,
    NO_PARTS,
    Feature,
    FeatureCollection,
    feature_name,
    feature_of,
    parts_of,
)
from bubblemesh.readers.selection import Selection, one_of
from bubblemesh.readers.simple_features import shape_of_wkb

SHAPEFILE = (9994).to_bytes(4, "big")
SHAPEFILE_PARTS = (".shx", ".dbf", ".prj", ".cpg")
HEAD, LENGTH = 100, slice(24, 28)  # bytes of the header of a .shp or .shx, and of the file's length in it
WORD = 2  # bytes: unit of lengths in a shapefile
SQLITE = b"SQLite format 3\0"
GEOPACKAGE = (b"GPKG", b"GP10", b"GP11")  # at APPLICATION
APPLICATION = slice(68, 72)
VERSIONS = slice(18, 20)  # versions for reading and writing: 2 if there may be a log file beside the database
DAMAGED = sqlite3.Error, UnicodeError  # UnicodeError if SQLite quotes bytes that are not text
NO_NETWORK = {"CPL_VSIL_CURL_ALLOWED_FILENAME": "none", "PROJ_NETWORK": "OFF", "GDAL_PAM_ENABLED": "NO"}


def read_shapefile(path: Path, selection: Selection, layer: str | None) -> FeatureCollection:
    """The features of a shapefile, whose only layer has the file's name; the same errors as `read_geopackage`."""
    content = read_bytes(path)
    if not content.startswith(SHAPEFILE):
        raise _invalid("shapefile", "it does not begin as one")
    parts = {part.suffix.lower(): read_bytes(part) for part in beside(path, SHAPEFILE_PARTS)} | {".shp": content}
    if ".shx" not in parts:
        raise _invalid("shapefile", "there is no .shx beside it")
    _require_whole(content, parts[".shx"])
    # GDAL fails if the reference system is incomplete, and is not needed for it.
    system = parts.pop(".prj", b"").decode("latin-1") or None
    archive = BytesIO()
    with ZipFile(archive, "w") as file:
        for ending, part in parts.items():
            file.writestr(f"data{ending}", part)
    one_of([path.stem], layer, "layer", "layer")
    found = _features(archive.getvalue(), "data", path.stem, "shapefile", "ESRI Shapefile", system, selection)
    return found if ".dbf" in parts else replace(found, absent=".dbf")


def _require_whole(shapes: bytes, index: bytes) -> None:
    """Check that a .shp and its .shx are complete and belong together; CaseError if not.

    From others GDAL would read features without a shape, or fewer features.
    """
    for ending, part in ((".shp", shapes), (".shx", index)):
        if len(part) < _length_of(part):
            raise _invalid("shapefile", f"its {ending} is cut off, at {len(part):,} of {_length_of(part):,} bytes")
    count = (_length_of(index) - HEAD) // 8
    records = np.frombuffer(index, ">i4", 2 * count, HEAD).reshape(-1, 2).astype(np.int64)
    ends = WORD * records.sum(axis=1) + 8  # offset and length of each record, and its header
    if ends.max(initial=HEAD) != _length_of(shapes):
        raise _invalid("shapefile", "its .shx is that of another .shp")


def _length_of(part: bytes) -> int:
    """Length in bytes of a .shp or .shx by its own header."""
    return max(WORD * int.from_bytes(part[LENGTH], "big"), HEAD)


def read_geopackage(path: Path, selection: Selection, layer: str | None) -> FeatureCollection:
    """The features of one layer, a table; FileError, or CaseError or GeometryError with the feature.

    Views are left out. Virtual tables, which may take for ever or lead to other files, are refused, except indices of
    the file itself.
    """
    content = read_bytes(path)
    if not content.startswith(SQLITE) or content[APPLICATION] not in GEOPACKAGE:
        raise _invalid("GeoPackage", "it does not begin as one")
    if any(read_bytes(log) for log in beside(path, (f"{path.suffix}-wal",))):
        raise CaseError("another program has not yet written all into it: close the file there")
    content = _plain(content)
    with _quiet("GeoPackage"):
        layer = one_of([str(name) for name, _ in pyogrio.list_layers(content)], layer, "layer", "layer")
    return _features(content, layer, layer, "GeoPackage", "GPKG", _system(content, layer), selection)


def _plain(content: bytes) -> bytes:
    """The content of a database with its plain tables only; CaseError if one of the tables is not a plain one."""
    version_of_no_log = content[: VERSIONS.start] + b"\1\1" + content[VERSIONS.stop :]
    try:
        with closing(sqlite3.connect(":memory:", isolation_level=None)) as database:
            database.deserialize(version_of_no_log)
            views = database.execute("SELECT name FROM sqlite_master WHERE type = 'view'").fetchall()
            for (name,) in views:
                database.execute(f"DROP VIEW {_quoted(name)}")
            for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall():
                _require_table(database, name)
            return database.serialize() if views else version_of_no_log
    except DAMAGED as error:
        raise _invalid("GeoPackage", shown(error, 90)) from None


def _system(content: bytes, layer: str) -> str | None:
    """The coordinate reference system of a layer as well-known text, if the GeoPackage has one."""
    query = "SELECT definition FROM gpkg_spatial_ref_sys JOIN gpkg_contents USING (srs_id) WHERE table_name = ?"
    try:
        with closing(sqlite3.connect(":memory:", isolation_level=None)) as database:
            database.deserialize(content)
            found = database.execute(query, (layer,)).fetchone()
    except DAMAGED:
        return None
    return str(found[0]) if found else None


def _require_table(database: sqlite3.Connection, name: str) -> None:
    advice = "save the layer in a GeoPackage of its own"
    try:
        database.execute(f"EXPLAIN SELECT * FROM {_quoted(name)}").close()
    except sqlite3.OperationalError as error:  # no such module: a virtual table of an extension, which is not read
        raise CaseError(f"its table {shown(name, 40)!r} cannot be read ({shown(error)}): {advice}") from None
    columns = database.execute(f"PRAGMA table_xinfo({_quoted(name)})").fetchall()
    if any(hidden in (2, 3) for *_, hidden in columns):
        raise CaseError(f"its table {shown(name, 40)!r} has columns that are computed: {advice}")


def _quoted(name: str) -> str:
    return '"{}"'.format(name.replace('"', '""'))


@contextmanager
def _quiet(kind: str) -> Iterator[None]:
    """Within the block, GDAL has no network and prints no warnings; its errors become those of a file of this kind."""
    with warnings_are("ignore"):  # they would be printed on the terminal
        options = {name: pyogrio.get_gdal_config_option(name) for name in NO_NETWORK}
        pyogrio.set_gdal_config_options(NO_NETWORK)
        try:
            yield
        except BubblemeshError:
            raise
        except Exception as error:  # its own errors, and any others for damaged files
            raise _invalid(kind, shown(re.sub(r"\S*/vsi\S*", "it", str(error)).partition(";")[0], 90)) from None
        finally:
            pyogrio.set_gdal_config_options(options)


def _invalid(kind: str, reason: str) -> CaseError:
    return CaseError(f"not a valid {kind}: {reason}: write it anew, with all of its parts")


def _features(
    content: bytes, inside: str, layer: str, kind: str, driver: str, system: str | None, selection: Selection
) -> FeatureCollection:
    """The features of a layer, by its name ``inside`` the content, whose coordinates have some reference system.

    CaseError or GeometryError with the feature.
    """
    with _quiet(kind):
        known = pyogrio.read_info(content, layer=inside)["driver"]
        if known != driver:
            raise _invalid(kind, f"it is read as {known}")
        meta, numbers, shapes, columns = pyogrio.raw.read(content, layer=inside, return_fids=True)
    fields, bare = [str(key) for key in meta["fields"]], list[Feature]()
    rows = zip(*(column.tolist() for column in columns), strict=True) if columns else repeat(())
    for k, (number, row) in enumerate(zip(numbers.tolist(), rows, strict=False)):
        properties = dict(zip(fields, row, strict=True))
        bare.append(Feature(feature_name(k, properties, "name"), layer, {"fid": number} | properties))
    if not bare:
        raise CaseError("there are no features in it: give polygons, or lines that meet")

    def with_geometry(number: int, one: Feature) -> Feature:
        wkb = shapes[number]
        parts = NO_PARTS if wkb is None else parts_of(shape_of_wkb(wkb, one.name))
        return feature_of(parts, one.name, layer, one.properties)

    notes = (NO_HEIGHTS,) if "Z" in str(meta["geometry_type"]).upper().split() else ()
    found = selection.converted(bare, with_geometry)
    return FeatureCollection(found, notes, system=system, degrees=is_geographic(system))
