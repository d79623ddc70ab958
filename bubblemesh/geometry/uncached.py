"""Pickles of a domain for other processes, without what is cached in it."""

from dataclasses import fields
from typing import Any, cast


class Uncached:
    """A dataclass that travels without what it has cached: prepared shapes would come as mere shapes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple(getattr(self, field.name) for field in fields(cast(Any, self)))
