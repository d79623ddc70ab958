"""The size of an SVG drawing on paper, by its width, height and viewBox."""

import re
from collections.abc import Mapping
from math import inf

from bubblemesh.arrays import ROUNDING
from bubblemesh.readers.features import PhysicalLength
from bubblemesh.readers.svg.source import NUMBER, Element, view_box

INCH = 0.0254  # metres
PIXEL = INCH / 96  # by CSS
PAPER = {"mm": 1e-3, "cm": 1e-2, "in": INCH, "pt": INCH / 72, "pc": INCH / 6}  # units in metres
UNITS = {**PAPER, "px": PIXEL, "": PIXEL}
PAPER_LENGTH = re.compile(rf"\s*({NUMBER})\s*(mm|cm|in|pt|pc|px|)\s*")


def physical_length(root: Element) -> PhysicalLength:
    """The length on paper of a drawing's unit, along x if it is stretched; by default a pixel."""
    scales = _scales(root, PAPER)
    if not scales:
        return PhysicalLength(PIXEL, True)
    if _fills_its_box(root):
        return PhysicalLength(_scales(root, UNITS)[0], False)
    fill = "slice" in root.attributes.get("preserveAspectRatio", "")  # else the whole box is visible
    return PhysicalLength(max(scales) if fill else min(scales), False)


def stretch(root: Element) -> float:
    """Length along y of what is 1 long along x: not 1 where ``preserveAspectRatio`` lets a drawing fill its box."""
    scales = _scales(root, UNITS)
    ratio = scales[1] / scales[0] if _fills_its_box(root) and len(scales) == 2 else 1.0
    return ratio if abs(ratio - 1) > ROUNDING else 1.0


def _fills_its_box(root: Element) -> bool:
    """Whether the two directions may have different scales."""
    return root.attributes.get("preserveAspectRatio", "").split()[:1] == ["none"]


def _scales(root: Element, units: Mapping[str, float]) -> list[float]:
    """Lengths in metres of a drawing's unit along x and y, as far as width and height are given in one of the units."""
    box = view_box(root)
    if box is None:
        return []
    sizes = (_metres(root, key, units) / whole for key, whole in zip(("width", "height"), box[2:], strict=True))
    return [scale for scale in sizes if 0 < scale < inf]


def _metres(root: Element, key: str, units: Mapping[str, float]) -> float:
    """Width or height of a drawing; 0 if it is not given in one of the units."""
    found = PAPER_LENGTH.fullmatch(root.attributes.get(key, ""))
    return float(found[1]) * units.get(found[2], 0.0) if found else 0.0
