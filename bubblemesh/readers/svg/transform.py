"""Transforms of the elements of an SVG drawing, by the attribute or by CSS, about their origins."""

import re
from collections.abc import Sequence

import svgelements

from bubblemesh.errors import CaseError
from bubblemesh.messages import shown
from bubblemesh.readers.svg.curves import PIXELS, Size
from bubblemesh.readers.svg.source import LENGTH, NUMBER, Element
from bubblemesh.readers.svg.style import StyleKeys

MOVES = ("translate", "rotate", "scale")  # properties of CSS that come before its transform, in this order
SIDES = {"left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%"}


def _call(name: str, argument: str, more: str = "{0}") -> str:
    """Pattern of a function of CSS with an argument, and further ones in the number of the quantifier."""
    return rf"{name}\(\s*{argument}(?:[\s,]+{argument}){more}\s*\)"


ZERO = r"[-+]?0+(?:\.0*)?"  # which needs no unit
SHIFT, ANGLE = rf"(?:{NUMBER}px|{ZERO})", rf"(?:{NUMBER}(?:deg|grad|rad|turn)|{ZERO})"
FUNCTIONS = (
    _call("translate", SHIFT, "?"),
    _call("translate[xy]", SHIFT),
    _call("scale", NUMBER, "?"),
    _call("scale[xy]", NUMBER),
    _call("(?:rotate|skewx|skewy)", ANGLE),
    _call("matrix", NUMBER, "{5}"),
)
READ = re.compile(rf"\s*(?:(?:{'|'.join(FUNCTIONS)})\s*)*")  # of CSS; browsers skip one with numbers without units


def transform_of(element: Element, style: StyleKeys, around: Sequence[Element], size: Size) -> str:
    """The transform of an element with its style, in the syntax of the attribute; empty if there is none.

    ``size`` is that of the drawing, ``around`` the elements around this one. CaseError for a transform of CSS that
    cannot be used, such as one in space.
    """
    attribute = element.attributes.get("transform", "")
    declared = [f"{key}({style[key]})" for key in MOVES if style.get(key, "none") != "none"]
    declared += [style["transform"]] if style.get("transform", "none") != "none" else []
    if not READ.fullmatch(" ".join(declared)):
        raise _unread(element, " ".join(declared))
    transform = " ".join(declared if "transform" in style else [*declared, attribute])
    if not {"transform-origin", "transform-box"} & style.keys() or _is_shift(transform):
        return transform
    if style.get("transform-box", "view-box") != "view-box":
        raise _unread(element, f"transform-box: {style['transform-box']}")
    is_nested = any(one.tag in ("svg", "symbol") for one in around[1:])  # with another size than the drawing
    x, y = _origin(element, style.get("transform-origin", "0 0"), None if is_nested else size)
    return f"translate({x!r},{y!r}) {transform} translate({-x!r},{-y!r})" if x or y else transform


def _is_shift(transform: str) -> bool:
    """Whether a transform does not depend on its origin."""
    matrix = svgelements.Matrix(transform)
    return bool((matrix.a, matrix.b, matrix.c, matrix.d) == (1, 0, 0, 1))


def _origin(element: Element, text: str, size: Size | None) -> tuple[float, float]:
    """Origin of a transform, in the coordinates around the element; percents are of ``size``."""
    words = text.split()
    across, down = (*words, "center")[:2]
    if across in ("top", "bottom") or down in ("left", "right"):
        across, down = down, across
    given = [SIDES.get(word, word) for word in (across, down)]
    if len(words) > 3 or not all(LENGTH.fullmatch(one) for one in given) or (size is None and "%" in "".join(given)):
        raise _unread(element, f"transform-origin: {text}")
    x, y = (
        float(svgelements.Length(one).value(ppi=PIXELS, relative_length=whole))
        for one, whole in zip(given, size or (0.0, 0.0), strict=True)
    )
    return x, y


def _unread(element: Element, text: str) -> CaseError:
    return CaseError(f"{element.name}: {shown(text)!r} is not read: write it as the attribute transform, in numbers")
