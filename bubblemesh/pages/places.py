"""Places that messages name: (0.5, -1)."""

import math
import re

from bubblemesh.pages.markup import Markup, joined, tag

NUMBER = r"-?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
PLACE = re.compile(rf"\(({NUMBER}), ({NUMBER})\)")


def linked_places(message: str) -> Markup:
    """A message in which each place is a button that shows it in the picture of the mesh."""
    parts: list[Markup | str] = []
    end = 0
    for found in PLACE.finditer(message):
        x, y = float(found[1]), float(found[2])
        if math.isfinite(x) and math.isfinite(y):
            parts += [message[end : found.start()], place_button(found[0], x, y)]
            end = found.end()
    return joined(*parts, message[end:])


def place_button(text: str, x: float, y: float) -> Markup:
    """A button that shows a place in the picture of the mesh."""
    return tag("button", text, type="button", class_="place", data_x=repr(x), data_y=repr(y), title="Show in the mesh")
