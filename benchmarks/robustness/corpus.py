"""Domains that break meshers, the same at every call: glyphs of fonts, and random shapes of many families."""

import math
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import shapely

Keys = dict[str, Any]
OFFSET = 1e6
NEAR = 1e-3  # distance of walls, in parts of the spacing


def glyphs(count: int) -> Iterator[tuple[str, Keys]]:
    """Names and domains of the largest parts of so many glyphs, spread evenly over the fonts of Matplotlib."""
    import matplotlib
    from matplotlib.ft2font import FT2Font

    fonts = sorted(Path(matplotlib.get_data_path(), "fonts", "ttf").glob("*.ttf"))
    fonts = [font for font in fonts if not font.stem.startswith("LastResort")]  # a million times the same frames
    known = [(font, code) for font in fonts for code in sorted(FT2Font(str(font)).get_charmap())]
    step = max(len(known) / (1.1 * count), 1)  # some have no outline, such as blanks
    given = 0
    for k in range(int(len(known) / step)):
        font, code = known[int(k * step)]
        area = _glyph(font, code)
        if area is not None and given < count:
            given += 1
            yield f"{font.stem}-{code:04x}", domain_of(area)


def _glyph(font: Path, code: int) -> shapely.Polygon | None:
    from matplotlib.ft2font import FT2Font
    from matplotlib.path import Path as Outline

    face = FT2Font(str(font))
    face.set_size(100, 72)
    face.load_char(code)
    points, codes = face.get_path()
    area = shapely.Polygon()
    for outline in Outline(points, codes).to_polygons() if len(points) else ():
        if len(outline) > 3:
            area = area.symmetric_difference(shapely.Polygon(outline).buffer(0))
    return _largest(shapely.remove_repeated_points(area))


def _largest(area: Any) -> shapely.Polygon | None:
    parts = [part for part in getattr(area, "geoms", [area]) if part.geom_type == "Polygon" and part.area > 1e-6]
    return max(parts, key=lambda part: part.area, default=None)


def domain_of(area: shapely.Polygon) -> Keys:
    """A polygon as the domain of a case."""
    outlines = (area.exterior, *area.interiors)
    rings = [{"polygon": [[float(x), float(y)] for x, y in outline.coords[:-1]]} for outline in outlines]
    return {"outer": rings[0], "holes": rings[1:]}


def random_domains(count: int) -> Iterator[tuple[str, Keys]]:
    """Names and domains of random shapes, of each family in turn."""
    families = list(FAMILIES.items())
    for number in range(count):
        name, family = families[number % len(families)]
        yield f"{name}-{number:04}", family(random.Random(number))


def _star(random_: random.Random) -> Keys:
    count = random_.randint(3, 40)
    return _ring([(random_.uniform(0.15, 1), 2 * math.pi * k / count) for k in range(count)])


def _gear(random_: random.Random) -> Keys:
    teeth, depth = random_.randint(5, 60), random_.uniform(0.01, 0.3)
    return _ring([(1 - depth * (k % 4 >= 2), math.pi * k / 2 / teeth) for k in range(4 * teeth)])


def _spiral(random_: random.Random) -> Keys:
    turns, width = random_.uniform(1, 3), random_.uniform(0.03, 0.25)
    angles = np.linspace(0, 2 * math.pi * turns, int(24 * turns))
    inner = [(0.3 + 0.06 * a, a) for a in angles]
    return _ring([*inner, *((r + width, a) for r, a in reversed(inner))])


def _ring(polar: list[tuple[float, float]]) -> Keys:
    return {"outer": {"polygon": [[r * math.cos(a), r * math.sin(a)] for r, a in polar]}}


def _comb(random_: random.Random) -> Keys:
    teeth, width = random_.randint(1, 12), 10 ** random_.uniform(-7, -1.2)
    slits = [shapely.box(x - width / 2, random_.uniform(0.05, 0.8), x + width / 2, 2) for x in range(1, teeth + 1)]
    return domain_of(shapely.box(0, 0, teeth + 1, 1) - shapely.union_all(slits))


def _boxes_and_discs(random_: random.Random, subtract: bool) -> Keys:
    def shape() -> shapely.Polygon:
        x, y = random_.uniform(0, 4), random_.uniform(0, 4)
        if random_.random() < 0.5:
            return shapely.box(x, y, x + random_.uniform(0.1, 2), y + random_.uniform(0.1, 2))
        return shapely.Point(x, y).buffer(random_.uniform(0.05, 1), quad_segs=random_.randint(2, 12))

    area: Any = shapely.box(0, 0, 4, 4) if subtract else shapely.Polygon()
    for _ in range(random_.randint(2, 12)):
        area = area - shape() if subtract else area | shape()
    return domain_of(_largest(area) or shapely.box(0, 0, 1, 1))


def _union(random_: random.Random) -> Keys:
    return _boxes_and_discs(random_, subtract=False)


def _difference(random_: random.Random) -> Keys:
    return _boxes_and_discs(random_, subtract=True)


def _tiny_holes(random_: random.Random) -> Keys:
    across = random_.choice([2, 3, 4, 6, 8] * 8 + [45])
    radius = 10 ** random_.uniform(-6, -1) / across
    holes = []
    for k in range(across**2):
        middle = [(k % across + random_.uniform(0.3, 0.7)) / across, (k // across + random_.uniform(0.3, 0.7)) / across]
        sides = random_.choice([3, 4, 6])
        turns = [2 * math.pi * j / sides for j in range(sides)]
        holes.append({"polygon": [[middle[0] + radius * math.cos(a), middle[1] + radius * math.sin(a)] for a in turns]})
    return {"outer": {"rectangle": [0, 0, 1, 1]}, "holes": holes}


def _near_walls(random_: random.Random) -> Keys:
    """Boxes in a row that nearly touch each other and the wall: 1/1000 of a spacing of 1/8."""
    gap = NEAR / 8 * random_.uniform(0.5, 2)
    width = 1 / random_.randint(2, 5)
    holes = [
        {"rectangle": [k * width + gap, gap, (k + 1) * width, random_.uniform(0.2, 1 - gap)]}
        for k in range(round(1 / width) - 1)
    ]
    return {"outer": {"rectangle": [0, 0, 1, 1]}, "holes": holes}


def _far_away(random_: random.Random) -> Keys:
    area = shapely.Polygon([(x + OFFSET, y - OFFSET) for x, y in _star(random_)["outer"]["polygon"]])
    return domain_of(area)


def _sliver(random_: random.Random) -> Keys:
    thin = 10 ** random_.uniform(-6, -1)
    corners = [[0, 0], [random_.uniform(0.3, 0.7), thin], [1, 0], [random_.uniform(0.3, 0.7), -thin]]
    return {"outer": {"polygon": corners[: random_.choice([3, 4])]}}


def _curved(random_: random.Random) -> Keys:
    """Discs and ellipses with round holes that nearly touch the rim or each other."""
    radius = random_.uniform(0.5, 1)
    outer = random_.choice(
        [
            {"circle": {"center": [0, 0], "radius": 1}},
            {"ellipse": {"center": [0, 0], "radii": [1.3, 1.0], "angle": random_.uniform(0, 180)}},
        ]
    )
    away = random_.choice([0, 1 - radius - 10 ** random_.uniform(-5, -1)])
    return {"outer": outer, "holes": [{"circle": {"center": [max(away, 0), 0], "radius": radius * 0.999}}]}


FAMILIES: dict[str, Callable[[random.Random], Keys]] = {
    "star": _star,
    "gear": _gear,
    "spiral": _spiral,
    "comb": _comb,
    "union": _union,
    "difference": _difference,
    "tiny-holes": _tiny_holes,
    "near-walls": _near_walls,
    "far-away": _far_away,
    "sliver": _sliver,
    "curved": _curved,
}
