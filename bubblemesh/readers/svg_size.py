"""The size of an SVG drawing on paper, by its width, height and viewBox."""

import re
from math import inf

from bubblemesh.readers.features import PhysicalLength
from bubblemesh.readers.svg_source import NUMBER, Element

INCH = 0.0254  # metres
PIXEL = INCH / 96  # as CSS has it
METRES = {"mm": 1e-3, "cm": 1e-2, "in": INCH, "pt": INCH / 72, "pc": INCH / 6}
LENGTH = re.compile(rf"\s*({NUMBER})\s*(mm|cm|in|pt|pc)\s*")


def physical_length(root: Element) -> PhysicalLength:
    """The length on paper of a drawing's own unit, which is a pixel if nothing tells."""
    box = re.findall(NUMBER, root.attributes.get("viewBox", ""))
    sizes = (
        _metres(root, key) / float(whole) for key, whole in zip(("width", "height"), box[2:], strict=False) if whole
    )
    scales = [scale for scale in sizes if 0 < scale < inf]
    if not scales:
        return PhysicalLength(PIXEL, True)
    fill = "slice" in root.attributes.get("preserveAspectRatio", "")  # else the whole box is to be seen
    return PhysicalLength(max(scales) if fill else min(scales), False)


def _metres(root: Element, key: str) -> float:
    """Width or height of a drawing; 0 if it is not given in a unit that paper has."""
    found = LENGTH.fullmatch(root.attributes.get(key, ""))
    return float(found[1]) * METRES[found[2]] if found else 0.0
