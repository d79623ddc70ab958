"""Outlines as graphic programs write them: glyphs, icons, logos."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from shapely.affinity import scale

from benchmarks.intake.shapes import CURVED, Drawn, Random, Shape, drawn, loop

LETTERS = "ABDEGMOPQRSabdegiknoqstz0468&@%$§äßéøñЖЯωΩ∞≠★♞"
COMMANDS = {1: "M", 2: "L", 3: "Q", 4: "C", 79: "Z"}  # of Matplotlib's codes
WIDTHS = {3: 2, 4: 3}  # vertices of a curve
HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
SVG = 'xmlns="http://www.w3.org/2000/svg"'


@lru_cache(maxsize=1)
def _fonts() -> list[Path]:
    import matplotlib

    fonts = sorted(Path(matplotlib.get_data_path(), "fonts", "ttf").glob("*.ttf"))
    return [font for font in fonts if font.stem.startswith(("DejaVu", "STIXGeneral"))]


def _text_path(random: Random, text: str) -> Any:
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    font = _fonts()[int(random.integers(len(_fonts())))]
    return TextPath((0, 0), text, size=100, prop=FontProperties(fname=str(font)))


def _d_of(path: Any) -> str:
    """The path as data of SVG, y down."""
    words, k = [], 0
    while k < len(path.codes):
        code = int(path.codes[k])
        width = WIDTHS.get(code, 1)
        points = " ".join(f"{x:.4g} {-y:.4g}" for x, y in path.vertices[k : k + width])
        words.append(COMMANDS[code] + ("" if code == 79 else points))
        k += width
    return "".join(words)


def _filled(rings: Sequence[Any]) -> Shape:
    """What rings enclose, by parity."""
    area: Shape = shapely.Polygon()
    for ring in rings:
        area = area.symmetric_difference(shapely.Polygon(ring)) if len(ring) > 3 else area
    return area


def glyph(folder: Path, number: int, random: Random) -> Drawn:
    """A letter as a path of SVG or as a list of contours."""
    path = _text_path(random, LETTERS[number % len(LETTERS)])
    rings = path.to_polygons()
    valid = all(shapely.Polygon(ring).is_valid for ring in rings if len(ring) > 3)
    if number % 3 == 2:
        file = folder / f"glyph-{number:02}.csv"
        head = "x,y\n" if number % 2 else "# contours of a glyph\n"
        file.write_text(head + "\n".join("".join(f"{x:.6f},{y:.6f}\n" for x, y in ring) for ring in rings))
        rings = [np.round(ring, 6) for ring in rings]
        found = drawn(file, [_filled(rings)] if valid else [shapely.Polygon(rings[0])])
    else:
        file = folder / f"glyph-{number:02}.svg"
        file.write_text(f'<svg {SVG} viewBox="0 -100 100 130"><path d="{_d_of(path)}"/></svg>')
        found = drawn(file, [_filled(rings) if valid else shapely.Polygon(rings[0]).buffer(0)], CURVED)
    return found if valid else found._replace(areas=None)


class Part(NamedTuple):
    """Data of a closed subpath, and the area in it."""

    d: str
    area: Shape


def _disc(x: float, y: float, r: float, sweep: int = 1) -> Part:
    d = f"M{x - r:g} {y:g}a{r:g} {r:g} 0 1 {sweep} {2 * r:g} 0a{r:g} {r:g} 0 1 {sweep} {-2 * r:g} 0z"
    return Part(d, shapely.Point(x, y).buffer(r, 64))


def _box(x: float, y: float, w: float, h: float, r: float) -> Part:
    d = (
        f"M{x + r:g} {y:g}h{w - 2 * r:g}a{r:g} {r:g} 0 0 1 {r:g} {r:g}v{h - 2 * r:g}a{r:g} {r:g} 0 0 1 {-r:g} {r:g}"
        f"h{2 * r - w:g}a{r:g} {r:g} 0 0 1 {-r:g} {-r:g}v{2 * r - h:g}a{r:g} {r:g} 0 0 1 {r:g} {-r:g}z"
    )
    return Part(d, shapely.box(x + r, y + r, x + w - r, y + h - r).buffer(r, 64))


def _polygon(points: Any, closed: bool = True) -> Part:
    d = "M" + "L".join(f"{x:.4g} {y:.4g}" for x, y in points) + ("z" if closed else "")
    return Part(d, shapely.Polygon(points))


def _star(random: Random) -> Part:
    count = int(random.integers(5, 9))
    angle = np.arange(2 * count) * np.pi / count
    radius = np.where(np.arange(2 * count) % 2, random.uniform(4, 7), 10)
    return _polygon(np.column_stack([12 + radius * np.cos(angle), 12 + radius * np.sin(angle)]))


def _body(random: Random) -> Part:
    match random.integers(4):
        case 0:
            return _disc(12, 12, 10)
        case 1:
            return _box(3, 4, 18, 16, float(random.choice([1, 2, 3])))
        case 2:
            return _star(random)
        case _:
            return _polygon([(2, 10), (12, 2), (22, 10), (22, 21), (2, 21)])


def icon(folder: Path, number: int, random: Random) -> Drawn:
    """An icon of 24 by 24: filled by either rule, stroked, of symbols, with classes, transforms, units."""
    path = folder / f"icon-{number:02}.svg"
    body, hole, dot = _body(random), _disc(12, 12, random.uniform(1, 3), 0), _disc(12, 21.6, 0.4)
    area, box = body.area.difference(hole.area), 'viewBox="0 0 24 24"'
    form = FORMS[number % len(FORMS)]
    text, areas = form(box, body, hole, dot, area)
    path.write_text(text)
    if areas is None:
        return Drawn(path, 20.0, holds_area=False)
    return drawn(path, areas, CURVED)


def _even_odd(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    d = body.d + _disc(12, 12, 2).d
    rule = 'fill-rule="evenodd" clip-rule="evenodd"'
    shape = body.area.difference(shapely.Point(12, 12).buffer(2, 64))
    return f'<svg {SVG} {box} fill="currentColor"><path {rule} d="{d}"/></svg>', [shape]


def _non_zero(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    d = body.d + hole.d
    back = f'<path d="M0 0h24v24H0z" fill="none"/><path d="{d}"/>'
    return f'<svg {SVG} height="24" {box} width="24">{back}</svg>', [area]


def _stroked(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    pen = 'fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round" stroke-linejoin="round"'
    lines = '<line x1="12" y1="8" x2="12" y2="13"/><polyline points="9 12 12 15 15 12"/>'
    return f'<svg {SVG} width="24" height="24" {box} {pen}><path d="{body.d}"/>{lines}</svg>', [body.area]


def _lines_only(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    pen = 'fill="none" stroke="#000" stroke-width="1.5"'
    return f'<svg {SVG} {box}><path {pen} d="M5 12h14M12 5l7 7-7 7"/></svg>', None


def _open_filled(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    d = _polygon([(3, 3), (21, 3), (21, 14), (12, 21), (3, 14)], closed=False)
    return f'<svg {SVG} {box}><path d="{d.d}"/></svg>', [d.area]


def _symbol(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    symbol = f'<symbol id="i" {box}><path fill-rule="evenodd" d="{body.d}{hole.d}"/></symbol>'
    link = 'xmlns:xlink="http://www.w3.org/1999/xlink"'
    return f'{HEAD}<svg {SVG} {link} width="24" height="24">{symbol}<use xlink:href="#i"/></svg>', [area]


def _turned(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    group = f'<g transform="translate(12 12) rotate(30) scale(.5)"><path d="{body.d}{hole.d}"/></g>'
    return f"<svg {SVG} {box}>{group}</svg>", [scale(area, 0.5, 0.5)]


def _in_millimetres(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    style = "<style>.st0{fill:#231F20}.st1{fill:none;stroke:#000}</style>"
    text = f'<path class="st1" d="M1 1h2"/><path class="st0" d="{body.d}{hole.d}"/>'
    return f'{HEAD}<svg id="Layer_1" {SVG} width="24mm" height="24mm" {box}>{style}{text}</svg>', [area]


def _two_parts(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    up = _box(4, 2, 16, 14, 2)
    return f'<svg {SVG} {box}><path d="{up.d}{_disc(12, 20, 2).d}"/></svg>', [up.area, _disc(12, 20, 2).area]


def _clipped(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    clip = '<defs><clipPath id="c"><rect width="24" height="24" fill="white"/></clipPath></defs>'
    return f'<svg {SVG} {box} fill="none"><g clip-path="url(#c)"><path d="{body.d}" fill="black"/></g>{clip}</svg>', [
        body.area
    ]


def _overlapping(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    one, other = _box(2, 8, 20, 8, 1), _box(8, 2, 8, 20, 1)
    return f'<svg {SVG} {box}><path d="{one.d}{other.d}"/></svg>', [one.area.union(other.area)]


def _shapes(box: str, body: Part, hole: Part, dot: Part, area: Shape) -> tuple[str, Any]:
    text = '<rect x="2" y="4" width="20" height="16" rx="2"/><circle cx="12" cy="12" r="4" fill="#fff"/>'
    return f"<svg {SVG} {box}><title>camera</title>{text}</svg>", [
        _box(2, 4, 20, 16, 2).area.difference(shapely.Point(12, 12).buffer(4, 64))
    ]


FORMS = (
    _even_odd,
    _non_zero,
    _stroked,
    _open_filled,
    _symbol,
    _turned,
    _in_millimetres,
    _two_parts,
    _clipped,
    _overlapping,
    _shapes,
    _lines_only,
)


def _smooth(points: Any) -> str:
    """A closed chain of cubic curves through points."""
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    tangent = (after - before) / 6
    words = [f"M{points[0, 0]:.3f},{points[0, 1]:.3f}"]
    for k in range(len(points)):
        j = (k + 1) % len(points)
        control = (points[k] + tangent[k], points[j] - tangent[j], points[j])
        words.append("C" + " ".join(f"{x:.3f},{y:.3f}" for x, y in control))
    return "".join(words) + "Z"


def _blobs(random: Random) -> Iterator[tuple[str, Any]]:
    """A body, its counter, and a spot beside it: data and points."""
    for size, x in ((80, 100), (40, 100), (20, 230)):
        points = size * loop(random, 16, 0.15, 3) + [x, 100]
        yield _smooth(points), points


def logo(folder: Path, number: int, random: Random) -> Drawn:
    """A logo: a compound path of smooth curves, or a word of letters, in groups with transforms."""
    path = folder / f"logo-{number:02}.svg"
    if number % 2:
        word = _text_path(random, ["Boa", "hex.", "QUAD", "ring8", "mesh"][number // 2 % 5])
        d, rings = _d_of(word), word.to_polygons()
        group = f'<g id="g10" transform="matrix(1.25 0 0 1.25 0 125)"><path id="path12" d="{d}"/></g>'
        path.write_text(f'{HEAD}<svg {SVG} width="400" height="200" version="1.1">{group}</svg>')
        return drawn(path, [scale(_filled(rings), 1.25, 1.25)], CURVED)
    (body, outer), (inner, counter), (spot, dot) = _blobs(random)
    letters = "".join([body, inner, spot])
    path.write_text(
        f'{HEAD}<svg {SVG} viewBox="0 0 300 200"><path fill="#e33" style="fill-rule:evenodd" d="{letters}"/></svg>'
    )
    return drawn(path, [_filled([outer, counter]), shapely.Polygon(dot)], CURVED)
