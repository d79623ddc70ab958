"""Where the keys of a case stand, for errors that only its geometry or another file brings to light."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

__all__ = ["Origin"]


@dataclass(frozen=True)
class Origin:
    """Files and lines of some keys, or the options that set them; cases are equal wherever they come from."""

    places: Mapping[tuple[str | int, ...], str] = field(default_factory=dict, compare=False)

    def __call__(self, key: Sequence[str | int]) -> str | None:
        """Place of a key, or of the nearest one above it, if any is known."""
        known = (self.places.get(tuple(key[:depth])) for depth in range(len(key), 0, -1))
        return next((place for place in known if place is not None), None)
