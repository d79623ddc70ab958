"""Undamaged cases and files of every kind that a case can name, to be damaged by the trial of bad input."""

import json
import warnings
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import shapely

from benchmarks.intake.collection import KINDS

ROOT = Path(__file__).parents[2]


class Seed(NamedTuple):
    """A case and the files that it names, of which the first is damaged most; without files the case itself is."""

    case: bytes
    files: dict[str, bytes]


OUTLINE = [(0, 0), (4, 0), (4, 3), (2, 2.5), (0, 3)]
HOLE = [(1, 1), (2, 1), (2, 2), (1, 2)]
NODES = [(0, 0), (4, 0), (4, 4), (0, 4), (2, 2)]
TRIANGLES = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]


def _text_of(ring: list[Any], between: str, after: str) -> str:
    return after.join(between.join(map(str, point)) for point in ring)


def _text_files() -> dict[str, str]:
    rings = [[*ring, ring[0]] for ring in (OUTLINE, HOLE)]
    feature = {
        "type": "Feature",
        "properties": {"label": "rim", "number": 3},
        "geometry": {"type": "Polygon", "coordinates": rings},
    }
    ends = [(k, k % 9 + 1 if k != 5 else 1) for k in range(1, 6)] + [(6, 7), (7, 8), (8, 9), (9, 6)]
    points = "".join(f"{k} {x} {y} 0 1\n" for k, (x, y) in enumerate([*OUTLINE, *HOLE], start=1))
    segments = "".join(f"{k} {a} {b} {k % 3}\n" for k, (a, b) in enumerate(ends, start=1))
    topology = {
        "type": "Topology",
        "transform": {"scale": [0.5, 0.5], "translate": [0, 0]},
        "objects": {"a": {"type": "GeometryCollection", "geometries": [{"type": "Polygon", "arcs": [[0, -2]]}]}},
        "arcs": [[[0, 0], [8, 0], [0, 6]], [[0, 0], [0, 6], [8, 0]]],
    }
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" viewBox="0 0 9 9"><style>.a{fill:red}</style><defs>'
        '<circle id="c" cx="1.5" cy="1.5" r="0.4"/></defs><g transform="translate(1 2) rotate(30)">'
        '<path id="p" class="a" d="M0 0 h6 v4 c1 1 -2 3 -3 2 a3 3 0 0 1 -3 -2 z"/><use href="#c" x="1"/></g></svg>'
    )
    return {
        ".geojson": json.dumps({"type": "FeatureCollection", "features": [feature]}),
        ".wkt": f"SRID=1;POLYGON (({_text_of(rings[0], ' ', ', ')}), ({_text_of(rings[1], ' ', ', ')}))",
        ".csv": "x, y\n" + _text_of(OUTLINE, ", ", "\n") + "\n\n# hole\n" + _text_of(HOLE, "; ", "\n"),
        ".poly": f"9 2 1 1\n{points}9 1\n{segments}1\n1 1.5 1.5\n1\n1 0.5 0.5 7 1\n",
        ".topojson": json.dumps(topology),
        ".geojsonl": json.dumps(feature) + "\n" + json.dumps({"type": "Point", "coordinates": [1, 2]}),
        ".wkb": shapely.to_wkb(shapely.Polygon(OUTLINE, [HOLE]), hex=True),
        ".svg": svg,
    }


def _drawing(folder: Path) -> None:
    import ezdxf

    document = ezdxf.new(units=4)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0, 0), (6, 0, 0.3), (6, 4, 0), (0, 4, 0)], format="xyb", close=True)
    block = document.blocks.new("B")
    block.add_circle((1, 1), 0.3)
    space.add_blockref("B", (0, 0))
    space.add_ellipse((4, 2), (0.5, 0), 0.5)
    space.add_spline([(2, 2), (2.5, 2), (2.5, 2.5), (2, 2)])
    space.add_text("A")
    space.add_point((3, 3))
    space.add_hatch().paths.add_polyline_path([(0, 0), (1, 0), (1, 1)])
    document.saveas(folder / "a.dxf")


def _layers(folder: Path) -> None:
    import pyogrio

    shapes = np.array([shapely.to_wkb(shapely.Polygon(OUTLINE, [HOLE]))], dtype=object)
    for ending, driver in ((".shp", "ESRI Shapefile"), (".gpkg", "GPKG")):
        pyogrio.raw.write(
            folder / f"a{ending}",
            geometry=shapes,
            field_data=[np.array(["rim"], dtype=object)],
            fields=["label"],
            geometry_type="Polygon",
            driver=driver,
            crs="EPSG:3857",
        )


MESHES = (".vtu", ".vtk", ".msh", ".xdmf", ".mesh", ".inp", ".su2", ".med", ".ply", ".xml")
PACKED = ".packed.vtu"


def _meshes(folder: Path) -> None:
    import meshio

    for ending in (*MESHES, PACKED):
        plane = ending in (".su2", ".xml")
        points = [point if plane else (*point, 0.0) for point in NODES]
        mesh = meshio.Mesh(points, [("triangle", TRIANGLES)], point_data={"h": np.linspace(0.5, 1, len(NODES))})
        options: dict[str, Any] = {"compression": "lzma"} if ending == PACKED else {}
        if ending == ".msh":
            options = {"file_format": "gmsh"}
        mesh.write(folder / f"a{ending}", **options)


def _rasters(folder: Path) -> None:
    from PIL import Image

    values = np.linspace(0.5, 1, 20).reshape(4, 5)
    np.save(folder / "a.npy", values)
    np.savez_compressed(folder / "a.npz", d=values, x=np.arange(5.0), y=np.arange(4.0))
    pixels = (values * 255).astype(np.uint8)
    for ending in PICTURES:
        Image.fromarray(pixels).save(folder / f"a{ending}")


PICTURES = (".png", ".jpg", ".tiff", ".gif", ".bmp", ".webp", ".ppm", ".tga", ".jp2", ".pcx", ".sgi")
TABLES = (".csv", ".dat", ".tsv", ".txt", ".xy")
SQUARE = "domain: {outer: {rectangle: [0, 0, 4, 4]}}\nspacing:\n  %s\n"


# Of how many files of each kind of the collection there is a seed: one for each form, as far as forms are read apart.
COLLECTED = {
    **dict.fromkeys(KINDS, 1),
    **{"country": 6, "counties": 6, "icon": 12, "drawing": 14, "airfoil": 8, "graph": 4, "scan": 8, "lines": 3},
    "faulty": 14,
}
WHOLE = "domain: {{file: {0}, part: all}}\nspacing: {1}\n"
REPAIRED = "domain: {{file: {0}, part: all, repair: true, simplify: {2}, smallest: {3}}}\nspacing: {1}\n"
NEIGHBOURS = "domain: {{regions: {{file: {0}, name: NAME, join: {2}}}}}\nspacing: {1}\n"
# Cases of the files of a kind, of which each takes the next one.
WAYS = dict.fromkeys(KINDS, (WHOLE, REPAIRED)) | dict.fromkeys(("states", "counties"), (NEIGHBOURS,))
WAYS |= {"faulty": (REPAIRED,)}


def _collected(folder: Path) -> dict[str, Seed]:
    """Files as users have them: as whole domains with all of their parts, or as neighbours that are regions."""
    found = {}
    for kind, count in COLLECTED.items():
        for number in range(count):
            drawn = KINDS[kind].draw(folder, number, np.random.default_rng(number))
            others = sorted(path for path in folder.glob(f"{drawn.path.stem}.*") if path != drawn.path)
            case = WAYS[kind][number % len(WAYS[kind])]
            case = case.format(drawn.path.name, drawn.size / 5, drawn.size / 1000, (drawn.size / 1000) ** 2)
            files = {path.name: path.read_bytes() for path in (drawn.path, *others)}
            found[f"{kind}-{number}"] = Seed(case.encode(), files)
    return found


@lru_cache(maxsize=1)
def seeds() -> dict[str, Seed]:
    """The undamaged cases and files of each kind."""
    found: dict[str, Seed] = {}
    texts = _text_files()
    texts |= {".json": texts[".geojson"]} | {ending: texts[".csv"] for ending in TABLES}
    with TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        folder = Path(name)
        for ending, text in texts.items():
            (folder / f"a{ending}").write_text(text)
        for make in (_drawing, _layers, _rasters):
            make(folder)

        def add(kind: str, ending: str, case: str, *others: str) -> None:
            files = {f"a{end}": (folder / f"a{end}").read_bytes() for end in (ending, *others)}
            found[kind + ending] = Seed(case.encode(), files)

        for ending in (".csv", ".geojson", ".dxf", ".wkt"):
            inner = f"lines: [{{file: a{ending}, outside: skip}}]"
            inner += f", points: [{{file: a{ending}, outside: skip}}]" if ending == ".dxf" else ""
            add("inner", ending, f"domain: {{outer: {{rectangle: [0, 0, 9, 9]}}, {inner}}}\nspacing: 1\n")
        for ending in (*texts, ".dxf", ".gpkg"):
            add("domain", ending, f"domain: {{file: a{ending}}}\nspacing: 0.5\n")
        add("domain", ".shp", "domain: {file: a.shp}\nspacing: 0.5\n", ".shx", ".dbf", ".prj", ".cpg")
        for ending in PICTURES:
            keys = "bounds: [0, 0, 4, 4], finest: 0.3, coarsest: 1"
            add("image", ending, SQUARE % f"image: {{file: a{ending}, {keys}}}")
        add("raster", ".npy", SQUARE % "raster: {file: a.npy, bounds: [0, 0, 4, 4]}")
        add("raster", ".npz", SQUARE % "raster: {file: a.npz, name: d}")
        (folder / "a.csv").write_text("x, y, d\n" + "".join(f"{x}, {y}, 0.5\n" for x, y in NODES))
        add("scattered", ".csv", SQUARE % "scattered: {file: a.csv}")
        _meshes(folder)
        for ending in (*MESHES, PACKED):
            add(
                "field",
                ending,
                SQUARE % f"field: {{file: a{ending}, name: h}}",
                *([".h5"] if ending == ".xdmf" else []),
            )
        found |= _collected(folder)
    for number, path in enumerate(sorted((ROOT / "configs").rglob("*.yaml"))):
        text = path.read_bytes()
        if b"file:" not in text and b"base:" not in text and len(text) < 4000:
            found[f"case{number:02}"] = Seed(text, {})
    return found
