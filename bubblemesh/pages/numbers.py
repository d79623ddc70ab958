"""Numbers as pages write them."""

from collections.abc import Sequence


def whole(number: int) -> str:
    """A count with its thousands set apart."""
    return f"{number:,}"


def counted(number: int, noun: str) -> str:
    """A count with its noun: 1 warning, 2 warnings."""
    return f"{whole(number)} {noun}" + ("" if number == 1 else "s")


def place(point: Sequence[float]) -> str:
    """A point: (0.5, -1)."""
    return f"({point[0]:.6g}, {point[1]:.6g})"
