"""Phrases that messages of all parts share."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # messages must be written even where NumPy cannot be loaded
    from bubblemesh.arrays import Floats

FAR = 1e4  # six digits do not tell a place in a domain of any size
MOST_NAMES = 20  # that one message lists


def place(point: "Floats | Sequence[float]") -> str:
    """A point as messages write it: (0.5, -1); far from the origin with more digits."""
    x, y = (f"{value:.6g}" if abs(value) < FAR else f"{value:.12g}" for value in (float(point[0]), float(point[1])))
    return f"({x}, {y})"


def counted(number: int, noun: str) -> str:
    """A count with its noun: no holes, 1 hole, 2,000 holes."""
    return f"{number:,} {noun}" if number == 1 else f"{f'{number:,}' if number else 'no'} {noun}s"


def duration(seconds: float) -> str:
    """A time in the unit that suits it: 30 ms, 2.5 s, 3 min 20 s, 2 h 5 min."""
    if seconds < 0.9995:
        return f"{1000 * seconds:.0f} ms"
    if seconds < 59.95:
        return f"{seconds:.3g} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return "{} h {} min".format(*divmod(round(seconds / 60), 60))


def meant(word: str, known: Iterable[str]) -> str:
    """The known word that ``word`` may mean, or all of them."""
    words = list(known)
    close = get_close_matches(word, words, n=1)
    return f"did you mean {close[0]!r}?" if close else f"allowed: {', '.join(words)}"


def ring_name(number: int, origin: str | None = None, areas: int = 1) -> str:
    """Name of a ring in messages, with the place in a file it comes from; the outer rings of all areas go first."""
    outer = "the outer ring" if areas == 1 else f"outer ring {number + 1}"
    name = outer if number < areas else f"hole {number - areas + 1}"
    return name if origin is None else f"{name} ({origin})"


def printable(text: str) -> str:
    r"""Text with an escape, such as \x1b, for each character that steers a terminal or shows nothing; lines stay."""
    if text.isprintable():  # as nearly all are, of very many
        return text
    return "".join(letter if letter.isprintable() or letter == "\n" else ascii(letter)[1:-1] for letter in text)


def shown(text: object, most: int = 60) -> str:
    """Text of another program or a file as messages show it: in one line, printable and not too long."""
    letters = (letter if letter.isprintable() else " " if letter.isspace() else "?" for letter in str(text))
    line = " ".join("".join(letters).split())
    return line if len(line) <= most else f"{line[: most - 3]}..."


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """Message on a name that nothing has, with the names that there are."""
    names = list(known)
    close = get_close_matches(name, names, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return f"unknown {what} {name!r}; {hint}known: {', '.join(names[:MOST_NAMES])}{more}"
