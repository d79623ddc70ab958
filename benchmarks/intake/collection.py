"""The collection: kinds of files, how many of each, and how each is drawn."""

import json
import random as plain
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.intake import drawings, faulty, maps, outlines, points
from benchmarks.intake.shapes import Drawn, Random

LIST = "collection.json"


class Kind(NamedTuple):
    """Files of one kind."""

    draw: Callable[[Path, int, Random], Drawn]  # into a folder, by number
    count: int
    about: str


KINDS = {
    "country": Kind(maps.country, 36, "countries with islands, lakes and the lakes' islands: GeoJSON"),
    "lake": Kind(maps.lake, 24, "lakes with islands: WKT, GeoJSON"),
    "states": Kind(maps.states, 24, "states and parcels that share borders: GeoJSON"),
    "counties": Kind(maps.counties, 24, "counties: shapefile, GeoPackage"),
    "block": Kind(maps.block, 30, "buildings and blocks of cities, in metres of UTM: WKT, GeoJSON"),
    "glyph": Kind(outlines.glyph, 45, "letters of fonts: SVG, CSV"),
    "icon": Kind(outlines.icon, 48, "icons, filled or stroked: SVG"),
    "logo": Kind(outlines.logo, 20, "logos of compound paths: SVG"),
    "drawing": Kind(drawings.drawing, 42, "drawings of parts: DXF"),
    "airfoil": Kind(points.airfoil, 32, "airfoils: Selig, Lednicer, XFOIL, MSES"),
    "graph": Kind(points.graph, 24, "planar graphs: .poly, .node"),
    "scan": Kind(points.scan, 24, "scanned contours: CSV"),
    "faulty": Kind(faulty.faulty, 28, "polygons with faults: GeoJSON, WKT"),
    "lines": Kind(faulty.lines, 8, "lines that meet, or nearly: GeoJSON"),
}


def draw_all(folder: Path, seed: int = 0) -> list[dict[str, Any]]:
    """Rows of all files, drawn into a folder unless it has them; any first part of them is a fair sample."""
    listed = folder / LIST
    if not listed.exists():
        folder.mkdir(parents=True, exist_ok=True)
        listed.write_text(json.dumps(_drawn(folder, seed), indent=0))
    return list(json.loads(listed.read_text()))


def _drawn(folder: Path, seed: int) -> list[dict[str, Any]]:
    rows = []
    for number, (name, kind) in enumerate(KINDS.items()):
        for k in range(kind.count):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of writers, on what is drawn on purpose
                found = kind.draw(folder, k, np.random.default_rng([seed, number, k]))
            row = {"name": found.path.name, "kind": name, "size": found.size, "areas": found.areas}
            rows.append(row | {"tolerance": found.tolerance, "holds_area": found.holds_area})
    plain.Random(seed).shuffle(rows)
    return rows
