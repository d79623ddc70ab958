"""JSON text to be read by people: short lists and mappings on one line."""

import json
from typing import Any

from bubblemesh.meshfiles.report_json import json_ready

LINE = 96  # characters
STEP = 2


def readable_json(data: Any, most_lines: int) -> tuple[str, int]:
    """JSON text of at most so many lines, and the number of lines that were left out."""
    lines = _text(json_ready(data), 0).split("\n")
    return "\n".join(lines[:most_lines]), max(len(lines) - most_lines, 0)


def _text(value: Any, indent: int) -> str:
    line = json.dumps(value, ensure_ascii=False)
    if len(line) + indent <= LINE or not isinstance(value, dict | list) or not value:
        return line
    inner = indent + STEP
    if isinstance(value, dict):
        items = [f"{json.dumps(key, ensure_ascii=False)}: {_text(item, inner)}" for key, item in value.items()]
    else:
        items = [_text(item, inner) for item in value]
    opening, closing = ("{", "}") if isinstance(value, dict) else ("[", "]")
    separator = ",\n" + " " * inner
    return f"{opening}\n{' ' * inner}{separator.join(items)}\n{' ' * indent}{closing}"
