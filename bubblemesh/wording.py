"""Phrases that messages of all parts share."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches

from bubblemesh.arrays import Floats

__all__ = ["meant", "place", "ring_name", "unknown"]

MOST_NAMES = 20  # that one message lists


def place(point: Floats | Sequence[float]) -> str:
    """A point as messages write it: (0.5, -1)."""
    return f"({point[0]:.6g}, {point[1]:.6g})"


def meant(word: str, known: Iterable[str]) -> str:
    """The known word that ``word`` may mean, or all of them."""
    words = list(known)
    close = get_close_matches(word, words, n=1)
    return f"did you mean {close[0]!r}?" if close else f"allowed: {', '.join(words)}"


def ring_name(number: int) -> str:
    """What messages call a ring."""
    return "the outer ring" if number == 0 else f"hole {number}"


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """Message on a name that nothing has, with the names that there are."""
    names = list(known)
    close = get_close_matches(name, names, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return f"unknown {what} {name!r}; {hint}known: {', '.join(names[:MOST_NAMES])}{more}"
