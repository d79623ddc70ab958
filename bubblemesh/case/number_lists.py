"""Fast reading of lists of numbers in YAML text: a ring may have hundreds of thousands of points.

Each list, in brackets or as a list of such lists on lines with dashes, is cut out of the text before that is parsed,
and replaced by a word with its number, `MARK` and digits. If the parser finds this word as a value, the list was one.
If it is part of a text, a key or anything else, the whole text has to be read again in the usual way.
"""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import chain
from typing import Any

from bubblemesh.records import record

MARK = "\ue000"  # a character for private use, with which a plain scalar may begin
CANDIDATE = re.compile(r"\[[-+.0-9eE,\[\] \r\n]*")
BETWEEN_BREAKS = re.compile(r"[^\r\n]+")
# Lines with a dash and a list each, all with the same indentation; blank lines and comments may be between and after
# them.
COMMENT = r"#[^\r\n\x85\u2028\u2029]*"  # the last three end lines in YAML
LINE = rf"- +\[[-+.0-9eE, ]*\](?: *| +{COMMENT})(?:\r?\n|\Z)"
LINES = re.compile(rf"^(?P<indent> *){LINE}(?:(?: *(?:{COMMENT})?\r?\n)*+(?P=indent){LINE})++", re.MULTILINE)
WHOLE_LINE = re.compile(rf" *{LINE}")
ITEM = re.compile(r"^ *- +(\[[^\]]*\])", re.MULTILINE)
LEAST = 16  # characters of a list from which on this saves time
NUMBERS = {int, float}


@record
class NumberList:
    """A list of numbers, or of such lists, with its text in a case.

    Attributes
    ----------
    value : list
    text : str
        Its text, from bracket to bracket, or whole lines.
    size : int
        Number of values in it, including inner lists and itself.
    height : int
        1 for numbers, 2 for lists of them.
    has_lines : bool
        Whether the text is lines with dashes, which cannot stand within brackets.
    """

    value: list[Any]
    text: str
    size: int
    height: int
    has_lines: bool = False


def cut_out(text: str, integer: Callable[[str], Any]) -> tuple[str, dict[str, NumberList]]:
    """Text with words in place of its lists of numbers, on the same lines, and the lists by these words.

    ``integer`` converts the digits of an integer. No list is replaced in a text that contains `MARK`.
    """
    lists: dict[str, NumberList] = {}
    if MARK in text:
        return text, lists
    decode = json.JSONDecoder(parse_int=integer).decode

    def replaced(text: str, found: NumberList | None) -> str:
        if found is None:
            return text
        word = f"{MARK}{len(lists)}"
        lists[word] = found
        return word + BETWEEN_BREAKS.sub("", found.text)

    def without_lines(match: re.Match[str]) -> str:
        lines = _whole_lines(match)
        found = _number_list(f"[{','.join(ITEM.findall(lines))}]", decode)
        if found is None:
            return match[0]
        # A list may have the indentation of the key above it, but the word in its place must be indented further.
        indent = match["indent"] + " "
        return indent + replaced(lines, replace(found, text=lines, has_lines=True)) + match[0][len(lines) :]

    def without_brackets(match: re.Match[str]) -> str:
        length = match[0].rfind("]") + 1
        list_text = match[0][:length]
        return replaced(list_text, _number_list(list_text, decode) if length >= LEAST else None) + match[0][length:]

    return CANDIDATE.sub(without_brackets, LINES.sub(without_lines, text)), lists


def _whole_lines(match: re.Match[str]) -> str:
    """Text of a match of `LINES` up to the end of its last line with a list.

    Python 3.11 before 3.11.5 also matches a part of the next line (CPython's issue 106052).
    """
    text, begin, end = match.string, match.start(), match.end()
    while True:
        last = max(text.rfind("\n", begin, end - 1) + 1, begin)
        line = WHOLE_LINE.match(text, last)
        if last == begin or (line is not None and line.end() == end):
            return text[begin:end]
        end = last


def _number_list(text: str, decode: Callable[[str], Any]) -> NumberList | None:
    """The list in a text that is one in JSON, and so the same in YAML; None for other texts and for empty lists."""
    try:
        value = decode(text)
    except (ValueError, RecursionError):
        return None
    parts = value if {*map(type, value)} == {list} else [value]
    if not all(parts) or not {*map(type, chain.from_iterable(parts))} <= NUMBERS:
        return None
    return NumberList(value, text, 1 + sum(map(len, parts)) + len(parts) * (parts is value), 1 + (parts is value))
