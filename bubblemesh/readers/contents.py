"""Contents of files, which are parsed once while a domain is read."""

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from bubblemesh.readers.features import FeatureCollection

_kept: ContextVar[dict[Hashable, FeatureCollection] | None] = ContextVar("contents", default=None)


@contextmanager
def contents_kept() -> Iterator[None]:
    """Within the block, parse each file once, however often it is read for the same features."""
    token = _kept.set({})
    try:
        yield
    finally:
        _kept.reset(token)


def parsed_once(key: Hashable, parse: Callable[[], FeatureCollection]) -> FeatureCollection:
    """The content that is kept under a key; else what parsing the file returns, which is kept then."""
    contents = {} if (kept := _kept.get()) is None else kept
    if key not in contents:
        contents[key] = parse()
    return contents[key]
