"""A batch cut into parts, for job arrays."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self, TypeVar

from bubblemesh.errors import CaseError

T = TypeVar("T")


@dataclass(frozen=True)
class Shard:
    """Part ``index``, from 1, of ``count``."""

    index: int
    count: int

    @classmethod
    def parsed(cls, text: str) -> Self:
        """The shard of a text such as ``3/16``.

        Raises
        ------
        CaseError
            If it is no such text.
        """
        found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text)
        if found is None or not 1 <= int(found[1]) <= int(found[2]):
            raise CaseError(f"--shard {text}: must be a part and the number of parts, from 1/16 to 16/16")
        return cls(int(found[1]), int(found[2]))

    @property
    def suffix(self) -> str:
        """What it adds to the names of the summary's files."""
        return "" if self.count == 1 else f"-{self.index:0{len(str(self.count))}}-of-{self.count}"

    def of(self, entries: Sequence[T]) -> list[T]:
        """Every ``count``-th entry: neighbours, which often take alike, go to different shards."""
        return list(entries[self.index - 1 :: self.count])


WHOLE = Shard(1, 1)
