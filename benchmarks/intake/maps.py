"""Maps: countries, lakes, states and parcels, counties, blocks of cities; mostly as their portals offer them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.affinity import rotate

from benchmarks.intake.shapes import Drawn, Random, Shape, coast, drawn, moved, partition, polygons_of


def feature(geometry: Any, **properties: Any) -> dict[str, Any]:
    """Feature of GeoJSON."""
    shape = None if geometry is None else shapely.geometry.mapping(geometry)
    return {"type": "Feature", "properties": properties, "geometry": shape}


def write_geojson(path: Path, features: list[dict[str, Any]], **members: Any) -> Path:
    """Write a collection of features."""
    path.write_text(json.dumps({"type": "FeatureCollection", **members, "features": features}))
    return path


def _country(random: Random, cells: int, digits: int) -> list[Shape]:
    islands = coast(random, cells, random.uniform(1.5, 2.2), random.uniform(0, 0.5)) or [shapely.box(0, 0, 1, 1)]
    west, south = random.uniform(-150, 140), random.uniform(-50, 60)
    size = random.choice([0.4, 3, 12, 30])
    return [moved(one, size, (west, south), digits) for one in islands]


def country(folder: Path, number: int, random: Random) -> Drawn:
    """A country with its islands, as one feature, or several beside places and rivers."""
    cells = int(random.choice([24, 32, 48, 64, 96]))
    parts = _country(random, cells, int(random.choice([3, 4, 6, 15])))
    whole = shapely.MultiPolygon(parts) if len(parts) > 1 else parts[0]
    path = folder / f"country-{number:02}.geojson"
    name = {"ADMIN": f"Land {number}", "ISO_A3": "XXX", "POP_EST": int(random.integers(1e4, 1e8))}
    features = [feature(whole, **name)]
    form = number % 6
    if form == 1:  # an island each
        features = [feature(part, name=f"Isle {k}", area=part.area) for k, part in enumerate(parts)]
    elif form == 2:  # what else such files hold
        capital = parts[0].representative_point()
        river = shapely.LineString([capital, shapely.Point(parts[0].exterior.coords[0])])
        features += [feature(None, name="unknown"), feature(capital, name="Capital"), feature(river, name="River")]
    elif form == 3:  # a bare geometry
        path.write_text(json.dumps(shapely.geometry.mapping(whole)))
        return drawn(path, parts)
    elif form == 4:  # generalized part by part, as for the web
        parts = [part.simplify(0.004 * parts[0].length / 10) for part in parts]
        features = [feature(shapely.MultiPolygon(parts), **name)]
    elif form == 5:  # a collection beside heights and an old crs member
        crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
        shape = shapely.GeometryCollection([shapely.force_3d(part, 0.0) for part in parts])
        write_geojson(path, [feature(shape, **name)], name="ne_land", crs=crs)
        return drawn(path, parts)
    write_geojson(path, features)
    return drawn(path, parts)


def lake(folder: Path, number: int, random: Random) -> Drawn:
    """A lake with islands, as WKT or GeoJSON, one polygon, sometimes cut out of tiles."""
    parts = _country(random, int(random.choice([24, 40, 64])), 7)
    holed = max(parts, key=lambda part: (len(part.interiors), part.area))
    if number % 4 == 3:  # cut at the tile's edge
        x0, y0, x1, y1 = holed.bounds
        pieces = polygons_of(holed.intersection(shapely.box(x0, y0, (x0 + x1) / 2, y1)))
        holed = max(pieces, key=lambda part: part.area)
    if number % 2:
        path = folder / f"lake-{number:02}.wkt"
        prefix = "SRID=4326;" if number % 3 == 0 else ""
        path.write_text(prefix + shapely.to_wkt(holed, rounding_precision=-1) + "\n")
        return drawn(path, [holed])
    path = folder / f"lake-{number:02}.geojson"
    write_geojson(path, [feature(holed, natural="water", name=None, **{"@id": f"relation/{number}"})])
    return drawn(path, [holed])


def _neighbours(random: Random, count: int) -> list[Shape]:
    outline = shapely.box(0, 0, 1, random.uniform(0.4, 1))
    if random.random() < 0.6:
        outline = shapely.Polygon(max(coast(random, 32, 2), key=lambda one: one.area, default=outline).exterior)
    return partition(random, outline, count, int(random.integers(0, 4)))


def states(folder: Path, number: int, random: Random) -> Drawn:
    """States or parcels that share borders: exactly, but for rounding, with slivers, or each generalized by itself."""
    parts = _neighbours(random, int(random.integers(3, 14)))
    form = number % 4
    if form == 0:
        parts = [moved(part, (8, 6), (5, 44)) for part in parts]
    elif form == 1:
        parts = [moved(part, (8, 6), (5, 44), 3) for part in parts]
    elif form == 2:
        parts = [moved(part, 400, (512300 + random.normal(0, 0.02), 5402100), 3) for part in parts]
    else:
        parts = [moved(part, (8, 6), (5, 44)).simplify(0.05) for part in parts]
    path = folder / f"states-{number:02}.geojson"
    features = [feature(part, NAME=f"S{k}", GEOID=f"{k:02}") for k, part in enumerate(parts)]
    return _cover(write_geojson(path, features), parts)


def counties(folder: Path, number: int, random: Random) -> Drawn:
    """Counties as a shapefile or a GeoPackage, one layer with attributes; sometimes one county alone."""
    import pyogrio

    parts = [moved(part, 80_000, (480_000, 5_200_000), 2) for part in _neighbours(random, int(random.integers(3, 12)))]
    form = number % 4
    shapes = parts = parts if form < 2 else parts[:1]
    if form == 3:  # islands, and a county without a shape
        away = moved(parts[0], 0.3, (1.2 * parts[0].bounds[2], 0.7 * parts[0].bounds[1]))
        shapes, parts = [shapely.MultiPolygon([parts[0], away]), None], [parts[0], away]
    ending, driver = ((".shp", "ESRI Shapefile"), (".gpkg", "GPKG"))[number // 4 % 2]
    path = folder / f"counties-{number:02}{ending}"
    pyogrio.raw.write(
        path,
        geometry=np.array([None if one is None else shapely.to_wkb(one) for one in shapes], dtype=object),
        field_data=[np.array([f"County {k}" for k in range(len(shapes))], dtype=object), np.arange(len(shapes))],
        fields=["NAME", "CODE"],
        geometry_type="MultiPolygon" if form == 3 and driver == "GPKG" else "Polygon",
        driver=driver,
        crs="EPSG:32632",
        **({"promote_to_multi": True} if form == 3 and driver == "GPKG" else {}),
    )
    return _cover(path, parts)


def _cover(path: Path, parts: list[Shape]) -> Drawn:
    """Neighbours: their areas count also where they share borders exactly."""
    known = drawn(path, parts)
    if all(part.is_valid for part in parts) and shapely.coverage_is_valid(np.array(parts, dtype=object)):
        return known._replace(areas=tuple(sorted((part.area for part in parts), reverse=True)))
    return known


def block(folder: Path, number: int, random: Random) -> Drawn:
    """Buildings of a block of a city, with courts and walls in common, or the block itself; metres in UTM."""
    buildings = []
    for k in range(int(random.integers(1, 9)) if number % 3 else 1):
        a, b = random.uniform(8, 30, 2)
        shape = shapely.box(0, 0, a, b)
        match random.integers(4):
            case 0:
                shape = shape.difference(shapely.box(a / 2, b / 2, a + 1, b + 1))
            case 1:
                shape = shape.difference(shapely.box(a / 3, b / 3, 2 * a / 3, 2 * b / 3))
            case 2:
                shape = shape.difference(shapely.box(a / 3, b / 2, 2 * a / 3, b + 1))
            case 3:
                shape = shape.union(shapely.box(a / 4, -random.uniform(0.2, 2), a / 2, 1))
        buildings.append(moved(shape, 1, (k % 3 * 34, k // 3 * 34)))
    if number % 5 == 4:  # the street around: a block with its buildings as holes
        buildings = [shapely.box(-15, -15, 125, 125).difference(shapely.union_all(buildings))]
    angle = random.uniform(0, 90)
    place = (random.uniform(3e5, 7e5), random.uniform(5e6, 6e6))
    parts = [moved(rotate(one, angle, origin=(0, 0)), 1, place, 3) for one in buildings]
    parts = [part for one in parts for part in polygons_of(one)]
    if number % 2:
        path = folder / f"block-{number:02}.wkt"
        rows = [shapely.to_wkt(part, rounding_precision=3) for part in parts]
        path.write_text("\n".join(rows) if number % 4 == 1 else shapely.to_wkt(shapely.MultiPolygon(parts)))
        if number % 4 == 3:  # which writes six digits
            parts = polygons_of(shapely.from_wkt(path.read_text()))
        return drawn(path, parts)
    path = folder / f"block-{number:02}.geojson"
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    tags = [{"building": "yes", "height": f"{random.uniform(3, 30):.1f}"} for _ in parts]
    write_geojson(path, [feature(part, **tag) for part, tag in zip(parts, tags, strict=True)], crs=crs)
    return drawn(path, parts)
