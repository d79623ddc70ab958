"""Shapes with walls that get layers, drawn here, as case files that both tools take."""

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats

Keys = dict[str, Any]
SMOOTH = {"corners": 30, "smooth": True, "tolerance": 1e-3}
FAR = 10.0  # radius of the far field in chords


def shapes() -> dict[str, Keys]:
    """Cases by their names."""
    drawn = {
        "airfoil, blunt edge": around([smooth_ring(naca("0012"), "wing")], first=1e-5, count=36, size=0.01),
        "airfoil, sharp edge": around([smooth_ring(naca("2412", sharp=True), "wing")], first=1e-5, count=36, size=0.01),
        "three-element airfoil": around(
            [smooth_ring(points, "wing") for points in three_elements()], first=5e-5, count=26, size=0.01
        ),
        "backward step": _step(),
        "pipes, narrow gaps": _pipes(0.08),
        "pipes that nearly touch": _pipes(0.002),
        "coast of 2,000 edges": _coast(2000),
        "gear": _gear(),
        "comb": _comb(),
        "walls that touch": _touching(),
        "straight crack": _crack([[0.5, 0.5], [1.5, 0.5]]),
        "crack with a kink": _crack([[0.5, 0.5], [1.2, 0.5], [1.5, 0.6]]),
        "interface": _interface(),
        "periodic sides": _periodic(),
    }
    return {name: {"name": name} | keys for name, keys in drawn.items()}


def bare(keys: Keys) -> Keys:
    """A case without its layers."""
    return {name: value for name, value in keys.items() if name != "layers"}


def thickness(keys: Mapping[str, Any]) -> float:
    """Height of all layers of a case."""
    (entry,) = keys["layers"]
    return entry["first"] * float(np.sum(entry["growth"] ** np.arange(entry["count"])))


def naca(digits: str, points: int = 80, sharp: bool = False) -> Floats:
    """Points (n, 2) of a profile of four digits, from the trailing edge over the upper side and back below.

    Its trailing edge is that of the definition, 0.25 % of the chord thick at 12 %, or ``sharp``. Source: E. N. Jacobs,
    K. E. Ward, R. M. Pinkerton, NACA Report 460, 1933.
    """
    camber, place, thick = int(digits[0]) / 100, int(digits[1]) / 10, int(digits[2:]) / 100
    x = (1 - np.cos(np.linspace(0, np.pi, points + 1))) / 2
    last = 0.1036 if sharp else 0.1015
    half = 5 * thick * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - last * x**4)
    mean, slope = np.zeros_like(x), np.zeros_like(x)
    if camber:
        scale = np.where(x < place, camber / place**2, camber / (1 - place) ** 2)
        mean = scale * (np.where(x < place, 0, 1 - 2 * place) + 2 * place * x - x**2)
        slope = 2 * scale * (place - x)
    normal = np.column_stack([-slope, np.ones_like(x)]) / np.hypot(1, slope)[:, None]
    line = np.column_stack([x, mean])
    upper, lower = line + half[:, None] * normal, line - half[:, None] * normal
    return np.concatenate([upper[::-1], lower[1 : -1 if sharp else None]])


def three_elements() -> list[Floats]:
    """Slat, main part and flap, whose gaps are narrower than twice the thickness of their layers."""
    return [
        _placed(naca("4412", 50), 0.18, 28, (-0.148, -0.05)),
        naca("4412"),
        _placed(naca("4412", 50), 0.3, -30, (1.0, -0.015)),
    ]


def around(bodies: Sequence[Keys], first: float, count: int, size: float) -> Keys:
    """Bodies in a far field, with layers on all of them."""
    return {
        "domain": {"outer": {"circle": {"center": [0.5, 0], "radius": FAR}, "label": "far"}, "holes": list(bodies)},
        "spacing": {"near": [{"label": "wing", "size": size, "growth": 0.2}]},
        "layers": [_entry("wing", first, count)],
    }


def _entry(label: str, first: float, count: int, growth: float = 1.2) -> Keys:
    return {"on": label, "first": first, "growth": growth, "count": count}


def smooth_ring(points: Floats, label: str) -> Keys:
    """A ring that follows points smoothly, but at its corners."""
    return {"polygon": points.tolist(), "label": label, **SMOOTH}


def _polygon(points: Any, label: str) -> Keys:
    return {"polygon": np.asarray(points, float).tolist(), "label": label}


def _placed(points: Floats, scale: float, degrees: float, at: tuple[float, float]) -> Floats:
    turn = np.radians(degrees)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return scale * points @ rotation + at


def _step() -> Keys:
    corners = [[0, 1], [4, 1], [4, 0], [12, 0], [12, 2], [0, 2]]
    outer = {"polygon": corners, "labels": ["wall", "wall", "wall", "outlet", "wall", "inlet"]}
    return {"domain": {"outer": outer}, "spacing": 0.1, "layers": [_entry("wall", 0.002, 15)]}


def _pipes(gap: float) -> Keys:
    pitch = 1 + gap
    centers = [[i * pitch + (j % 2) * pitch / 2, j * pitch * sqrt(3) / 2] for j in range(3) for i in range(3)]
    holes = [{"circle": {"center": center, "radius": 0.5}, "label": "pipe"} for center in centers]
    outer = _polygon([[-1.5, -1.5], [4, -1.5], [4, 3.5], [-1.5, 3.5]], "shell")
    return {
        "domain": {"outer": outer, "holes": holes},
        "spacing": {"near": [{"label": "pipe", "size": 0.05}], "maximum": 0.15},
        "layers": [_entry("pipe", 0.002, 12)],
    }


def _coast(edges: int) -> Keys:
    walk = np.cumsum(np.random.default_rng(0).normal(size=edges))
    walk -= np.linspace(0, walk[-1], edges)
    turn = np.linspace(0, 2 * np.pi, edges, endpoint=False)
    ring = (1 + 0.1 * walk / np.abs(walk).max())[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return {
        "domain": {
            "outer": _polygon([[-3, -3], [3, -3], [3, 3], [-3, 3]], "sea"),
            "holes": [_polygon(ring, "coast")],
        },
        "spacing": {"near": [{"label": "coast", "size": 0.01}], "maximum": 0.2},
        "layers": [_entry("coast", 0.0005, 10)],
    }


def _gear(teeth: int = 20) -> Keys:
    turn = 2 * np.pi * (np.arange(teeth)[:, None] + [0, 0.3, 0.4, 0.9]).ravel() / teeth
    radius = np.tile([1.2, 1.2, 1.0, 1.0], teeth)
    ring = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
    outer = {"circle": {"center": [0, 0], "radius": 2}, "label": "case"}
    return {
        "domain": {"outer": outer, "holes": [_polygon(ring, "gear")]},
        "spacing": {"near": [{"label": "gear", "size": 0.04}], "maximum": 0.15},
        "layers": [_entry("gear", 0.002, 14)],
    }


def _comb(teeth: int = 8) -> Keys:
    rim = [[0.25 * k + x, y] for k in range(teeth) for x, y in ((0.15, 0), (0.15, 1), (0.25, 1), (0.25, 0))]
    top = [[2, 1.5], [0, 1.5]]
    labels = ["comb"] * (4 * teeth - 2) + ["side", "top", "side", "comb"]
    return {
        "domain": {"outer": {"polygon": [[0, 0], *rim[:-2], [2, 1], *top], "labels": labels}},
        "spacing": 0.05,
        "layers": [_entry("comb", 0.002, 14)],
    }


def _touching() -> Keys:
    outer = _polygon([[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]], "wall")
    holes = [_polygon([[1, 0], [1.2, 0.2], [1, 0.4], [0.8, 0.2]], "wall"), _polygon(_round(1, 0.6, 0.2), "wall")]
    return {"domain": {"outer": outer, "holes": holes}, "spacing": 0.05, "layers": [_entry("wall", 0.001, 14)]}


def _round(x: float, y: float, radius: float, corners: int = 36) -> Floats:
    turn = 2 * np.pi * (np.arange(corners) / corners - 0.25)
    return np.round([x, y] + radius * np.column_stack([np.cos(turn), np.sin(turn)]), 6)


def _crack(path: Sequence[Sequence[float]]) -> Keys:
    outer = _polygon([[0, 0], [2, 0], [2, 1], [0, 1]], "rim")
    return {
        "domain": {"outer": outer, "lines": [{"path": path, "label": "crack"}]},
        "spacing": 0.05,
        "layers": [_entry("crack", 0.001, 14)],
    }


def _interface() -> Keys:
    outer = _polygon([[0, 0], [2, 0], [2, 2], [0, 2]], "rim")
    ring = {"circle": {"center": [1, 1], "radius": 0.5}, "label": "skin"}
    return {
        "domain": {"outer": outer, "region": "matrix", "regions": [{"name": "core", "ring": ring}]},
        "spacing": 0.08,
        "layers": [_entry("skin", 0.002, 14)],
    }


def _periodic() -> Keys:
    outer = {"polygon": [[0, 0], [2, 0], [2, 1], [0, 1]], "labels": ["wall", "right", "wall", "left"]}
    hole = {"circle": {"center": [1, 0.5], "radius": 0.2}, "label": "wall"}
    return {
        "domain": {"outer": outer, "holes": [hole], "periodic": [["left", "right"]]},
        "spacing": 0.08,
        "layers": [_entry("wall", 0.002, 14)],
    }
