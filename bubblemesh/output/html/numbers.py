"""Numbers as pages write them."""

from collections.abc import Sequence

__all__ = ["counted", "duration", "place", "whole"]

MINUTE = 60.0


def whole(number: int) -> str:
    """A count with its thousands set apart."""
    return f"{number:,}"


def counted(number: int, noun: str) -> str:
    """A count with its noun: 1 warning, 2 warnings."""
    return f"{whole(number)} {noun}" + ("" if number == 1 else "s")


def duration(seconds: float) -> str:
    """A time in the unit that suits it."""
    if seconds < 1:
        return f"{1000 * seconds:.0f} ms"
    if seconds < MINUTE:
        return f"{seconds:.1f} s"
    return f"{seconds // MINUTE:.0f} min {seconds % MINUTE:.0f} s"


def place(point: Sequence[float]) -> str:
    """A point: (0.5, -1)."""
    return f"({point[0]:.6g}, {point[1]:.6g})"
