"""Phrases that messages of all parts share."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from difflib import get_close_matches
from math import floor, isfinite, log10
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:  # messages must be written even where NumPy cannot be loaded
    from bubblemesh.arrays import Floats

TOLD_APART = 1e-6  # of a domain's size: places farther from each other are written differently
UNKNOWN = 1e-9  # of a place's own coordinates: likewise where the size is not known
MOST_FINER = 12  # digits that a place may have more, so that it has all that a number holds
FINEST_FIXED, LARGEST_FIXED = 1e-9, 1e15  # steps and numbers that are written without an exponent
MOST_NAMES = 20  # that one message lists
LONGEST_REASON = 200  # letters of what a library says of a file that it cannot read
ALIKE = 0.65  # of 1: a word that is no more like another one is hardly a slip of the pen
NAME = re.compile(r"(?<!\w)'[^']+'(?!\w)")  # in quotes
WIDEST = re.compile(r"the widest(?: gap)? \((\d+(?:\.\d+)?(?:e[-+]?\d+)?)\)")  # of several gaps
NUMBERS = re.compile(r"[-+]?\d+(,\d{3})*(\.\d+)?(e[-+]?\d+)?")

# How places are written depends on the domain of the run. Its size is told by each file that is read, and then by all
# rings together (`Domain.of_areas`); how coordinates were given by its projection, from the beginning
# (`problem.domain`), but where they are not projected yet (`given_coordinates`). Both hold until the run ends, and go
# to workers with their jobs. Places of a mesh as it is written depend on neither: see `place_in_mesh`.
_size: ContextVar[float | None] = ContextVar("size of the domain", default=None)
_given: ContextVar[Callable[[tuple[float, float]], tuple[float, float]] | None] = ContextVar(
    "given places", default=None
)


@contextmanager
def own_places() -> Iterator[None]:
    """Have messages of the block write places as its own domains ask for; those after it as those before it."""
    size, given = _size.set(None), _given.set(None)
    try:
        yield
    finally:
        _size.reset(size)
        _given.reset(given)


class ToldPlaces(NamedTuple):
    """How messages write places: with the digits for a size, and as a function gives them; None for neither."""

    size: float | None
    given: Callable[[tuple[float, float]], tuple[float, float]] | None


def places_now() -> ToldPlaces:
    """How messages write places now, for another process that works on the same domain."""
    return ToldPlaces(_size.get(), _given.get())


@contextmanager
def places_as(told: ToldPlaces) -> Iterator[None]:
    """Have messages of the block write places as another process does."""
    with own_places():
        tell_places_of(told.size)
        tell_places_by(told.given)
        yield


@contextmanager
def given_coordinates() -> Iterator[None]:
    """Have messages of the block write coordinates as they are: in the given system, as data and contents of files."""
    token = _given.set(None if _given.get() is None else lambda point: point)
    try:
        yield
    finally:
        _given.reset(token)


def tell_places_of(size: float | None) -> None:
    """Have messages write places with the digits that a domain of some size needs, or of none that is known yet."""
    _size.set(size)


def tell_places_by(given: Callable[[tuple[float, float]], tuple[float, float]] | None) -> None:
    """Have messages write, for a point, what a function gives for it: its coordinates as the user knows them."""
    _given.set(given)


def place(point: "Floats | Sequence[float]", size: float | None = None, finer: int = 0) -> str:
    """A point as messages, reports and pages write it: (0.5, -1).

    It has as many digits as it takes to tell places in a domain of the ``size``, by default that of the domain that
    messages are about, apart, and ``finer`` more.
    """
    given = _given.get()
    x, y = float(point[0]), float(point[1])
    if given is not None and isfinite(x) and isfinite(y):
        return "({}, {})".format(*(_given_coordinate(value, finer) for value in given((x, y))))
    known = size or _size.get() or UNKNOWN / TOLD_APART * max(abs(x), abs(y))
    return place_in_mesh((x, y), known / 10**finer)


def place_in_mesh(point: "Floats | Sequence[float]", size: float) -> str:
    """A point of a mesh of the size, in the coordinates in which this is written, whatever was given: (0.5, -1)."""
    return f"({coordinate(float(point[0]), size)}, {coordinate(float(point[1]), size)})"


def _given_coordinate(value: float, finer: int) -> str:
    """A coordinate of a place on the earth: a degree to about a metre, a length of metres to a tenth of one."""
    if abs(value) >= LARGEST_FIXED:
        return f"{value:g}"
    return f"{value:.{max(6, len(str(int(abs(value)))) + 1) + finer}g}"


def two_places(first: "Floats | Sequence[float]", second: "Floats | Sequence[float]") -> tuple[str, str]:
    """Two points that one message names, each as a `place`, with as many digits as it takes to tell them apart."""
    pairs = ((place(first, finer=finer), place(second, finer=finer)) for finer in range(MOST_FINER))
    return next((pair for pair in pairs if pair[0] != pair[1]), (place(first), place(second)))


def coordinate(value: float, size: float) -> str:
    """A coordinate of a `place`."""
    apart = TOLD_APART * size
    if not (isfinite(value) and isfinite(apart) and apart > 0):
        return f"{value:g}"
    exponent = floor(log10(apart))
    if exponent >= log10(FINEST_FIXED) and abs(value) < LARGEST_FIXED:
        text = f"{round(value, -exponent):.{max(-exponent, 0)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
        return "0" if text == "-0" else text
    digits = floor(log10(abs(value))) - exponent + 1 if value else 1
    return f"{value:.{min(digits, 17)}g}" if digits > 0 else "0"


def extent(bounds: Sequence[float]) -> str:
    """A box (x0, y0, x1, y1) as messages write it: [0, 2] x [-1, 1]."""
    x0, y0, x1, y1 = bounds
    return f"[{x0:.6g}, {x1:.6g}] x [{y0:.6g}, {y1:.6g}]"


def once_each(texts: Iterable[str]) -> tuple[str, ...]:
    """The first of all texts that differ in nothing but numbers and places, with the count and names of the others.

    Of texts that tell the widest of some gaps it is the one with the widest of all.
    """
    kinds: dict[str, list[str]] = {}
    for text in texts:
        kinds.setdefault(NUMBERS.sub("#", text), []).append(text)
    told = (sorted(some, key=_widest, reverse=True) for some in kinds.values())
    return tuple(first if not others else f"{first} {_more(first, others)}" for first, *others in told)


def _widest(text: str) -> float:
    found = WIDEST.search(text)
    return float(found[1]) if found else 0.0


def _more(first: str, others: Sequence[str]) -> str:
    names = dict.fromkeys(name for text in others for name in NAME.findall(text) if name not in first)
    return f"(and {len(others):,} more like it{f': {listed([*names])}' if names else ''})"


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


def run_seconds(seconds: Mapping[str, float]) -> float:
    """Time of a run as terminal, page and summary tell it alike: of all stages but that of the page itself."""
    return seconds["total"] - seconds.get("page", 0.0)


def just_above(width: float) -> str:
    """A number of two digits that is a little more than the width, as the value of a key that messages advise."""
    return f"{float(f'{1.05 * width:.1e}') + 10.0 ** (floor(log10(width)) - 1):.2g}"


def either(words: Sequence[str]) -> str:
    """Words of which one counts: a, b or c."""
    return " or ".join([*([", ".join(words[:-1])] if len(words) > 1 else []), *words[-1:]])


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known word that ``word`` may mean: one of the same letters, one alike, or the only one that begins so."""
    words = list(known)
    same = [one for one in words if one.casefold() == word.casefold()]
    longer = [one for one in words if word and one.startswith(word)]
    alike = get_close_matches(word, words, n=1, cutoff=ALIKE)
    return next(iter(same or alike or longer[: len(longer) == 1]), None)


def listed(words: Sequence[str], most: int = MOST_NAMES) -> str:
    """Words one after the other, of very many the first: a, b, c and 7 more."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return f"{', '.join(words[:most])}{more}"


def with_labels(labels: Sequence[str]) -> str:
    """End of a note on what is left out: the labels that are lost with it; empty if there are none."""
    return f", and with them {counted(len(labels), 'label')}: {listed([*map(repr, labels)])}" if labels else ""


def meant(word: str, known: Iterable[str]) -> str:
    """The known word that ``word`` may mean, or all of them."""
    words = list(known)
    close = closest(word, words)
    return f"allowed: {', '.join(words)}" if close is None else f"did you mean {close!r}?"


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


def cause(error: Exception, most: int = 60) -> str:
    """An error of another program as the cause of a fault, in one line; in plain words if it has no text."""
    ends = isinstance(error, EOFError | StopIteration)
    return shown(error, most) or ("it ends too early" if ends else "it is not as its format asks for")


def unknown(what: str, name: str, known: Iterable[str], most: int = MOST_NAMES) -> str:
    """Message on a name that nothing has, with the names that there are, of very many the first."""
    names = list(known)
    close = closest(name, names)
    hint = "" if close is None else f"did you mean {close!r}? "
    return f"unknown {what} {name!r}; {hint}known: {listed(names, most)}"
