"""Gmsh's field BoundaryLayer on the same shapes: its own geometry, one thread."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.layers.made import Made
from benchmarks.layers.shapes import SMOOTH, Keys, thickness
from benchmarks.peers.clock import Clock
from benchmarks.peers.gmsh_settings import FRONTAL, OPTIONS, TRIANGLE
from bubblemesh.arrays import Floats, Integers

LINE = 1  # Gmsh's number of the element
REFLEX = 220  # degrees, in the domain, of corners that get a fan
SAMPLES = 200  # of a curve, for distances
COARSEST = 0.2  # growth of a spacing that has a size near a label and no other


def mesh(keys: Keys, clock: Clock, fans: bool) -> Made:
    """The mesh of a case, with a fan at each sharp convex corner of the walls or without."""
    import gmsh

    if not gmsh.isInitialized():
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.clear()
    for option, value in (OPTIONS | {"Mesh.Algorithm": FRONTAL}).items():
        gmsh.option.setNumber(option, value)
    drawn = Drawing(gmsh.model)
    drawn.draw(keys["domain"])
    _spaced(gmsh.model.mesh.field, drawn, keys["spacing"])
    for entry in keys.get("layers", ()):
        _layers(gmsh.model.mesh.field, drawn, entry, keys, fans)
    with clock:
        gmsh.model.mesh.generate(2)
    return _made(gmsh.model.mesh, drawn, [entry["on"] for entry in keys.get("layers", ())])


class Drawing:
    """The domain of a case in Gmsh.

    Attributes
    ----------
    curves : dict of str to list of int
        Curves by their labels.
    rim : list of int
        Curves of the boundary.
    corners : dict of str to list of int
        Points by the labels of the curves that end there, where the domain has a reflex angle.
    """

    def __init__(self, model: Any):
        self.model, self.kernel = model, model.geo
        self.curves, self.corners, self.rim = dict[str, list[int]](), dict[str, list[int]](), list[int]()
        self._points = dict[tuple[float, float], int]()  # walls may touch

    def draw(self, domain: Mapping[str, Any]) -> None:
        """Rings, regions, lines and periodic sides."""
        loops = [self._ring(domain["outer"], 1), *(self._ring(ring, -1) for ring in domain.get("holes", ()))]
        self.rim = [curve for curves in self.curves.values() for curve in curves]
        inner = [self._ring(region["ring"], 0) for region in domain.get("regions", ())]
        surface = self.kernel.addPlaneSurface([*loops, *inner])
        for loop in inner:
            self.kernel.addPlaneSurface([loop])
        lines = [curve for line in domain.get("lines", ()) for curve in self._line(line)]
        self.kernel.synchronize()
        if lines:
            self.model.mesh.embed(1, lines, 2, surface)
        for first, second in domain.get("periodic", ()):
            (a,), (b,) = self.curves[first], self.curves[second]
            shift = np.subtract(self._middle(b), self._middle(a))
            matrix = np.eye(4)
            matrix[:3, 3] = shift
            self.model.mesh.setPeriodic(1, [b], [a], matrix.ravel().tolist())

    def _point(self, x: float, y: float) -> int:
        if (x, y) not in self._points:
            self._points[x, y] = self.kernel.addPoint(x, y, 0)
        return self._points[x, y]

    def _middle(self, curve: int) -> Floats:
        low, high = self.model.getParametrizationBounds(1, curve)
        return self.model.getValue(1, curve, [(low[0] + high[0]) / 2])

    def _ring(self, ring: Mapping[str, Any], inside: int) -> int:
        if "circle" in ring:
            return self.kernel.addCurveLoop(self._circle(ring))
        points = np.array(ring["polygon"])
        turns = inside * _turns(points)
        tags = [self._point(*point) for point in points.tolist()]
        corners = np.abs(turns) > SMOOTH["corners"] if "smooth" in ring else np.ones(len(points), bool)
        cuts = [*np.flatnonzero(corners), np.flatnonzero(corners)[0] + len(points)]
        labels = ring.get("labels") or [ring["label"]] * (len(cuts) - 1)
        curves = []
        for (first, last), label in zip(pairwise(cuts), labels, strict=True):
            chain = [tags[k % len(tags)] for k in range(first, last + 1)]
            curves.append(self.kernel.addSpline(chain) if len(chain) > 2 else self.kernel.addLine(*chain))
            self.curves.setdefault(label, []).append(curves[-1])
            if turns[first % len(tags)] < 180 - REFLEX:
                self.corners.setdefault(label, []).append(chain[0])
        return self.kernel.addCurveLoop(curves)

    def _circle(self, ring: Mapping[str, Any]) -> list[int]:
        (x, y), radius = ring["circle"]["center"], ring["circle"]["radius"]
        center = self.kernel.addPoint(x, y, 0)
        rim = [self.kernel.addPoint(x + radius * i, y + radius * j, 0) for i, j in ((1, 0), (0, 1), (-1, 0), (0, -1))]
        arcs = [self.kernel.addCircleArc(a, center, b) for a, b in zip(rim, [*rim[1:], rim[0]], strict=True)]
        self.curves.setdefault(ring["label"], []).extend(arcs)
        return arcs

    def _line(self, line: Mapping[str, Any]) -> list[int]:
        tags = [self._point(*point) for point in line["path"]]
        found = [self.kernel.addLine(a, b) for a, b in pairwise(tags)]
        self.curves.setdefault(line["label"], []).extend(found)
        self.corners.setdefault(line["label"], []).extend([tags[0], tags[-1]])
        return found


def _turns(points: Floats) -> Floats:
    """Angles (n,) in degrees by which a ring turns to the left at its vertices, if it ran counter-clockwise."""
    x, y = points.T
    way = np.sign(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    into, out = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    cross, along = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0], (into * out).sum(axis=1)
    return way * np.degrees(np.arctan2(cross, along))


def _spaced(field: Any, drawn: Drawing, spacing: Any) -> None:
    """The spacing as the background: one value, or a size near a label that grows to a maximum."""
    terms = [f"{spacing}"] if isinstance(spacing, float) else list(_terms(field, drawn, spacing))
    tags = [field.add("MathEval") for _ in terms]
    for tag, text in zip(tags, terms, strict=True):
        field.setString(tag, "F", text)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", tags)
    field.setAsBackgroundMesh(least)


def _terms(field: Any, drawn: Drawing, spacing: Mapping[str, Any]) -> Iterator[str]:
    if "maximum" in spacing:
        yield f"{spacing['maximum']}"
    for near in spacing["near"]:
        distance = field.add("Distance")
        field.setNumbers(distance, "CurvesList", drawn.curves[near["label"]])
        many = len(drawn.curves[near["label"]]) > SAMPLES
        field.setNumber(distance, "Sampling", 2 if many else SAMPLES)
        yield f"{near['size']} + {near.get('growth', COARSEST)}*F{distance}"


def _layers(field: Any, drawn: Drawing, entry: Mapping[str, Any], keys: Keys, fans: bool) -> None:
    """A field for each surface that has the walls, since Gmsh has none for both sides of a curve at once."""
    model, curves = drawn.model, drawn.curves[entry["on"]]
    surfaces = {int(tag) for curve in curves for tag in model.getAdjacencies(1, curve)[0]}
    for surface in surfaces or {1}:
        tag = field.add("BoundaryLayer")
        field.setNumbers(tag, "CurvesList", curves)
        field.setNumbers(tag, "ExcludedSurfacesList", sorted(surfaces - {surface}))
        field.setNumber(tag, "Size", entry["first"])
        field.setNumber(tag, "Ratio", entry["growth"])
        field.setNumber(tag, "Thickness", thickness(keys) * (1 + 1e-6))
        ends = [abs(end) for _, end in model.getBoundary([(1, curve) for curve in curves], combined=True)]
        field.setNumbers(tag, "PointsList", ends)
        if fans:
            field.setNumbers(tag, "FanPointsList", drawn.corners.get(entry["on"], []))
        field.setAsBoundaryLayer(tag)


def _made(model: Any, drawn: Drawing, labels: list[str]) -> Made:
    """What Gmsh holds, without the nodes of no triangle, such as the arcs' centers."""
    tags, coordinates, _ = model.getNodes()
    points = coordinates.reshape(-1, 3)[:, :2]
    index = np.zeros(int(tags.max()) + 1, int)
    index[tags] = np.arange(len(tags))
    triangles = index[model.getElementsByType(TRIANGLE)[1]].reshape(-1, 3)
    used = np.zeros(len(points), bool)
    used[triangles] = True
    number = np.cumsum(used) - 1

    def edges(curves: list[int]) -> Integers:
        found = [model.getElementsByType(LINE, curve)[1] for curve in curves]
        return number[index[np.concatenate([np.zeros(0, tags.dtype), *found])]].reshape(-1, 2)

    return Made(
        points[used],
        number[triangles],
        edges(drawn.rim),
        edges([curve for label in labels for curve in drawn.curves[label]]),
    )
