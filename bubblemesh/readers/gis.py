"""Shapefiles, GeoPackages and what else holds features in layers."""

from pathlib import Path

import pyogrio
import shapely
from pyogrio.errors import DataSourceError

from bubblemesh.errors import CaseError
from bubblemesh.readers.features import Content, feature_name
from bubblemesh.readers.shapes import feature_of
from bubblemesh.wording import meant

__all__ = ["read_gis"]


def read_gis(path: Path, layer: str | None) -> Content:
    """The features of one layer.

    Raises
    ------
    CaseError, GeometryError
        With the feature.
    """
    try:
        layers = [str(name) for name, _ in pyogrio.list_layers(path)]
        if layer is None and len(layers) > 1:
            raise CaseError(f"it has {len(layers)} layers: choose one by layer: {', '.join(layers)}")
        if layer is not None and layer not in layers:
            raise CaseError(f"it has no layer {layer!r}: {meant(layer, layers)}")
        meta, numbers, shapes, columns = pyogrio.raw.read(path, layer=layer or layers[0], return_fids=True)
    except DataSourceError as error:
        raise CaseError(f"not a valid file of its kind: {error}") from None
    features = []
    for k, (number, wkb) in enumerate(zip(numbers.tolist(), shapes, strict=True)):
        values = {str(key): column[k] for key, column in zip(meta["fields"], columns, strict=True)}
        properties = {key: value.item() if hasattr(value, "item") else value for key, value in values.items()}
        name = feature_name(k, properties, "name")
        if wkb is None:
            raise CaseError(f"{name}: it has no geometry")
        features.append(feature_of(shapely.from_wkb(wkb), name, layer or layers[0], {"fid": number} | properties))
    if not features:
        raise CaseError("there are no features in it")
    degrees = meta["crs"] is not None and str(meta["crs"]).upper() in ("EPSG:4326", "OGC:CRS84", "EPSG:4269")
    notes = (
        ("coordinates are degrees and taken as they are: project them to a plane for a true shape",) if degrees else ()
    )
    return Content(tuple(features), notes)
