"""Exception tree: one class for each exit code of the command line."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

DONE, INTERRUPTED = 0, 130  # exit codes without an error of a class
OWN = "", "bubblemesh"  # packages whose missing modules are no libraries that someone could install
OUT_OF_MEMORY = "out of memory: coarsen the spacing, or lower limits.max_nodes to stop earlier"
NODE_LIMIT, COARSEN = "{limit}", "{coarsen}"  # in texts of a `NodeLimitError`


class Key(tuple[str | int, ...]):
    """Path of a key in a case, which messages write with dots."""

    __slots__ = ()

    def __str__(self) -> str:
        return ".".join(map(str, self))


class BubblemeshError(Exception):
    """Base class of every error a user can cause; its text says where it is and what to do."""

    exit_code = 1
    about = Key()  # of the case, if that is known
    where: tuple[str, ...] = ()  # sources, keys and names that stand before the text

    @property
    def text(self) -> str:
        """What is wrong, and what to do."""
        return super().__str__()

    def __str__(self) -> str:
        return ": ".join((*self.where, self.text))

    def prefix(self, place: object) -> None:
        """Put a place before all that the error says."""
        self.where = (str(place), *self.where)


class MeshWarning(UserWarning):
    """Warning of something that a Python program asks for and cannot have, or that is in a file and not read."""


class CaseError(BubblemeshError):
    """The case file, an option or the spacing is invalid."""

    exit_code = 2


class GeometryError(BubblemeshError):
    """The rings do not bound a domain; ``mendable`` says whether a repair of them may help."""

    exit_code = 3

    def __init__(self, text: str, mendable: bool = True) -> None:
        super().__init__(text)
        self.mendable = mendable


class NeighbourError(GeometryError):
    """Neighbours of a file do not share a border; the message names the ``join`` by which they do."""


class RequirementError(BubblemeshError):
    """The mesh was written, but misses a quality that the case requires."""

    exit_code = 4


class FileError(BubblemeshError):
    """A file cannot be read or written."""

    exit_code = 5


class LimitError(BubblemeshError):
    """The case needs more nodes or time than its limit allows."""

    exit_code = 6


class NodeLimitError(LimitError):
    """A mesh needs more nodes than its limit allows.

    What it is made with has `NODE_LIMIT` for the name of the limit, and `COARSEN` for what makes a mesh of fewer nodes:
    that is to coarsen the ``sizes``, unless `coarsened_by` knows better.
    """

    limit = "limits.max_nodes"  # as a case gives it
    advice: str | None = None

    def __init__(self, text: str, sizes: str = "the spacing") -> None:
        super().__init__(text)
        self.sizes = sizes

    @property
    def text(self) -> str:
        """What needs the nodes, and what to do, in words of the case or the call."""
        return super().text.format(limit=self.limit, coarsen=self.advice or f"coarsen {self.sizes}")


def outcome(exit_code: int) -> str:
    """Outcome of a case with this exit code, as batches count it."""
    return {DONE: "done", RequirementError.exit_code: "missed a requirement"}.get(exit_code, "failed")


def missing_library(error: Exception) -> str | None:
    """Advice on a library that is not installed; None for any other error, also for a module of our own.

    Small containers leave out matplotlib, for instance: what draws nothing works without.
    """
    name = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
    return f"{name} is needed for this and not installed: install bubblemesh anew" if name not in OWN else None


@contextmanager
def prefixed(place: object) -> Iterator[None]:
    """Put a place before the texts of errors."""
    try:
        yield
    except BubblemeshError as error:
        error.prefix(place)
        raise


@contextmanager
def about(key: Key) -> Iterator[None]:
    """Note the key of the case that errors are about, unless a more exact one is noted already."""
    try:
        yield
    except BubblemeshError as error:
        error.about = error.about or key
        raise


@contextmanager
def at_key(*path: str | int) -> Iterator[None]:
    """Put the key of the case that errors are about before their texts."""
    try:
        with prefixed(Key(path)):
            yield
    except BubblemeshError as error:
        error.about = Key(path)
        raise


@contextmanager
def coarsened_by(advice: str) -> Iterator[None]:
    """Have errors on too many nodes advise how to get fewer of them, unless they have a more exact advice already."""
    try:
        yield
    except NodeLimitError as error:
        error.advice = error.advice or advice
        raise


@contextmanager
def in_call(call: str, argument: str, node_limit: str) -> Iterator[None]:
    """Put a call before the texts of errors, and the argument that errors of the geometry are about.

    Keys of a case's domain are arguments of their own; errors of the geometry about one name it themselves. What limits
    the number of nodes is called by its argument, ``node_limit``.
    """
    try:
        yield
    except BubblemeshError as error:
        if isinstance(error, NodeLimitError):
            error.limit = node_limit
        if error.about[:1] == ("domain",):
            error.where = tuple(str(Key(error.about[1:])) if it == str(error.about) else it for it in error.where)
        elif isinstance(error, GeometryError):
            error.prefix(error.about or argument)
        error.prefix(call)
        raise


@contextmanager
def located(source: str, place: Callable[[Key], str | None] = lambda key: None) -> Iterator[None]:
    """Put what errors of the case come from before their texts: the file and line of their key, or else the source."""
    try:
        yield
    except BubblemeshError as error:
        if isinstance(error, GeometryError):
            error.prefix("domain")
        error.prefix((place(error.about) if error.about else None) or source)
        raise
