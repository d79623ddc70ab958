"""Shapefiles, GeoPackages and what else holds features in layers."""

import warnings
from pathlib import Path

import numpy as np
import pyogrio
import shapely

from bubblemesh.errors import CaseError
from bubblemesh.messages import meant, shown
from bubblemesh.readers.features import NO_HEIGHTS, FeatureCollection, feature_name, feature_of

KINDS = {".shp": "shapefile", ".gpkg": "GeoPackage"}


def read_gis(path: Path, layer: str | None) -> FeatureCollection:
    """The features of one layer; CaseError or GeometryError with the feature."""
    try:
        with warnings.catch_warnings():  # what is wrong with the file would be said to the terminal
            warnings.simplefilter("ignore")
            layer = _chosen(layer, [str(name) for name, _ in pyogrio.list_layers(path)])
            meta, numbers, shapes, columns = pyogrio.raw.read(path, layer=layer, return_fids=True)
    except RuntimeError as error:  # of which all of pyogrio's are kinds
        reason = shown(str(error).replace(str(path), path.name).partition(";")[0], 90)
        kind = KINDS.get(path.suffix.lower(), "file")
        raise CaseError(f"not a valid {kind}: {reason}: write it anew, with all of its parts") from None
    features = []
    for k, (number, wkb) in enumerate(zip(numbers.tolist(), shapes, strict=True)):
        values = {str(key): column[k] for key, column in zip(meta["fields"], columns, strict=True)}
        properties = {key: value.item() if hasattr(value, "item") else value for key, value in values.items()}
        name = feature_name(k, properties, "name")
        if wkb is None:
            raise CaseError(f"{name}: it has no geometry: the file may be cut off, or choose another feature")
        features.append(feature_of(_shape(wkb, name), name, layer, {"fid": number} | properties))
    if not features:
        raise CaseError("there are no features in it: give polygons, or lines that meet")
    degrees = meta["crs"] is not None and str(meta["crs"]).upper() in ("EPSG:4326", "OGC:CRS84", "EPSG:4269")
    notes = (
        ("coordinates are degrees and taken as they are: project them to a plane for a true shape",) if degrees else ()
    )
    if "Z" in str(meta["geometry_type"]).upper().split():
        notes = (*notes, NO_HEIGHTS)
    return FeatureCollection(tuple(features), notes)


def _chosen(layer: str | None, layers: list[str]) -> str:
    """The layer to read: the one asked for, or the only one."""
    if layer is None and len(layers) != 1:
        choice = f"choose one by layer: {', '.join(layers)}" if layers else "give one with a layer"
        raise CaseError(f"it has {len(layers)} layers: {choice}")
    if layer is not None and layer not in layers:
        raise CaseError(f"it has no layer {layer!r}: {meant(layer, layers)}")
    return layers[0] if layer is None else layer


def _shape(wkb: bytes, name: str) -> shapely.Geometry:
    try:
        with np.errstate(invalid="ignore"):  # numbers that are none are told by `feature_of`, with their place
            return shapely.from_wkb(wkb)
    except (shapely.errors.GEOSException, NotImplementedError) as error:
        advice = "give polygons or lines of straight parts"
        raise CaseError(f"{name}: not a valid geometry: {shown(error)}: {advice}") from None
