"""Lists of numbers in YAML text, which are read at once: a ring may have hundreds of thousands of points.

Each is cut out of the text, and a word with its number, `MARK` and digits, stands in its place. The parser's events
tell whether that word is a value by itself, for then the list was one; where it has become a part of a text, a key
or anything else, the whole text is to be read without this.
"""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain
from typing import Any

MARK = "\ue000"  # a character for private use, with which a plain scalar may begin
CANDIDATE = re.compile(r"\[[-+.0-9eE,\[\] \r\n]*")
BETWEEN_BREAKS = re.compile(r"[^\r\n]+")
LEAST = 16  # characters of a list that is worth it
NUMBERS = {int, float}


@dataclass(frozen=True)
class NumberList:
    """A list of numbers, or of such lists, with the text that it is in a case.

    Attributes
    ----------
    value : list
    text : str
        Its text, from bracket to bracket.
    size : int
        Number of values in it, lists and itself among them.
    height : int
        1 for numbers, 2 for lists of them.
    """

    value: list[Any]
    text: str
    size: int
    height: int


def cut_out(text: str, integer: Callable[[str], Any]) -> tuple[str, dict[str, NumberList]]:
    """Text with the same lines without its lists of numbers, and these by the words that stand for them.

    ``integer`` makes a number of the digits of an integer. A text that has `MARK` itself has no such lists.
    """
    lists: dict[str, NumberList] = {}
    if MARK in text:
        return text, lists
    decode = json.JSONDecoder(parse_int=integer).decode

    def replaced(match: re.Match[str]) -> str:
        length = match[0].rfind("]") + 1
        found = _number_list(match[0][:length], decode) if length >= LEAST else None
        if found is None:
            return match[0]
        word = f"{MARK}{len(lists)}"
        lists[word] = found
        return word + BETWEEN_BREAKS.sub("", found.text) + match[0][length:]

    return CANDIDATE.sub(replaced, text), lists


def _number_list(text: str, decode: Callable[[str], Any]) -> NumberList | None:
    """The list of a text that is one in JSON, and so the same one in YAML; None of others, and of empty ones."""
    try:
        value = decode(text)
    except (ValueError, RecursionError):
        return None
    parts = value if {*map(type, value)} == {list} else [value]
    if not all(parts) or not {*map(type, chain.from_iterable(parts))} <= NUMBERS:
        return None
    return NumberList(value, text, 1 + sum(map(len, parts)) + len(parts) * (parts is value), 1 + (parts is value))
