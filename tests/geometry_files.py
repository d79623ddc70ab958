"""Files of geometry for the tests."""

import json

from bubblemesh.geometry.domain import Domain
from bubblemesh.readers.formats import read_areas, read_shapes
from bubblemesh.readers.selection import Selection

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]


HOLE = [[1, 1], [2, 1], [2, 2], [1, 2], [1, 1]]


PLATE = {"type": "Polygon", "coordinates": [SQUARE, HOLE]}


WKT = "POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0), (1 1, 2 1, 2 2, 1 2, 1 1))"


SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="80mm" viewBox="0 0 40 40">{}</svg>'


def collection(*shapes, names=("plate", "far", "third")):
    features = [
        {"type": "Feature", "properties": {"name": name, "number": k}, "geometry": shape}
        for k, (shape, name) in enumerate(zip(shapes, names, strict=False))
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


def domain(path, **options):
    return Domain.of_areas(read_areas(path, Selection(**options)))


def area(path, **options):
    return domain(path, **options).polygon.area


def read_rings(path, selection):
    """Outer rings of all areas of a file."""
    return [area.outer for area in read_shapes(path, selection)]


def labels_of(path, **options):
    """Labels of the outer ring and of the holes."""
    return [
        sorted({str(side.label) for side in ring.sides})
        for area in read_areas(path, Selection(**options))
        for ring in area.rings
    ]
