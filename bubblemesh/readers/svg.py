"""SVG drawings: shapes and paths with their transforms, styles and fill rules; y is turned to point up."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import svgelements

from bubblemesh.errors import CaseError
from bubblemesh.files import read_bytes
from bubblemesh.geometry.paths import Point
from bubblemesh.geometry.rings import ArcTo, LineTo, Piece, SplineTo, end_of
from bubblemesh.messages import counted, place, shown
from bubblemesh.readers.features import (
    HIDDEN,
    CompoundCurve,
    Feature,
    FeatureCollection,
    finite_points,
    foreign,
    writable_label,
)
from bubblemesh.readers.sampling import splines
from bubblemesh.readers.svg_fill import area_of, filled
from bubblemesh.readers.svg_size import physical_length
from bubblemesh.readers.svg_source import HREFS, UNDRAWN, Element, checked
from bubblemesh.readers.svg_style import Style, StyleSheet

ROUND = 1e-9  # relative difference of an arc's radii that is rounding
FLAT = 1e-9  # area of a subpath, in terms of its extent, that is none
PIXELS = 96  # in an inch
INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"
SHAPES = {
    "path": svgelements.Path,
    "rect": svgelements.Rect,
    "circle": svgelements.Circle,
    "ellipse": svgelements.Ellipse,
    "line": svgelements.SimpleLine,
    "polyline": svgelements.Polyline,
    "polygon": svgelements.Polygon,
}
DRAWN_ELSE = ("text", "image", "foreignObject")  # what draws something without curves that could be read
GROUPS = ("g", "a", "svg", "symbol")
NO_PAINT = ("none", "transparent")

# Names that drawing programs give by themselves: path12-3, Layer 1, XMLID_7_, st0, cls-2.
NUMBERED = re.compile(
    r"(circle|clip|cls|curve|ellipse|fil|frame|g|group|image|layer|line|object|patch|path|poly(line|gon)|rect(angle)?"
    r"|shape|st|str|svg|use|vector|xmlid)[-_ ]*\d[-_ .\d]*",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class _Around:
    """Context of an element from the groups around it: the way to it, and what it inherits."""

    elements: tuple[Element, ...] = ()
    transform: str = ""
    style: Style = field(default_factory=dict)
    layer: str | None = None  # name of the innermost layer or group that has one
    label: str | None = None  # of a use
    hidden: bool = False
    clipped: bool = False


class _Drawn(NamedTuple):
    """A shape with what is around it, its own style included."""

    element: Element
    around: _Around


@dataclass
class _Drawing:
    """A drawing on the way through its elements."""

    root: Element
    sheet: StyleSheet
    by_id: Mapping[str, Element]
    size: tuple[float, float]  # that lengths in percent are of
    unused: Counter[str] = field(default_factory=Counter)
    clipped: int = 0


def read_svg(path: Path) -> FeatureCollection:
    """The shapes of a drawing in its own units, transforms applied and y turned up.

    Each part of a path that is drawn without lifting the pen is a curve; open ones are closed where they are filled,
    and the fill rule tells which of them bound something. FileError or CaseError with the element.
    """
    root = checked(read_bytes(path))
    with foreign("not a valid drawing", "correct it"):
        by_id: dict[str, Element] = {}
        for element in root.all():
            if "id" in element.attributes:
                by_id.setdefault(element.attributes["id"], element)
        return _features(_Drawing(root, StyleSheet.of(root), by_id, _size(root)))


def _size(root: Element) -> tuple[float, float]:
    """Width and height of a drawing in its own units."""
    box = re.findall(r"[-+.\deE]+", root.attributes.get("viewBox", ""))
    if len(box) == 4:
        return float(box[2]), float(box[3])
    return _length(root, "width", 100.0, "100"), _length(root, "height", 100.0, "100")


def _length(element: Element, key: str, whole: float, default: str) -> float:
    """A length of an element in pixels; ``whole`` is what percents are of."""
    given = element.attributes.get(key, default)
    return float(svgelements.Length(default if given == "auto" else given).value(ppi=PIXELS, relative_length=whole))


def _features(drawing: _Drawing) -> FeatureCollection:
    features: list[Feature] = []
    for drawn in _shapes(drawing, drawing.root, _Around()):
        features.append(_feature(drawing, drawn, len(features)))
    notes = [f"{counted(number, tag)} not used" for tag, number in drawing.unused.items()]
    if drawing.clipped:
        notes.append(f"{counted(drawing.clipped, 'shape')} under a clip-path or mask used whole: clips are not applied")
    features, more = _closed(features, {one.name for one in features if one.properties["rule"]})
    features = [_by_fill_rule(one) for one in features]
    if not any(one.bounds for one in features):
        raise CaseError(f"there are no closed paths or shapes in it{''.join(f'; {note}' for note in (*notes, *more))}")
    return FeatureCollection(tuple(features), (*notes, *more), physical=physical_length(drawing.root))


def _shapes(drawing: _Drawing, element: Element, around: _Around) -> Iterator[_Drawn]:
    """Shapes that an element draws, those of inner groups and uses included."""
    style = drawing.sheet.style(element, around.elements, around.style)
    here = replace(
        around,
        elements=(*around.elements, element),
        transform=f"{around.transform} {element.attributes.get('transform', '')}".strip(),
        style=style,
        hidden=around.hidden or style.get("display") == "none",
        clipped=around.clipped or any(style.get(key, "none") != "none" for key in ("clip-path", "mask")),
    )
    tag = element.tag
    if tag in SHAPES:
        yield _Drawn(element, replace(here, label=here.label or _given(element) or here.layer))
    elif tag in DRAWN_ELSE:
        drawing.unused[tag] += not here.hidden
    elif tag == "use":
        target = drawing.by_id.get(_target(element))
        shift = (
            f"translate({_length(element, 'x', drawing.size[0], '0')},{_length(element, 'y', drawing.size[1], '0')})"
        )
        here = replace(here, transform=f"{here.transform} {shift}".strip(), label=_given(element) or here.label)
        if target is None:
            drawing.unused["use of nothing that is there"] += 1
        elif target.tag in ("symbol", "svg"):
            yield from _within(drawing, target, _in_viewport(drawing, target, element, here))
        else:
            yield from _shapes(drawing, target, here)
    elif tag == "switch":
        chosen = next((child for child in element.children if _is_for_all(child)), None)
        yield from _shapes(drawing, chosen, here) if chosen is not None else ()
    elif tag in GROUPS and tag != "symbol":
        if tag == "svg" and around.elements:
            here = _in_viewport(drawing, element, element, here)
        named = element is not drawing.root
        yield from _within(drawing, element, replace(here, layer=_given(element) or here.layer) if named else here)


def _within(drawing: _Drawing, group: Element, here: _Around) -> Iterator[_Drawn]:
    for child in group.children:
        if child.tag not in UNDRAWN:
            yield from _shapes(drawing, child, here)


def _in_viewport(drawing: _Drawing, element: Element, sized: Element, here: _Around) -> _Around:
    """Context of the content of a nested drawing or a symbol, whose width and height ``sized`` has."""
    x, y = (_length(element, key, whole, "0") for key, whole in zip("xy", drawing.size, strict=True))
    move = f"translate({x},{y})" if x or y else ""
    box = re.findall(r"[-+.\deE]+", element.attributes.get("viewBox", ""))
    if len(box) == 4:
        keys = zip(("width", "height"), drawing.size, strict=True)
        width, height = (
            _length(sized if key in sized.attributes else element, key, whole, "100%") for key, whole in keys
        )
        aspect = element.attributes.get("preserveAspectRatio", "xMidYMid meet")
        move = svgelements.Viewbox.viewbox_transform(x, y, width, height, *map(float, box), aspect)
    return replace(here, transform=f"{here.transform} {move}".strip())


def _target(use: Element) -> str:
    return next((use.attributes[key] for key in HREFS if key in use.attributes), "").removeprefix("#")


def _is_for_all(child: Element) -> bool:
    """Whether an alternative of a switch needs nothing that readers may lack."""
    needs = ("requiredExtensions", "requiredFeatures", "systemLanguage")
    return child.tag not in DRAWN_ELSE and not any(key in child.attributes for key in needs)


def _given(element: Element) -> str | None:
    """The name that somebody gave an element: its label in Inkscape, else its id, else its first class."""
    own = element.attributes
    names = [own.get(f"{INKSCAPE} label"), own.get("id"), *own.get("class", "").split()[:1]]
    return next((name.strip() for name in names if name and not NUMBERED.fullmatch(name.strip())), None)


def _feature(drawing: _Drawing, drawn: _Drawn, number: int) -> Feature:
    """The element with a curve for each subpath, and its fill rule among the properties if it is filled."""
    element, around = drawn
    own = element.attributes.get("id")
    name = f"feature {number} ({element.tag}{f' {shown(own, 40)!r}' if own else ''})"
    label, notes = writable_label(around.label, name)
    curves = []
    for subpath in _path(drawing, element, around.transform).as_subpaths():
        pieces, start = _pieces(list(svgelements.Path(subpath)), name)
        if pieces:
            pieces[-1] = _ending(pieces[-1], start)
            curves.append(CompoundCurve(start, tuple(piece._replace(label=label) for piece in pieces), name))
    style = around.style
    is_filled = style.get("fill", "black") not in NO_PAINT and element.tag != "line"
    unpainted = not is_filled and style.get("stroke", "none") in NO_PAINT
    hidden = around.hidden or unpainted or style.get("visibility", "visible") != "visible"
    drawing.clipped += around.clipped and not hidden
    rule = ("evenodd" if style.get("fill-rule") == "evenodd" else "nonzero") if is_filled else None
    properties = {"id": own, "label": label, "class": element.attributes.get("class"), "rule": rule}
    spare = HIDDEN if hidden else None
    return Feature(name, around.layer, properties, curves=tuple(curves), notes=notes, spare=spare)


def _path(drawing: _Drawing, element: Element, transform: str) -> Any:
    """The path of a shape, in the units of the drawing."""
    sizes = {"width": "0", "height": "0"} if element.tag == "rect" else {}
    given = {key: value for key, value in element.attributes.items() if key != "style" and value != "auto"}
    values = {**sizes, **given, "transform": transform, "attributes": element.attributes}
    if element.tag == "path":
        shape = svgelements.Path(values, pathd_loaded=True)
        shape.parse(element.attributes.get("d", ""))
    else:
        shape = SHAPES[element.tag](values)
    shape.render(ppi=PIXELS, width=drawing.size[0], height=drawing.size[1])
    return abs(svgelements.Path(shape))


def _closed(features: list[Feature], painted: set[str]) -> tuple[list[Feature], list[str]]:
    """The features with open subpaths of filled shapes closed straight, but for those that join with others."""
    points = [point for one in features for curve in one.curves for point in (curve.start, curve.end)]
    if not points:
        return features, []
    grid = 1e-7 * float(np.ptp(np.array(points), axis=0).max()) or 1.0

    def spot(point: Point) -> tuple[int, int]:
        return round(point[0] / grid), round(point[1] / grid)

    open_ = [curve for one in features for curve in one.curves if curve.start != curve.end]
    ends = Counter(spot(point) for curve in open_ for point in (curve.start, curve.end))
    gaps: list[tuple[float, Point]] = []

    def closed(curve: CompoundCurve) -> CompoundCurve:
        joins = ends[spot(curve.start)] > 1 and ends[spot(curve.end)] > 1
        loop = curve._replace(pieces=(*curve.pieces, LineTo(curve.start, curve.pieces[0].label)))
        if curve.start == curve.end or joins or area_of(loop) <= FLAT:
            return curve
        gaps.append((float(np.hypot(*np.subtract(curve.start, curve.end))), curve.end))
        return loop

    found = [replace(one, curves=tuple(map(closed, one.curves))) if one.name in painted else one for one in features]
    if not gaps:
        return found, []
    widest, where = max(gaps)
    many = counted(len(gaps), "open subpath")
    return found, [f"{many} closed straight, as what is filled is, the widest gap ({widest:.3g}) at {place(where)}"]


def _by_fill_rule(feature: Feature) -> Feature:
    """The feature with the loops that bound what is filled."""
    rule = feature.properties["rule"]
    loops = [curve for curve in feature.curves if curve.start == curve.end]
    if rule is None or not loops:
        return feature
    found = filled(loops, rule)
    if found.loops == loops:
        return feature
    others = [curve for curve in feature.curves if curve.start != curve.end]
    notes = tuple(f"{feature.name}: {note}" for note in found.notes)
    return replace(feature, curves=(*found.loops, *others), rings=tuple(found.rings), notes=(*feature.notes, *notes))


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


def _ending(piece: Piece, start: Point) -> Piece:
    """The last piece, with its end exactly at the start if they differ by rounding."""
    if not _same(end_of(piece), start):
        return piece
    return (
        piece._replace(through=[*piece.through[:-1], start])
        if isinstance(piece, SplineTo)
        else piece._replace(to=start)
    )


def _same(a: Point, b: Point) -> bool:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= ROUND * max(1.0, abs(a[0]), abs(a[1]))


def _up(point: Any) -> Point:
    return float(point.x), 0.0 - float(point.y)  # no negative zero
