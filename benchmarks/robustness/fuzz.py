"""Damaged files of every kind that a case can name, and damaged cases: each is read, or refused by an error of ours.

Rows go to a file as they come; a run that is begun again goes on after the last one.
"""

import json
import random
import re
import struct
import warnings
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import shapely

from benchmarks.robustness.capped import Call
from benchmarks.robustness.trials import Row, completed, counted_outcomes, note, row_options
from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError
from bubblemesh.problem.prepare import prepare

ROOT = Path(__file__).parents[2]
TOKEN = re.compile(rb"[\w.+-]+|\s+|.", re.DOTALL)
NUMBERS = b"nan inf -inf 1e308 -1e308 1e-308 -0 0 -1 1 2147483648 9223372036854775807 1e400 0x1f".split()
WORDS = (
    b"'",
    b'"',
    b"(" * 50,
    b"[" * 50,
    b"{" * 50,
    b"\0",
    b"\xff",
    b"9" * 500,
    b"a" * 5000,
    b"\n" * 50,
    b"-",
    b"<a>",
    b"&a;",
)


class Seed(NamedTuple):
    """A case and the files that it names, of which the first is damaged most; without files the case itself is."""

    case: bytes
    files: dict[str, bytes]


# What files hold.

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
    for number, path in enumerate(sorted((ROOT / "configs").rglob("*.yaml"))):
        text = path.read_bytes()
        if b"file:" not in text and b"base:" not in text and len(text) < 4000:
            found[f"case{number:02}"] = Seed(text, {})
    return found


# How they are damaged.


def _with_bytes_changed(content: bytes, random_: random.Random) -> bytes:
    at = random_.randrange(len(content) + 1)
    return content[:at] + random_.randbytes(random_.choice([1, 1, 2, 4])) + content[at + random_.randint(0, 4) :]


def _cut(content: bytes, random_: random.Random) -> bytes:
    return content[: random_.randrange(len(content) + 1)]


def _with_part_moved(content: bytes, random_: random.Random) -> bytes:
    begin, end, to = sorted(random_.randrange(len(content) + 1) for _ in range(3))
    part = content[begin:end][:2000]
    kept = content if random_.random() < 0.5 else content[:begin] + content[begin + len(part) :]
    return kept[:to] + part * random_.choice([1, 1, 2, 30]) + kept[to:]


def _with_binary_number(content: bytes, random_: random.Random) -> bytes:
    form = random_.choice(["<i", ">i", "<q", "<d", ">d", "<f"])
    whole = form[1] in "iq"
    value = random_.choice(
        [-1, 0, 2**31 - 1, 1000] if whole else [np.nan, np.inf, 1e300 if form[1] == "d" else 1e38, -0.0]
    )
    number = struct.pack(form, value)
    at = random_.randrange(max(len(content) - len(number), 0) + 1)
    return content[:at] + number + content[at + len(number) :]


def _with_tokens_changed(content: bytes, random_: random.Random) -> bytes:
    tokens = TOKEN.findall(content)
    if not tokens:
        return content
    for _ in range(random_.choice([1, 1, 2, 5])):
        k, other = random_.randrange(len(tokens)), random_.randrange(len(tokens))
        match random_.randrange(6):
            case 0:
                tokens[k] = b""
            case 1:
                tokens[k], tokens[other] = tokens[other], tokens[k]
            case 2:
                tokens[k] = tokens[k] * random_.choice([2, 3, 100])
            case 3:
                tokens[k] = random_.choice(WORDS)
            case _:
                numbers = [j for j, token in enumerate(tokens) if token.strip(b"+-.e0123456789") == b"" and token]
                tokens[random_.choice(numbers or [k])] = random_.choice(NUMBERS)
    return b"".join(tokens)


def _nested(content: bytes, random_: random.Random) -> bytes:
    begin, end = sorted(random_.randrange(len(content) + 1) for _ in range(2))
    left, right = random_.choice([(b"[", b"]"), (b"{", b"}"), (b"(", b")"), (b"<g>", b"</g>")])
    times = random_.choice([1, 20, 2000])
    return content[:begin] + left * times + content[begin:end] + right * times + content[end:]


CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    _with_bytes_changed,
    _cut,
    _with_part_moved,
    _with_binary_number,
    _with_tokens_changed,
    _with_tokens_changed,
    _with_tokens_changed,
    _nested,
)


def damaged(seed: Seed, random_: random.Random) -> Seed:
    """A case of which one file is damaged in one way or several; without files, the case itself."""

    def changed(content: bytes) -> bytes:
        for _ in range(random_.choice([1, 1, 1, 2, 4])):
            content = random_.choice(CHANGES)(content, random_)
        return content

    if not seed.files:
        return seed._replace(case=changed(seed.case))
    name = random_.choice([*[next(iter(seed.files))] * 3, *seed.files])
    return seed._replace(files=seed.files | {name: changed(seed.files[name])})


# The trial.


def tasks(each: int) -> Iterator[Row]:
    """So many tasks for each kind, in an order in which any first part is a fair sample."""
    for number in range(each):
        for kind in seeds():
            yield {"name": f"{kind}-{number}", "kind": kind, "number": number}


def read_one(known: dict[str, Seed], task: Row) -> Row:
    """Row of a task, on one of the known seeds: whether the damaged case is read or refused."""
    seed = damaged(known[task["kind"]], random.Random(task["name"]))
    with TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        write(seed, Path(name))
        try:
            prepare(load_case(Path(name, "case.yaml")))
        except BubblemeshError as error:
            return {"outcome": f"refused ({error.exit_code})", "why": str(error)[:300]}
        except MemoryError:
            return {"outcome": "refused (6)", "why": "out of memory"}
    return {"outcome": "read"}


def write(seed: Seed, folder: Path) -> None:
    """Write a case and its files into a folder, to look at what a finding is about."""
    (folder / "case.yaml").write_bytes(seed.case)
    for name, content in seed.files.items():
        (folder / name).write_bytes(content)


def row_of(call: Call) -> Row:
    """Row of a call; a crash, or no end in time, is a finding."""
    row = {**call.task, "seconds": round(call.seconds, 3)}
    if call.crash is None:
        return row | call.value
    lines = call.crash.strip().splitlines()
    return row | {"outcome": "finding", "why": lines[-1], "traceback": call.crash}


def main(arguments: list[str]) -> None:
    """Read what is not read yet, and tell the outcomes and the findings."""
    parser = row_options("fuzz", 20, 4000, __doc__)
    parser.add_argument("--each", type=int, default=200, help="how many of each kind")
    parser.add_argument("--kind", default="", help="what the kinds begin with")
    options = parser.parse_args(arguments)
    wanted = [task for task in tasks(options.each) if task["kind"].startswith(options.kind)]
    rows = completed(partial(read_one, seeds()), row_of, wanted, options)
    findings = [row for row in rows if row["outcome"] == "finding"]
    print(*counted_outcomes(rows), *(f"{row['name']}: {row['why']}" for row in findings), sep="\n")
    note("fuzz, " + options.kind if options.kind else "fuzz", {"trials": len(rows), "wrong": len(findings)})
