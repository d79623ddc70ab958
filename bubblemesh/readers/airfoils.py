"""Outlines of airfoils as programs list them: Selig's, Lednicer's and those of XFOIL and MSES."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from bubblemesh.errors import CaseError
from bubblemesh.geometry.paths import Point

SEPARATORS = (999.0, 999.9, 999.99, 9999.0)  # x and y of a line that separates the elements
FAR = 100  # coordinate of a point from which on such lines are points like others
DOMAIN = (4, 5)  # numbers in a line of MSES, before the points: the box around the flow


class NumberRows(NamedTuple):
    """Rows of numbers without a blank line or words between them, and the line of the first."""

    line: int
    rows: list[list[float]]


def airfoil_outlines(blocks: Sequence[NumberRows]) -> tuple[list[NumberRows], list[str]]:
    """Blocks with one outline each, and notes on the format that was found; other lists of points stay as they are.

    CaseError if the numbers of points that a file of Lednicer gives do not fit.
    """
    notes: list[str] = []
    blocks = _without_domain(list(blocks), notes)
    blocks = _parted(blocks, notes)
    return _surfaces_joined(blocks, notes), notes


def _without_domain(blocks: list[NumberRows], notes: list[str]) -> list[NumberRows]:
    """The blocks without the first line of MSES, the only one with more than two numbers."""
    lengths = [len(row) for block in blocks for row in block.rows]
    if len(lengths) < 4 or lengths[0] not in DOMAIN or set(lengths[1:]) != {2}:
        return blocks
    notes.append(f"line {blocks[0].line} is taken as the box of MSES around the flow, and not used")
    rest = NumberRows(blocks[0].line + 1, blocks[0].rows[1:])
    return [block for block in (rest, *blocks[1:]) if block.rows]


def _parted(blocks: list[NumberRows], notes: list[str]) -> list[NumberRows]:
    """The blocks, divided at lines such as 999.9 999.9 that are far from all other points."""

    def parts(row: list[float]) -> bool:
        return row[0] == row[1] and row[0] in SEPARATORS

    rows = [row for block in blocks for row in block.rows]
    others = [abs(value) for row in rows if not parts(row) for value in row[:2]]
    if len(others) == 2 * len(rows) or max(others, default=FAR) >= FAR:
        return blocks
    notes.append("lines such as 999.9 999.9 are taken as ends of elements")
    found: list[NumberRows] = []
    for block in blocks:
        begin = 0
        for k, row in enumerate([*block.rows, [SEPARATORS[0]] * 2]):
            if parts(row):
                found += [NumberRows(block.line + begin, block.rows[begin:k])] if k > begin else []
                begin = k + 1
    return found


def _surfaces_joined(blocks: list[NumberRows], notes: list[str]) -> list[NumberRows]:
    """The blocks, or one outline of an upper and a lower surface, each from the leading to the trailing edge."""
    rows = [row for block in blocks for row in block.rows]
    counts = rows[0][:2] if rows else [0.0, 0.0]
    if len(rows) > 4 and all(value >= 2 and value.is_integer() for value in counts):
        upper, lower = int(counts[0]), int(counts[1])
        if len(rows) - 1 == upper + lower:
            notes.append(f"line {blocks[0].line} is taken as the numbers of points of the upper and the lower surface")
            return [NumberRows(blocks[0].line, _around(rows[1 : 1 + upper], rows[1 + upper :]))]
        if max(abs(value) for row in rows[1:] for value in row[:2]) <= 2 < min(counts):
            raise CaseError(
                f"line {blocks[0].line} gives {upper} and {lower} points of an upper and a lower surface, but there "
                f"are {len(rows) - 1}: correct the numbers, or put # before the line if it is a header"
            )
    starts = [block.rows[0][:2] for block in blocks]
    if len(blocks) == 2 and starts[0] == starts[1] and all(_is_surface(block.rows) for block in blocks):
        notes.append("two lists from one point on are taken as the upper and the lower surface of one outline")
        return [NumberRows(blocks[0].line, _around(blocks[0].rows, blocks[1].rows))]
    return blocks


def _is_surface(rows: list[list[float]]) -> bool:
    """Whether points run in one direction along x."""
    return len(rows) > 2 and all(a[0] < b[0] for a, b in pairwise(rows))


def _around(upper: list[list[float]], lower: list[list[float]]) -> list[list[float]]:
    """Points from the trailing edge along the upper surface, and back along the lower one."""
    return [*upper[::-1], *(lower[1:] if upper[0][:2] == lower[0][:2] else lower)]


def points_of_rows(block: NumberRows) -> list[Point]:
    """The first two numbers of each row."""
    return [(row[0], row[1]) for row in block.rows]
