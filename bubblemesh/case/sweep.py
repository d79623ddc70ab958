"""A file that stands for several cases: ``sweep: {packing.w2: [0.5, 0.6, 0.7]}``."""

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

Places = Callable[[Sequence[str | int]], str]


class SweepError(CaseError):
    """A file with a sweep is taken for one case."""


@record
class Variant:
    """A case of a file, one of several where it has a sweep."""

    label: str = ""  # that the file's name gets for the case, such as -w2=0.5-h=0.1; empty if the file is one case
    values: tuple[tuple[str, Any], ...] = ()  # key, such as packing.w2, and value of all that is swept
    files: tuple[SourceFile, ...] = field(default=(), compare=False, repr=False)  # that it was read from, if known


ALONE = Variant()


def variants_of(sweep: Any, place: Places) -> list[Variant]:
    """All combinations of the values that a sweep gives its keys, those of the last key changing fastest.

    Values are a list, or a range: ``{from, to, step}`` or ``{from, to, count}``. A key without values or that cannot be
    swept, two keys that set the same thing, a value that is there twice, and too many cases are a CaseError, with the
    file and line that ``place`` gives for a key path.
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


def path_of(key: str) -> tuple[str, ...]:
    """The parts of a key such as ``packing.w2``."""
    return tuple(part.strip() for part in key.split("."))


def _require_apart(keys: Sequence[str], place: Places) -> None:
    """Check that no key is another one, or a part of what another one sets: the one would undo the other."""
    for first, second in combinations(keys, 2):
        pairs = zip(_numbered(first), _numbered(second), strict=False)
        if all(one == other for one, other in pairs):
            raise CaseError(
                f"{place(['sweep', second])}: sweep: {first} and {second} set the same thing: keep one of them"
            )


def _numbered(key: str) -> list[str | int]:
    """The parts of a key, with numbers for those of list entries: 0 and 00 are one."""
    return [int(part) if part.isascii() and part.isdigit() else part for part in path_of(key)]


def _example(sweep: object) -> str:
    return f"write packing.w2: [0.6, 0.7] (found {described(sweep)})"


def _listed(values: Any) -> Any:
    """The values of a range, and others as they are; CaseError if the range is none.

    Steps are taken in decimals as they are written: three of 0.1 are 0.3.
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
    if not all(path_of(key)):
        return "has an empty part: write key.key"
    if path_of(key)[0] in OWN_KEYS:
        return f"cannot be swept: a sweep keeps {', '.join(OWN_KEYS)}"
    seen = set()
    for value in values:
        if _identity(value) in seen:
            return f"{described(value)} is there twice: every case needs values of its own"
        seen.add(_identity(value))
    return None


def _identity(value: Any) -> tuple[bool, Any]:
    """Key that equal values share: 1 and 1.0 do, 1 and true do not."""
    return isinstance(value, bool), repr(value) if isinstance(value, list | dict) else value


def _combinations(sweep: Mapping[str, list[Any]]) -> Iterator[Variant]:
    names = _short(list(sweep))
    words = [_words(values) for values in sweep.values()]
    for chosen in product(*(range(len(values)) for values in sweep.values())):
        parts = [f"-{name}={of_key[k]}" for name, of_key, k in zip(names, words, chosen, strict=True)]
        values = [(key, values[k]) for (key, values), k in zip(sweep.items(), chosen, strict=True)]
        yield Variant("".join(parts), tuple(values))


def _short(keys: Sequence[str]) -> list[str]:
    """The end of each key that no other key has."""
    parts = [key.split(".") for key in keys]
    longest = max(map(len, parts))
    for length in range(1, longest + 1):
        names = [".".join(part[-length:]) for part in parts]
        if len(set(names)) == len(names):
            break
    return names


def _words(values: Sequence[Any]) -> list[str]:
    """A word for each value that file names may have: the value, or its number if the values are not that simple."""
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
