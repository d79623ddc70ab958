"""Text that pages show: counts, places that are buttons, and JSON in short lines."""

import json
import math
import re
from typing import Any

from bubblemesh.meshfiles.report_json import json_ready
from bubblemesh.pages.markup import Markup, html, tag

NUMBER = r"-?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
PLACE = re.compile(rf"\(({NUMBER}), ({NUMBER})\)")
LONGEST_LINE = 96  # characters
INDENT = 2


def whole(number: int) -> str:
    """A count with its thousands set apart."""
    return f"{number:,}"


def linked_places(message: str) -> Markup:
    """A message in which each place is a button that shows it in the picture of the mesh."""
    parts: list[Markup | str] = []
    end = 0
    for found in PLACE.finditer(message):
        x, y = float(found[1]), float(found[2])
        if math.isfinite(x) and math.isfinite(y):
            parts += [message[end : found.start()], place_button(found[0], x, y)]
            end = found.end()
    return html(*parts, message[end:])


def place_button(text: str, x: float, y: float) -> Markup:
    """A button that shows a place in the picture of the mesh."""
    return tag("button", text, type="button", class_="place", data_x=repr(x), data_y=repr(y), title="Show in the mesh")


def readable_json(data: Any, most_lines: int) -> tuple[str, int]:
    """JSON text of at most so many lines, and the number of lines that were left out."""
    lines = _json_text(json_ready(data), 0).split("\n")
    return "\n".join(lines[:most_lines]), max(len(lines) - most_lines, 0)


def _json_text(value: Any, indent: int) -> str:
    line = json.dumps(value, ensure_ascii=False)
    if len(line) + indent <= LONGEST_LINE or not isinstance(value, dict | list) or not value:
        return line
    inner = indent + INDENT
    if isinstance(value, dict):
        items = [f"{json.dumps(key, ensure_ascii=False)}: {_json_text(item, inner)}" for key, item in value.items()]
    else:
        items = [_json_text(item, inner) for item in value]
    opening, closing = ("{", "}") if isinstance(value, dict) else ("[", "]")
    separator = ",\n" + " " * inner
    return f"{opening}\n{' ' * inner}{separator.join(items)}\n{' ' * indent}{closing}"
