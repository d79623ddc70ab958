"""Files with several cases: ``sweep: {packing.w2: [0.5, 0.6, 0.7]}``."""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from fractions import Fraction
from itertools import combinations, product
from math import prod
from typing import Any

from bubblemesh.case.bases import OWN_KEYS, SourceFile
from bubblemesh.case.fields import described
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.records import record

MAX_CASES = 100_000

RANGE = ("from", "to")

SHOWABLE = re.compile(r"[A-Za-z0-9_.+-]{1,24}")

PlaceOf = Callable[[Sequence[str | int]], str]


class SweepError(CaseError):
    """A file with a sweep is used as if it were one case."""


@record
class Variant:
    """The case of a file, or one of its cases if it has a sweep."""

    label: str = ""  # suffix to the file's name, such as -w2=0.5-h=0.1; empty if the file has one case
    values: tuple[tuple[str, Any], ...] = ()  # swept keys, such as packing.w2, and their values
    files: tuple[SourceFile, ...] = field(default=(), compare=False, repr=False)  # from which it was read, if known


ALONE = Variant()


def variants_of(sweep: Any, place: PlaceOf) -> list[Variant]:
    """All combinations of the values that a sweep gives its keys; those of the last key change fastest.

    Values are a list, or a range: ``{from, to, step}`` or ``{from, to, count}``. ``place`` returns file and line of a
    key path, for messages.

    Raises
    ------
    CaseError
        If a key has no values or cannot be swept, two keys set the same thing, a value is there twice, or there are too
        many cases.
    """
    if sweep is None:
        return [ALONE]
    if not isinstance(sweep, Mapping) or not sweep:
        raise CaseError(f"{place(['sweep'])}: sweep: must be a mapping of keys to lists of values: {_example(sweep)}")
    lists: dict[str, list[Any]] = {}
    for key, values in sweep.items():
        with prefixed(f"{place(['sweep', key])}: sweep.{key}"):
            lists[key] = _listed(values)
            if problem := _problem(key, lists[key]):
                raise CaseError(problem)
    _require_apart(list(lists), place)
    count = prod(map(len, lists.values()))
    if count > MAX_CASES:
        raise CaseError(f"{place(['sweep'])}: sweep: makes {count:,} cases, more than {MAX_CASES:,}: list fewer values")
    return list(_combinations(lists))


def key_parts(key: str) -> tuple[str, ...]:
    """The parts of a key such as ``packing.w2``."""
    return tuple(part.strip() for part in key.split("."))


def _require_apart(keys: Sequence[str], place: PlaceOf) -> None:
    """Check that no key is equal to another one or within it: one would replace the value of the other."""
    for first, second in combinations(keys, 2):
        pairs = zip(_numbered(first), _numbered(second), strict=False)
        if all(one == other for one, other in pairs):
            raise CaseError(
                f"{place(['sweep', second])}: sweep: {first} and {second} set the same thing: keep one of them"
            )


def _numbered(key: str) -> list[str | int]:
    """The parts of a key, with integers for indices of lists, as 0 and 00 are the same."""
    return [int(part) if part.isascii() and part.isdigit() else part for part in key_parts(key)]


def _example(sweep: object) -> str:
    return f"write packing.w2: [0.6, 0.7] (found {described(sweep)})"


def _listed(values: Any) -> Any:
    """The values of a range; other values as they are. CaseError if the range is invalid.

    Steps are added as decimal numbers: three steps of 0.1 are exactly 0.3.
    """
    if not isinstance(values, Mapping) or "from" not in values:
        return values
    if {*values} not in ({*RANGE, "step"}, {*RANGE, "count"}):
        raise CaseError(f"must have from, to, and either step or count (found {described(values)})")
    for name, value in values.items():
        if type(value) not in (int, float) or not math.isfinite(value):
            raise CaseError(f"{name} must be a finite number (found {described(value)})")
    start, end = (Fraction(repr(values[name])) for name in RANGE)
    if "step" in values:
        step = Fraction(repr(values["step"]))
        if step == 0 or (end - start) / step < 0:
            raise CaseError(f"step must lead from {values['from']} to {values['to']} (found {values['step']})")
        count = (end - start) // step + 1
    else:
        count = values["count"]
        if type(count) is not int or count < 2 or start == end:
            raise CaseError(f"count must be a whole number of 2 at least, from one number to another (found {count})")
        step = (end - start) / (count - 1)
    if count > MAX_CASES:
        raise CaseError(f"makes {count:,} values, more than {MAX_CASES:,}: take larger steps")
    return [_plain(start + k * step) for k in range(count)]


def _plain(number: Fraction) -> int | float:
    return int(number) if number.denominator == 1 else float(number)


def _problem(key: str, values: Any) -> str | None:
    """Fault of a key and its values, if they have one."""
    if isinstance(values, Mapping) and values:
        inner = next(iter(values))
        return f"must be a list of values, or a range: write the key in one word, {key}.{inner}: [...]"
    if not isinstance(values, list) or not values:
        return f"must be a list of values (found {described(values)}), or a range {{from: 0, to: 1, step: 0.1}}"
    if not all(key_parts(key)):
        return "has an empty part: write key.key"
    if key_parts(key)[0] in OWN_KEYS:
        return f"cannot be swept: a sweep keeps {', '.join(OWN_KEYS)}"
    seen = set()
    for value in values:
        if _identity(value) in seen:
            return f"{described(value)} is there twice: every case needs values of its own"
        seen.add(_identity(value))
    return None


def _identity(value: Any) -> tuple[bool, Any]:
    """Key that is the same for equal values: 1 and 1.0 are equal, 1 and true are not."""
    return isinstance(value, bool), repr(value) if isinstance(value, list | dict) else value


def _combinations(sweep: Mapping[str, list[Any]]) -> Iterator[Variant]:
    names = _short(list(sweep))
    words = [_words(values) for values in sweep.values()]
    for chosen in product(*(range(len(values)) for values in sweep.values())):
        parts = [f"-{name}={of_key[k]}" for name, of_key, k in zip(names, words, chosen, strict=True)]
        values = [(key, values[k]) for (key, values), k in zip(sweep.items(), chosen, strict=True)]
        yield Variant("".join(parts), tuple(values))


def _short(keys: Sequence[str]) -> list[str]:
    """The shortest end of each key that no other key has."""
    parts = [key.split(".") for key in keys]
    longest = max(map(len, parts))
    for length in range(1, longest + 1):
        names = [".".join(part[-length:]) for part in parts]
        if len(set(names)) == len(names):
            break
    return names


def _words(values: Sequence[Any]) -> list[str]:
    """A word for each value, fit for file names: the value, or its number if the values are not that simple."""
    words = [_word(value) for value in values]
    simple = all(map(SHOWABLE.fullmatch, words)) and len({word.lower() for word in words}) == len(words)
    return words if simple else [str(number) for number in range(1, len(values) + 1)]


def _word(value: Any) -> str:
    match value:
        case None:
            return "null"
        case bool():
            return str(value).lower()
        case int() | float() | str():
            return str(value)
    return ""
