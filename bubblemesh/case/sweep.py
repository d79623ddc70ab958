"""A file that stands for several cases: ``sweep: {packing.w2: [0.5, 0.6, 0.7]}``."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from math import prod
from typing import Any

from bubblemesh.case.bases import OWN_KEYS, SourceFile
from bubblemesh.case.fields import described
from bubblemesh.errors import CaseError

MAX_CASES = 100_000

SHOWABLE = re.compile(r"[A-Za-z0-9_.+-]{1,24}")

Places = Callable[[Sequence[str | int]], str]


@dataclass(frozen=True)
class Variant:
    """One case of a file."""

    label: str = ""  # that the file's name gets for the case, such as -w2=0.5-h=0.1; empty if the file is one case
    values: tuple[tuple[str, Any], ...] = ()  # key, such as packing.w2, and value of all that is swept
    files: tuple[SourceFile, ...] = field(default=(), compare=False, repr=False)  # that it was read from, if known


ALONE = Variant()


def variants_of(sweep: Any, place: Places) -> list[Variant]:
    """All combinations of the values that a sweep lists for its keys, those of the last key changing fastest.

    A key that has no list of values or cannot be swept, two keys that set the same thing, a value that is there twice,
    and too many cases are a CaseError, with the file and line that ``place`` gives for a key path.
    """
    if sweep is None:
        return [ALONE]
    if not isinstance(sweep, Mapping) or not sweep:
        raise CaseError(f"{place(['sweep'])}: sweep: must be a mapping of keys to lists of values: {_example(sweep)}")
    for key, values in sweep.items():
        problem = _problem(key, values)
        if problem:
            raise CaseError(f"{place(['sweep', key])}: sweep.{key}: {problem}")
    _require_apart(list(sweep), place)
    count = prod(map(len, sweep.values()))
    if count > MAX_CASES:
        raise CaseError(f"{place(['sweep'])}: sweep: makes {count:,} cases, more than {MAX_CASES:,}: list fewer values")
    return list(_combinations(sweep))


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


def _problem(key: str, values: Any) -> str | None:
    """Fault of a key and its values, if they have one."""
    if isinstance(values, Mapping) and values:
        inner = next(iter(values))
        return f"must be a list of values: write the key in one word, {key}.{inner}: [...]"
    if not isinstance(values, list) or not values:
        return f"must be a list of values (found {described(values)})"
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
