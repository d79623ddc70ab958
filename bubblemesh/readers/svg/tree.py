"""The shapes that the elements of an SVG drawing draw, with inherited styles and clips."""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import svgelements

from bubblemesh.errors import CaseError, GeometryError
from bubblemesh.geometry.arrangement.winding import FillRule
from bubblemesh.messages import shown
from bubblemesh.readers.features import Clip
from bubblemesh.readers.svg.clips import Stencil, clip_of
from bubblemesh.readers.svg.curves import PIXELS, SHAPES, Size, curves_of, path_of
from bubblemesh.readers.svg.source import HREFS, MOST_ELEMENTS, UNDRAWN, Element, too_much_clipping, view_box
from bubblemesh.readers.svg.style import StyleKeys, StyleSheet, is_out_of_sight
from bubblemesh.readers.svg.transform import transform_of
from bubblemesh.records import record

INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"
DRAWN_ELSE = ("text", "image", "foreignObject")  # elements that draw something, but no curves
REFERENCE = re.compile(r"url\(\s*[\"']?#([^\"')]+?)[\"']?\s*\)")

# Default names of drawing programs: path12-3, Layer 1, XMLID_7_, st0, cls-2.
NUMBERED = re.compile(
    r"(circle|clip|cls|curve|ellipse|fil|frame|g|group|image|layer|line|object|patch|path|poly(line|gon)|rect(angle)?"
    r"|shape|st|str|svg|use|vector|xmlid)[-_ ]*\d[-_ .\d]*",
    re.IGNORECASE,
)


@record
class Around:
    """Context of an element from the groups around it: the path to it, and what it inherits."""

    elements: tuple[Element, ...] = ()
    transform: str = ""
    style: StyleKeys = field(default_factory=dict)
    layer: str | None = None  # name of the innermost layer or group that has one
    label: str | None = None  # of a use
    hidden: bool = False
    masked: bool = False
    clips: tuple[Clip, ...] | None = ()  # for all elements in it; None if only the extent is needed
    inside: tuple[str, ...] = ()  # names of the clipPaths around it


class Drawn(NamedTuple):
    """A shape with its context, including its own style."""

    element: Element
    around: Around


@dataclass
class Drawing:
    """State of a walk through the elements of a drawing."""

    root: Element
    sheet: StyleSheet
    by_id: Mapping[str, Element]
    size: Size
    unused: Counter[str] = field(default_factory=Counter)
    unclipped: Counter[str] = field(default_factory=Counter)  # elements whose clips cannot be applied, by the reason
    masked: int = 0
    visits: Counter[str] = field(default_factory=Counter)  # of elements, by their sizes
    clips: dict[tuple[str, str], Clip | None] = field(default_factory=dict)  # by clipPath and transform; None if failed
    failed: dict[str, str] = field(default_factory=dict)  # reasons why clipPaths cannot be applied, by their names

    @classmethod
    def of(cls, root: Element) -> "Drawing":
        """The drawing of a root element."""
        by_id: dict[str, Element] = {}
        for element in root.all():
            if "id" in element.attributes:
                by_id.setdefault(element.attributes["id"], element)
        return cls(root, StyleSheet.of(root), by_id, _size(root))


def _size(root: Element) -> tuple[float, float]:
    """Width and height of a drawing in its own units."""
    box = view_box(root)
    if box is not None:
        return box[2:]
    return _length(root, "width", 100.0, "100"), _length(root, "height", 100.0, "100")


def _length(element: Element, key: str, whole: float, default: str) -> float:
    """A length of an element in pixels; percents are of ``whole``."""
    given = element.attributes.get(key, default)
    return float(svgelements.Length(default if given == "auto" else given).value(ppi=PIXELS, relative_length=whole))


def shapes(drawing: Drawing, element: Element, around: Around) -> Iterator[Drawn]:
    """Shapes that an element draws, including those of inner groups and uses."""
    _count(drawing, element)
    here = _context(drawing, element, around)
    draw = DRAW.get(element.tag)
    if draw is not None:
        yield from draw(drawing, element, here)


def _context(drawing: Drawing, element: Element, around: Around) -> Around:
    """Context for the content of an element, including its own style, transform and clip."""
    style = drawing.sheet.style(element, around.elements, around.style)
    here = replace(
        around,
        elements=(*around.elements, element),
        transform=f"{around.transform} {transform_of(element, style, around.elements, drawing.size)}".strip(),
        style=style,
        hidden=around.hidden or is_out_of_sight(style),
        masked=around.masked or style.get("mask", "none") != "none",
    )
    clip = _clip(drawing, element, around, here)
    return here if clip is None or here.clips is None else replace(here, clips=(*here.clips, clip))


def _shape(drawing: Drawing, element: Element, here: Around) -> Iterator[Drawn]:
    """A shape; its label is the name of the use, its own name, or that of its layer."""
    yield Drawn(element, replace(here, label=here.label or _given(element) or here.layer))


def _unread(drawing: Drawing, element: Element, here: Around) -> Iterator[Drawn]:
    """No shapes: an element without curves, which is counted if it is visible."""
    drawing.unused[f"{element.tag} of a clip-path" if here.inside else element.tag] += not here.hidden
    return iter(())


def _use(drawing: Drawing, use: Element, here: Around) -> Iterator[Drawn]:
    """Shapes of the element that a use draws at its place."""
    target = drawing.by_id.get(_target(use))
    if target is None:
        drawing.unused["use of nothing that is there"] += 1
        return iter(())
    x, y = (_length(use, key, whole, "0") for key, whole in zip("xy", drawing.size, strict=True))
    here = replace(here, transform=f"{here.transform} translate({x},{y})".strip(), label=_given(use) or here.label)
    if target.tag not in ("symbol", "svg"):
        return shapes(drawing, target, here)
    own = drawing.sheet.style(target, here.elements, here.style)
    return _within(drawing, target, _in_viewport(drawing, target, use, own, here))


def _switch(drawing: Drawing, switch: Element, here: Around) -> Iterator[Drawn]:
    """Shapes of the first alternative that any reader may choose."""
    chosen = next((child for child in switch.children if _is_for_all(child)), None)
    return iter(()) if chosen is None else shapes(drawing, chosen, here)


def _group(drawing: Drawing, group: Element, here: Around) -> Iterator[Drawn]:
    """Shapes in a group or a nested drawing, which counts as a layer if it has a name."""
    if group is drawing.root:
        return _within(drawing, group, here)
    if group.tag == "svg":
        here = _in_viewport(drawing, group, group, here.style, here)
    return _within(drawing, group, replace(here, layer=_given(group) or here.layer))


# Functions that yield the shapes of elements, by tag; other elements draw nothing.
DRAW: Mapping[str, Callable[[Drawing, Element, Around], Iterator[Drawn]]] = {
    **dict.fromkeys(SHAPES, _shape),
    **dict.fromkeys(DRAWN_ELSE, _unread),
    **dict.fromkeys(("g", "a", "svg"), _group),
    "use": _use,
    "switch": _switch,
}


def _count(drawing: Drawing, element: Element) -> None:
    drawing.visits["elements"] += element.size
    if drawing.visits["elements"] > 2 * MOST_ELEMENTS:
        raise too_much_clipping()


def _clip(drawing: Drawing, element: Element, around: Around, here: Around) -> Clip | None:
    """Clip by the clip-path of an element; None if it has none, or one that cannot be applied."""
    given = here.style.get("clip-path", "none")
    target = None if given == "none" or around.clips is None else _clip_path(drawing, given)
    if target is None:
        return None
    name = target.attributes["id"]
    if name in here.inside:
        raise CaseError(f"{target.name}: it clips itself: remove its clip-path")
    transform = here.transform
    if target.attributes.get("clipPathUnits") == "objectBoundingBox":
        box = _box(drawing, element, around, here)
        if box is None:
            return Clip(())
        transform = f"{transform} {box}".strip()
    key = name, transform
    if key not in drawing.clips:
        drawing.clips[key] = None
        try:
            drawing.clips[key] = _made(drawing, target, transform, (*here.inside, name))
        except GeometryError as error:
            drawing.failed.setdefault(name, f"{target.name}: {error}")
    if drawing.clips[key] is None:
        drawing.unclipped[drawing.failed[name]] += 1
    return drawing.clips[key]


def _clip_path(drawing: Drawing, given: str) -> Element | None:
    """The clipPath to which the clip-path of a style refers; None if it is missing, which is counted."""
    found = REFERENCE.match(given)
    target = drawing.by_id.get(found[1]) if found else None
    if target is not None and target.tag == "clipPath":
        return target
    why = f"there is no clipPath {shown(found[1], 40)!r}" if found else f"{shown(given, 40)!r} is not read"
    drawing.unclipped[why] += 1
    return None


def _made(drawing: Drawing, target: Element, transform: str, inside: tuple[str, ...]) -> Clip:
    """The clip made of all shapes of a clipPath."""
    style = drawing.sheet.style(target, (), {})
    whole = f"{transform} {transform_of(target, style, (), drawing.size)}".strip()
    here = Around((target,), whole, style, inside=inside)
    own = _clip(drawing, target, Around(inside=inside), replace(here, transform=transform))
    here = replace(here, clips=() if own is None else (own,))
    stencils = []
    for element, around in _within(drawing, target, here):
        if not around.hidden and around.style.get("visibility", "visible") == "visible":
            curves = curves_of(element, around.transform, drawing.size, element.name, None)
            rule: FillRule = "evenodd" if around.style.get("clip-rule") == "evenodd" else "nonzero"
            stencils.append(Stencil(curves, rule, around.clips or ()))
    return clip_of(stencils)


def _box(drawing: Drawing, element: Element, around: Around, here: Around) -> str | None:
    """Transform from the unit square to the box around the shapes of an element; None if that has no extent."""
    matrix = svgelements.Matrix(here.transform)
    if matrix.determinant == 0:
        return None
    aside = replace(drawing, unused=Counter(), unclipped=Counter())
    drawn = shapes(aside, element, replace(around, clips=None))
    paths = (path_of(one, svgelements.Matrix(context.transform) * ~matrix, drawing.size) for one, context in drawn)
    boxes = np.array([box for path in paths if (box := path.bbox()) is not None], float).reshape(-1, 4)
    if len(boxes) == 0:
        return None
    (x0, y0), (x1, y1) = boxes[:, :2].min(axis=0).tolist(), boxes[:, 2:].max(axis=0).tolist()
    return f"matrix({x1 - x0!r},0,0,{y1 - y0!r},{x0!r},{y0!r})" if x1 > x0 and y1 > y0 else None


def _within(drawing: Drawing, group: Element, here: Around) -> Iterator[Drawn]:
    for child in group.children:
        if child.tag not in UNDRAWN:
            yield from shapes(drawing, child, here)


def _in_viewport(drawing: Drawing, element: Element, sized: Element, style: StyleKeys, here: Around) -> Around:
    """Context for the content of a nested drawing or a symbol with a style, clipped to its box.

    ``sized`` is the element with its width and height, if they are given.
    """
    x, y = (_length(element, key, whole, "0") for key, whole in zip("xy", drawing.size, strict=True))
    given = {key: sized if key in sized.attributes else element for key in ("width", "height")}
    width, height = (
        _length(one, key, whole, "100%") for (key, one), whole in zip(given.items(), drawing.size, strict=True)
    )
    fixed = all(_is_fixed(one.attributes.get(key, "auto")) for key, one in given.items())
    if fixed and here.clips is not None and style.get("overflow", "hidden") not in ("visible", "auto"):
        box = {"x": repr(x), "y": repr(y), "width": repr(width), "height": repr(height)}
        curves = curves_of(Element("rect", box, element.line), here.transform, drawing.size, element.name, None)
        here = replace(here, clips=(*here.clips, clip_of([Stencil(curves, "nonzero", ())])))
    move = f"translate({x},{y})" if x or y else ""
    view = view_box(element)
    if view is not None:
        aspect = element.attributes.get("preserveAspectRatio", "xMidYMid meet")
        move = svgelements.Viewbox.viewbox_transform(x, y, width, height, *view, aspect)
    return replace(here, transform=f"{here.transform} {move}".strip())


def _is_fixed(length: str) -> bool:
    """Whether a length differs from that around: a drawing is not clipped where the whole one ends."""
    return length != "auto" and "%" not in length


def _target(use: Element) -> str:
    return next((use.attributes[key] for key in HREFS if key in use.attributes), "").removeprefix("#")


def _is_for_all(child: Element) -> bool:
    """Whether an alternative of a switch can be used by all readers."""
    needs = ("requiredExtensions", "requiredFeatures", "systemLanguage")
    return child.tag not in DRAWN_ELSE and not any(key in child.attributes for key in needs)


def _given(element: Element) -> str | None:
    """The name given to an element by a person: its label in Inkscape, else its id, else its first class."""
    own = element.attributes
    names = [own.get(f"{INKSCAPE} label"), own.get("id"), *own.get("class", "").split()[:1]]
    return next((name.strip() for name in names if name and not NUMBERED.fullmatch(name.strip())), None)
