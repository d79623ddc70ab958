"""YAML 1.2 text, with the merge keys of YAML 1.1, as plain data, with the line of every key."""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from bubblemesh.case.number_lists import MARK, NumberList, cut_out
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.files import CASE_FILE, case_text, opened
from bubblemesh.records import record

KeyPath = Sequence[str | int]

MAX_VALUES = 5_000_000
MAX_DEPTH = 100
TOO_DEEP = f"nested more than {MAX_DEPTH} deep: a case needs far less"
MAX_AHEAD = 2000  # characters of a value that is read ahead
LONG = 100_000  # characters of a text that takes noticeable time to read

# Events are parsed, not composed: `yaml.compose` is recursive in C, and a hundred thousand brackets overflow its stack.
LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

TAG_PREFIX = "tag:yaml.org,2002:"
MERGE = "<<"  # without quotes the key of mappings whose keys a mapping has too


class Node(NamedTuple):
    """A value, and the places within it; aliases share it."""

    value: Any
    places: "dict[str, Place] | Sequence[Place] | _LatePlaces" = ()
    size: int = 1
    height: int = 0


class Place(NamedTuple):
    """Line of a key of a mapping or an entry of a list, and its node."""

    line: int
    node: Node


@record
class _LatePlaces:
    """Places in a list of numbers, whose text is read again if they are needed."""

    text: str
    line: int  # of the text in the file

    @cached_property
    def found(self) -> "dict[str, Place] | Sequence[Place] | _LatePlaces":
        root = _Reader("\n" * (self.line - 1) + self.text, str).read()
        return () if root is None else root.places


@record
class Document:
    """The data of a case file: nested mappings, lists, text, numbers, booleans and None; every key is text.

    Aliases share their objects.
    """

    data: dict[str, Any]
    _root: Node

    def line(self, path: KeyPath) -> int | None:
        """Line, from 1, of the longest part of ``path`` that is in the file; None if no part is."""
        found = self._known(path)
        return found[-1].line if found else None

    def depth(self, path: KeyPath) -> int:
        """Number of parts of ``path`` that are in the file."""
        return len(self._known(path))

    def _known(self, path: KeyPath) -> list[Place]:
        """Places of the longest part of ``path`` that is in the file."""
        found: list[Place] = []
        places = self._root.places
        for part in path:
            place = _place(places, part)
            if place is None:
                break
            found.append(place)
            places = place.node.places
        return found


def _place(places: "dict[str, Place] | Sequence[Place] | _LatePlaces", part: str | int) -> Place | None:
    if isinstance(places, _LatePlaces):
        return _place(places.found, part)
    if isinstance(places, dict):
        return places.get(str(part))
    return places[part] if isinstance(part, int) and 0 <= part < len(places) else None


def read_case_text(path: Path) -> str:
    """Text of a case file; FileError if it cannot be read, CaseError if it is not UTF-8, both with its name."""
    with prefixed(path):
        stream = opened(path, CASE_FILE)
    with stream:
        return case_text(stream, str(path))


def read_document(text: str, source: str) -> Document:
    """Data of a case file's text; CaseError, with ``source:line:``, if it is not one YAML 1.2 mapping of plain data."""
    root = _root(text, lambda line: f"{source}:{line}")
    if root is None:
        raise CaseError(f"{source}:1: the file is empty: give at least domain and spacing")
    if not isinstance(root.value, dict):
        raise CaseError(f"{source}:1: a case must be a mapping of keys to values, such as 'spacing: 0.1'")
    return Document(root.value, root)


def read_value(text: str, source: str) -> Any:
    """Value of one line of YAML, such as that of an option, None if empty; errors name the ``source`` only."""
    root = _root(text, lambda line: source, one_line=True)
    return None if root is None else root.value


def value_ahead(text: str, key: str) -> Any:
    """Value of a key of a long text's outermost mapping, read before everything else; None if that is not sure.

    The text before the key is parsed, but no data is made of it, to see that the key is not part of a text or of
    another mapping.
    """
    if len(text) < LONG or not hasattr(LOADER, "raw_parse"):
        return None
    is_flow = text.lstrip()[:1] == "{"
    pattern = rf'(?<=[{{,])\s*"?{key}"?\s*:\s*\{{[^{{}}]*\}}' if is_flow else rf"^{key}:(.*(\n([ #].*)?)*)"
    found = re.search(pattern, text, re.MULTILINE)
    if found is None or len(found[0]) > MAX_AHEAD:
        return None
    before, end = text[: found.start()], "}" if is_flow else ""
    if is_flow and "#" in before[before.rfind("\n") + 1 :]:  # it may be in a comment
        return None
    try:
        LOADER(before + end).raw_parse()
        return read_document("{" * is_flow + found[0] + end, "").data.get(key)
    except (yaml.YAMLError, UnicodeEncodeError, CaseError):  # reading the whole text will report it
        return None


def _root(text: str, place: Callable[[int], str], *, one_line: bool = False) -> Node | None:
    """The outermost node of a text, None if it is empty; lists of numbers are read the fast way if possible.

    Errors in a text of ``one_line`` speak of no others.
    """
    shorter, lists = cut_out(text, _integer)
    if lists:
        with suppress(CaseError):  # reading the usual way reports it, with the true text
            return _Reader(shorter, place, lists).read()
    return _Reader(text, place, one_line=one_line).read()


class _Reader:
    """Builds the nodes of one document from the parser's events.

    ``lists`` of numbers are those for which words stand in the text; CaseError if such a word is not a value.
    """

    def __init__(
        self,
        text: str,
        place: Callable[[int], str],
        lists: Mapping[str, NumberList] | None = None,
        *,
        one_line: bool = False,
    ) -> None:
        self.text = text
        self.place = place
        self.one_line = one_line
        self.lists = lists or {}
        self.anchors: dict[str, Node | None] = {}
        self.brackets = 0  # around the present node
        self.merged = 0  # keys of other mappings so far

    def read(self) -> Node | None:
        try:
            return self._document(yaml.parse(self.text, Loader=LOADER))
        except yaml.MarkedYAMLError as error:
            raise self._syntax_error(error) from None
        except yaml.reader.ReaderError as error:
            line = self.text.count("\n", 0, self.text.find(chr(error.character))) + 1
            found = f"character U+{error.character:04X}"
            is_utf16 = self.text[:2].count("\0") == 1  # of each letter one byte is zero
            advice = "it looks like UTF-16: save it as UTF-8" if is_utf16 else "remove the character"
            raise CaseError(f"{self.place(line)}: not plain text (found {found}): {advice}") from None
        except UnicodeEncodeError as error:
            line = self.text.count("\n", 0, error.start) + 1
            raise CaseError(f"{self.place(line)}: not UTF-8 text: save it as UTF-8") from None

    def _document(self, events: Iterator[Any]) -> Node | None:
        root = None
        documents = 0
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise self._error(event, "a second document starts here: give one document, without '---'")
                root = self._node(next(events), events, 0)
        return root

    def _node(self, event: Any, events: Iterator[Any], depth: int) -> Node:
        """The value that begins with an event, at a depth within others; errors if it is too deep or too large."""
        if isinstance(event, yaml.AliasEvent):
            return self._shared(event, depth)
        if depth > MAX_DEPTH:
            raise self._error(event, TOO_DEEP)
        if event.anchor:
            self.anchors[event.anchor] = None
        if isinstance(event, yaml.ScalarEvent):
            number_list = self.lists.get(event.value)
            node = Node(self._scalar(event)) if number_list is None else self._number_list(event, number_list, depth)
        else:
            self.brackets += event.flow_style
            is_list = isinstance(event, yaml.SequenceStartEvent)
            node = (self._sequence if is_list else self._mapping)(event, events, depth)
            self.brackets -= event.flow_style
        if node.size > MAX_VALUES:
            raise self._error(event, f"more than {MAX_VALUES:,} values, each alias counted in full: use fewer")
        if event.anchor:
            self.anchors[event.anchor] = node
        return node

    def _shared(self, event: Any, depth: int) -> Node:
        if event.anchor not in self.anchors:
            raise self._error(event, f"the alias *{event.anchor} has no anchor &{event.anchor} before it")
        node = self.anchors[event.anchor]
        if node is None:
            raise self._error(event, f"the alias *{event.anchor} is inside its own anchor: write the values out")
        if depth + node.height > MAX_DEPTH:
            raise self._error(event, f"nested more than {MAX_DEPTH} deep through aliases: a case needs far less")
        return node

    def _number_list(self, event: Any, found: NumberList, depth: int) -> Node:
        begins_above = event.start_mark.line < event.end_mark.line  # its anchor is on a line above
        misplaced = begins_above or (found.has_lines and self.brackets > 0)
        if depth + found.height > MAX_DEPTH or event.tag or event.style or misplaced:
            raise self._error(event, "not to be read at once")
        return Node(found.value, _LatePlaces(found.text, event.start_mark.line + 1), found.size, found.height)

    def _sequence(self, start: Any, events: Iterator[Any], depth: int) -> Node:
        self._check_tag(start, "seq")
        places = []
        while not isinstance(event := next(events), yaml.SequenceEndEvent):
            places.append(Place(event.start_mark.line + 1, self._node(event, events, depth + 1)))
        return _collection([place.node.value for place in places], places)

    def _mapping(self, start: Any, events: Iterator[Any], depth: int) -> Node:
        self._check_tag(start, "map")
        places: dict[str, Place] = {}
        others: dict[str, Place] | None = None
        while not isinstance(event := next(events), yaml.MappingEndEvent):
            key, is_merge = self._key(event), _is_merge(event)
            if key in places or (is_merge and others is not None):
                first = f" (first in line {places[key].line})" if key in places else ""
                raise self._error(event, f"the key {key!r} is given twice{first}")
            node = self._node(next(events), events, depth + 1)
            if is_merge:
                others = self._others(event, node)
            else:
                places[key] = Place(event.start_mark.line + 1, node)
        places = {**(others or {}), **places}
        return _collection({key: place.node.value for key, place in places.items()}, places)

    def _others(self, key: Any, node: Node) -> dict[str, Place]:
        """Places of the keys of one mapping, or of a list of them, of which the first one that has a key counts."""
        nodes = [place.node for place in node.places] if isinstance(node.places, list) else [node]
        found: dict[str, Place] = {}
        for other in reversed(nodes):
            if not isinstance(other.places, dict):
                raise self._error(key, "<< takes keys from a mapping, or a list of mappings, as in <<: *name")
            self.merged += len(other.places)  # they are copied, unlike aliases
            if self.merged > MAX_VALUES:
                raise self._error(key, f"more than {MAX_VALUES:,} keys are taken from other mappings: use fewer")
            found |= other.places
        return found

    def _key(self, event: Any) -> str:
        if not isinstance(event, yaml.ScalarEvent):
            raise self._error(event, "a key must be a word: found a list, mapping or alias as the key")
        self._check_text(event)
        self._check_tag(event, "str", *(["merge"] if event.value == MERGE else []))
        return str(event.value)

    def _scalar(self, event: Any) -> Any:
        tag = event.tag
        self._check_text(event)
        if tag is None and event.style:  # Quoted, or a block of text.
            return event.value
        if tag is None:
            return unquoted(event.value)[1]
        if tag in ("!", TAG_PREFIX + "str"):
            return event.value
        found, value = unquoted(event.value)
        self._check_tag(event, found, *(["float"] if found == "int" else []))
        return float(value) if tag == TAG_PREFIX + "float" else value

    def _check_text(self, event: Any) -> None:
        if self.lists and MARK in event.value:
            raise self._error(event, "a list of numbers that is none")
        if "\0" in event.value:
            raise self._error(event, "a null character in a text: remove it")

    def _check_tag(self, event: Any, *allowed: str) -> None:
        if event.tag in (None, "!", *(TAG_PREFIX + kind for kind in allowed)):
            return
        tag = event.tag.replace(TAG_PREFIX, "!!")
        raise self._error(event, f"the tag {tag} does not fit here: remove it; a case is plain data")

    def _error(self, event: Any, problem: str) -> CaseError:
        return CaseError(f"{self.place(event.start_mark.line + 1)}: {problem}")

    def _syntax_error(self, error: yaml.MarkedYAMLError) -> CaseError:
        mark = error.problem_mark
        line = mark.line + 1 if mark else 1
        if mark and _brackets_open_at(self.text, mark.index) > MAX_DEPTH:  # some parsers stop there before we do
            return CaseError(f"{self.place(line)}: {TOO_DEEP}")
        if self.one_line:
            return CaseError(f"{self.place(line)}: not valid YAML: {error.problem}: check brackets, colons and quotes")
        context = ""
        if error.context and error.context_mark:
            context = f", {error.context} that starts in line {error.context_mark.line + 1}"
        advice = "check the indentation (spaces, no tabs), brackets, colons and quotes, here and in the line before"
        return CaseError(f"{self.place(line)}: not valid YAML: {error.problem}{context}: {advice}")


def _is_merge(key: Any) -> bool:
    """Whether the event of a key is that of a merge."""
    return key.value == MERGE and not key.style and key.tag in (None, TAG_PREFIX + "merge")


def _brackets_open_at(text: str, index: int) -> int:
    """Number of brackets and braces that are open at an index of a text."""
    return sum(text.count(left, 0, index) - text.count(right, 0, index) for left, right in ("[]", "{}"))


def _collection(value: Any, places: "dict[str, Place] | list[Place]") -> Node:
    nodes = [place.node for place in (places.values() if isinstance(places, dict) else places)]
    height = 1 + max((node.height for node in nodes), default=0)
    return Node(value, places, 1 + sum(node.size for node in nodes), height)


# Longer integers exceed all floats, and Python refuses to read or write thousands of decimal digits.
MAX_DIGITS = 300
MAX_BITS = 1000


def _integer(text: str) -> int | float:
    return int(text) if len(text) <= MAX_DIGITS else float(text)


def _power_of_two_based(digits: str, base: int) -> int | float:
    """Integer of any number of digits in a base that is a power of two; infinity if it exceeds all floats."""
    value = int(digits, base)
    return value if value.bit_length() <= MAX_BITS else math.inf


# Unlike YAML 1.1: on, yes and no are words, 1e-3 is a number, 010 is ten, 1:30 and 2001-01-01 are text.
PLAIN: tuple[tuple[str, re.Pattern[str], Callable[[str], Any]], ...] = (
    ("null", re.compile(r"|~|null|Null|NULL"), lambda text: None),
    ("bool", re.compile(r"true|True|TRUE"), lambda text: True),
    ("bool", re.compile(r"false|False|FALSE"), lambda text: False),
    ("int", re.compile(r"[-+]?[0-9]+"), _integer),
    ("int", re.compile(r"0o[0-7]+"), lambda text: _power_of_two_based(text[2:], 8)),
    ("int", re.compile(r"0x[0-9a-fA-F]+"), lambda text: _power_of_two_based(text[2:], 16)),
    ("float", re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"), float),
    ("float", re.compile(r"[-+]?\.(inf|Inf|INF)"), lambda text: float(text.replace(".", ""))),
    ("float", re.compile(r"\.(nan|NaN|NAN)"), lambda text: float("nan")),
)


def unquoted(text: str) -> tuple[str, Any]:
    """Kind and value of an unquoted scalar."""
    for kind, pattern, convert in PLAIN:
        if pattern.fullmatch(text):
            return kind, convert(text)
    return "str", text
