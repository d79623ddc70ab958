"""SVG drawings: shapes and paths with their transforms; y is turned to point up."""

import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import svgelements

from bubblemesh.errors import CaseError
from bubblemesh.files import read_bytes
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo
from bubblemesh.messages import shown
from bubblemesh.readers.features import (
    CompoundCurve,
    Feature,
    FeatureCollection,
    finite_points,
    foreign,
    writable_label,
)
from bubblemesh.readers.sampling import splines
from bubblemesh.readers.svg_source import require_valid

ROUND = 1e-9  # relative difference of an arc's radii that is rounding
MOST_NAMED = 5
SKIPPED = (svgelements.Text, svgelements.Image)
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"

# Names that drawing programs give by themselves: path12-3, Layer 1, XMLID_7_, st0, cls-2.
NUMBERED = re.compile(
    r"(circle|clip|cls|curve|ellipse|fil|frame|g|group|image|layer|line|object|patch|path|poly(line|gon)|rect(angle)?"
    r"|shape|st|str|svg|use|vector|xmlid)[-_ ]*\d[-_ .\d]*",
    re.IGNORECASE,
)


class Drawn(NamedTuple):
    """An element, the name of the layer or group that it is in, and its label: its own name, else that of the layer."""

    element: Any
    layer: str | None
    label: str | None


def read_svg(path: Path) -> FeatureCollection:
    """The shapes of a drawing in its own units, transforms applied and y turned up.

    Each part of a path that is drawn without lifting the pen is a curve. FileError or CaseError with the element.
    """
    content = read_bytes(path)
    require_valid(content)
    with foreign("not a valid drawing", "correct it"):
        return _features(svgelements.SVG.parse(BytesIO(content), reify=True, parse_display_none=True))


def _features(drawing: Any) -> FeatureCollection:
    # The viewport's scaling to pixels is undone: lengths are those of the file's numbers.
    back = svgelements.Matrix(drawing.viewbox_transform or "")
    back.inverse()
    features: list[Feature] = []
    notes: list[str] = []
    for drawn in _shapes(drawing):
        element = drawn.element
        if element.values.get("display") == "none":
            notes.append(f"{_name(element)} not used, since it is hidden")
        elif isinstance(element, svgelements.Shape):
            made = _feature(abs(svgelements.Path(element) * back), drawn, len(features))
            features += [made] if made.curves else []
            notes += [] if made.curves else [f"{_name(element)} not used, since it has no extent"]
        elif isinstance(element, SKIPPED):
            notes.append(f"{_name(element)} not used")
    if not features:
        left_out = "".join(f"; {note}" for note in notes[:MOST_NAMED])
        raise CaseError(f"there are no closed paths or shapes in it{left_out}")
    return FeatureCollection(tuple(features), tuple(notes))


def _shapes(group: Any, layer: str | None = None, label: str | None = None) -> Iterator[Drawn]:
    """Elements of a group that are drawn, those of inner groups and uses included."""
    for element in group:
        if isinstance(element, svgelements.Use):
            yield from _shapes(element, layer, _given(element) or label)
        elif isinstance(element, svgelements.Group):
            yield from _shapes(element, _given(element) or layer, label)
        else:
            yield Drawn(element, layer, label or _given(element) or layer)


def _given(element: Any) -> str | None:
    """The name that somebody gave an element: its label in Inkscape, else its id, else its first class."""
    own = element.values["attributes"]
    names = [own.get(f"{INKSCAPE}label"), own.get("id"), *str(own.get("class", "")).split()[:1]]
    return next((name.strip() for name in names if name and not NUMBERED.fullmatch(name.strip())), None)


def _name(element: Any) -> str:
    kind = str(element.values.get("tag", type(element).__name__.lower()))
    return f"{kind} {shown(element.id, 40)!r}" if element.id else kind


def _feature(path: Any, drawn: Drawn, number: int) -> Feature:
    """The element with a curve for each subpath."""
    element = drawn.element
    name = f"feature {number} ({_name(element)})"
    label, notes = writable_label(drawn.label, name)
    curves = []
    for subpath in path.as_subpaths():
        pieces, start = _pieces(list(svgelements.Path(subpath)), name)
        if pieces:
            curves.append(CompoundCurve(start, tuple(piece._replace(label=label) for piece in pieces), name))
    properties = {"id": element.id, "label": label, "class": element.values["attributes"].get("class")}
    return Feature(name, drawn.layer, properties, curves=tuple(curves), notes=notes)


def _pieces(segments: list[Any], name: str) -> tuple[list[Piece], Point]:
    """Pieces of a subpath, and its start."""
    pieces: list[Piece] = []
    start = here = (0.0, 0.0)
    for segment in segments:
        if segment.end is None:
            continue
        (end,) = finite_points([_up(segment.end)], name)
        if isinstance(segment, svgelements.Move):
            start = end
        elif _same(end, here) and isinstance(segment, svgelements.Line | svgelements.Close):
            continue
        else:
            pieces += _piece(segment, end, name)
        here = end
    return pieces, start


def _piece(segment: Any, end: Point, name: str) -> list[Piece]:
    if isinstance(segment, svgelements.Line | svgelements.Close):
        return [LineTo(end)]
    if isinstance(segment, svgelements.Arc) and abs(segment.rx - segment.ry) <= ROUND * segment.rx:
        (center,) = finite_points([_up(segment.center)], name)
        # A sweep is clockwise on a screen, whose y points down, and so it is once y is turned up: seen, not computed.
        # The ends of a full turn would be one point.
        middle = [] if abs(segment.sweep) < 1.9 * np.pi else [_up(segment.point(0.5))]
        stops = [*finite_points(middle, name), end]
        return [ArcTo(stop, center, segment.sweep < 0) for stop in stops]

    def curve(t: Any) -> Any:
        return np.array(finite_points([_up(segment.point(value)) for value in t.tolist()], name))

    return [SplineTo([(x, y) for x, y in points[1:].tolist()]) for points in splines(curve)]


def _same(a: Point, b: Point) -> bool:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= ROUND * max(1.0, abs(a[0]), abs(a[1]))


def _up(point: Any) -> Point:
    return float(point.x), 0.0 - float(point.y)  # no negative zero
