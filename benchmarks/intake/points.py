"""Lists of points: airfoils as their collections have them, graphs of meshers, scanned contours."""

from pathlib import Path
from typing import Any

import numpy as np
import shapely

from benchmarks.intake.shapes import Drawn, Random, drawn, loop


def _section(random: Random, count: int, edge: bool) -> tuple[Any, Any]:
    """Upper and lower surface of a section of four digits, both from the nose; with an open trailing edge or none."""
    x = (1 - np.cos(np.linspace(0, np.pi, count))) / 2
    m, p, t = random.uniform(0, 0.05), random.uniform(0.3, 0.5), random.uniform(0.06, 0.2)
    last = -0.1015 if edge else -0.1036
    half = 5 * t * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 + last * x**4)
    camber = np.where(x < p, m / p**2 * (2 * p * x - x**2), m / (1 - p) ** 2 * (1 - 2 * p + 2 * p * x - x**2))
    return np.column_stack([x, camber + half]), np.column_stack([x, camber - half])


def _rows(points: Any, form: str = " {:9.6f} {:9.6f}") -> str:
    return "".join(form.format(x, y) + "\n" for x, y in points)


def airfoil(folder: Path, number: int, random: Random) -> Drawn:
    """A section in one of the forms: Selig's, Lednicer's, XFOIL's, MSES' with several elements; with slips."""
    path = folder / f"airfoil-{number:02}{'.txt' if number % 7 == 6 else '.dat'}"
    form = number % 8
    upper, lower = (np.round(side, 6) for side in _section(random, int(random.integers(17, 60)), form in (1, 3, 5)))
    ring = np.concatenate([upper[::-1], lower[1:]])
    name = f"NACA {number:04} (drawn)"
    elements = [ring]
    if form in (0, 1):
        text = f"{name}\n{_rows(ring)}"
    elif form == 2:
        head = f"{name}\n {len(upper):7.1f} {len(lower):7.1f}\n\n"
        text = head + _rows(upper) + "\n" + _rows(lower)
    elif form == 3:  # Lednicer's without the numbers of points, tabs
        upper, lower = (np.round(side, 5) for side in (upper, lower))
        text = f"{name}\n" + _rows(upper, "{:.5f}\t{:.5f}") + "\n" + _rows(lower, "{:.5f}\t{:.5f}")
        elements = [np.concatenate([upper[::-1], lower[1:]])]
    elif form == 4:  # MSES, with a flap
        flap = 0.3 * ring @ np.array([[0.9, -0.4], [0.4, 0.9]]) + [1.02, -0.03]
        elements = [ring, np.round(flap, 6)]
        text = f"{name}\n-1.5 2.5 -2.0 2.0\n" + "  999.0  999.0\n".join(map(_rows, elements))
    elif form == 5:  # points twice, carriage returns, and words at the end
        text = name + "\r\n" + _rows(np.repeat(ring, 1 + (np.arange(len(ring)) % 9 == 4), axis=0)).replace("\n", "\r\n")
        text += "\r\nSource: wind tunnel report 12, digitized\r\n"
    elif form == 6:  # only numbers, in percent, clockwise
        elements = [100 * ring[::-1]]
        text = _rows(elements[0], "{:.4f} {:.4f}")
    else:  # comments
        text = f"# {name}\n# x/c y/c\n" + _rows(ring, "{:.6e}  {:.6e}")
    path.write_bytes(text.encode())
    shapes = [shapely.Polygon(one) for one in elements]
    if form == 4 and shapes[0].intersects(shapes[1]):
        return Drawn(path, 1.3)
    return drawn(path, shapes)


def graph(folder: Path, number: int, random: Random) -> Drawn:
    """A planar graph for a mesher: rings, holes, inner segments, regions, counted from 0 or 1."""
    path = folder / f"graph-{number:02}.poly"
    base = number % 2
    rings = [loop(random, int(random.integers(8, 60)), 0.3)]
    if number % 3:
        rings += [0.2 * loop(random, 9, 0.1) + [-0.3, 0], np.array([(0.2, -0.1), (0.4, -0.1), (0.4, 0.1), (0.2, 0.1)])]
    points = np.round(np.concatenate(rings), 8)
    segments, begin = [], 0
    for k, ring in enumerate(rings):
        n = len(ring)
        segments += [(begin + j, begin + (j + 1) % n, k + 1) for j in range(n)]
        begin += n
    inner = number % 4 >= 2
    if inner:  # a wall inside, from the rim to a free end
        points = np.vstack([points, [0.05, 0.45], [-0.05, -0.45]])
        segments += [(begin, begin + 1, 9)]
    holes = [(-0.3, 0.0), (0.3, 0.0)] if len(rings) > 1 else []
    node = f"{len(points)} 2 1 1\n" + "".join(
        f"{k + base:4d} {x:.8f} {y:.8f} {0.5:g} {int(k < len(rings[0]))}\n" for k, (x, y) in enumerate(points)
    )
    body = f"{len(segments)} 1\n" + "".join(
        f"  {k + base} {a + base} {b + base} {mark}\n" for k, (a, b, mark) in enumerate(segments)
    )
    body += f"# holes\n{len(holes)}\n" + "".join(f"{k + base} {x} {y}\n" for k, (x, y) in enumerate(holes))
    if number % 5 == 0:
        body += f"1\n{base} 0.0 0.6 7 0.1   # a region\n"
    if number % 4 == 3:
        path.with_suffix(".node").write_text(node)
        node = "0 2 1 1\n"
    path.write_text(f"# drawn for a mesher\n{node}{body}")
    return drawn(path, [shapely.Polygon(np.round(rings[0], 8), [np.round(ring, 8) for ring in rings[1:]])])


def scan(folder: Path, number: int, random: Random) -> Drawn:
    """A contour that was scanned or traced: noisy, nearly closed, points twice, as tables have it."""
    path = folder / f"scan-{number:02}.csv"
    count = int(random.choice([60, 200, 600]))
    points = loop(random, count, 0.2) * random.choice([0.01, 1, 180]) + random.uniform(-5, 5, 2)
    size = float(np.ptp(points, axis=0).max())
    form = number % 8
    step = 3 * size / count
    if form != 4:
        points = points + random.normal(0, (0.02, 0.1, 0.45)[number // 8 % 3] * step, points.shape)
    if form == 1:  # the end misses the start
        points = np.vstack([points, points[0] + random.normal(0, 0.05 * step, 2)])
    elif form == 2:
        points = np.repeat(points, 1 + (np.arange(count) % 7 == 3), axis=0)
    elif form == 3:  # on a raster of pixels
        points = np.round(points / step) * step
    elif form == 5:  # closed
        points = np.vstack([points, points[0]])
    separator, decimal = (";", ",") if form == 6 else (",", ".")
    rows = [f"{x:.7g}{separator}{y:.7g}".replace(".", decimal) for x, y in points]
    rows = [f"{k},{row}" for k, row in enumerate(rows)] if form == 7 else rows
    head = {2: "X (mm),Y (mm)\n", 6: "x;y\n", 7: "id,x,y\n"}.get(form, "")
    path.write_text(head + "\n".join(rows) + "\n")
    shape = shapely.Polygon([tuple(map(float, (f"{x:.7g}", f"{y:.7g}"))) for x, y in points])
    return drawn(path, [shape]) if shape.is_valid else Drawn(path, size)
