"""The core schema of YAML 1.2: what an unquoted word of a YAML file means."""

import re
from collections.abc import Callable
from typing import Any

__all__ = ["plain"]


# Longer integers exceed the floats, and Python refuses to read thousands of digits.
MAX_DIGITS = 300


def _integer(text: str) -> int | float:
    return int(text) if len(text) <= MAX_DIGITS else float(text)


# Unlike YAML 1.1: on, yes and no are words, 1e-3 is a number, 010 is ten, 1:30 and 2001-01-01 are text.
PLAIN: tuple[tuple[str, re.Pattern[str], Callable[[str], Any]], ...] = (
    ("null", re.compile(r"|~|null|Null|NULL"), lambda text: None),
    ("bool", re.compile(r"true|True|TRUE"), lambda text: True),
    ("bool", re.compile(r"false|False|FALSE"), lambda text: False),
    ("int", re.compile(r"[-+]?[0-9]+"), _integer),
    ("int", re.compile(r"0o[0-7]+"), lambda text: int(text[2:], 8)),
    ("int", re.compile(r"0x[0-9a-fA-F]+"), lambda text: int(text[2:], 16)),
    ("float", re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"), float),
    ("float", re.compile(r"[-+]?\.(inf|Inf|INF)"), lambda text: float(text.replace(".", ""))),
    ("float", re.compile(r"\.(nan|NaN|NAN)"), lambda text: float("nan")),
)


def plain(text: str) -> tuple[str, Any]:
    """Kind and value of an unquoted scalar."""
    for kind, pattern, convert in PLAIN:
        if pattern.fullmatch(text):
            return kind, convert(text)
    return "str", text
