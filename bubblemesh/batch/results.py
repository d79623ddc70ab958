"""What a whole batch ends with."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Self

from bubblemesh.batch.events import Event, Finished
from bubblemesh.batch.rows import Row


@dataclass(frozen=True)
class Results:
    """The rows of all cases of a batch, in the order of the cases."""

    rows: tuple[Row, ...]
    unchanged: int

    @classmethod
    def of(cls, events: Iterable[Event]) -> Self:
        """The results, when all events have happened."""
        finished = sorted((event for event in events if isinstance(event, Finished)), key=lambda event: event.number)
        return cls(tuple(event.row for event in finished), sum(event.unchanged for event in finished))

    @property
    def exit_code(self) -> int:
        """0 if every case has its mesh as it should be, else the largest exit code of a case."""
        return max((row.exit_code for row in self.rows), default=0)

    def data(self) -> dict[str, Any]:
        """What ``--json`` prints."""
        failed = sum(row.exit_code != 0 for row in self.rows)
        counts = {"cases": len(self.rows), "failed": failed, "unchanged": self.unchanged}
        return counts | {"exit_code": self.exit_code, "rows": [row.data() for row in self.rows]}
