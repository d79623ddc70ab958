"""What the paper prints, as data."""

from dataclasses import dataclass
from typing import NamedTuple

REFERENCE = "table-4"  # the run that the paper compares most others with


@dataclass(frozen=True)
class Row:
    """One row of a table: its case below configs/paper, and the printed figures where there are any.

    ``seconds`` are the paper's own; only their ratios mean anything here. ``note`` says why a row is not reproduced.
    """

    case: str
    label: str
    seconds: float | None = None
    initial: int | None = None
    final: int | None = None
    quality: float | None = None
    rounds: int | None = None
    note: str = ""


@dataclass(frozen=True)
class Table:
    """A table, the costs of which refer to its first row; ``name`` is how the paper counts it, if it does."""

    name: str
    title: str
    rows: tuple[Row, ...]
    final_tolerance: float = 0.01


@dataclass(frozen=True)
class Comparison:
    """Two rows, by their cases, and by how much the ``dear`` one is said to be dearer, or the ``cheap`` one cheaper."""

    label: str
    dear: str
    cheap: str
    claim: float


class State(NamedTuple):
    """A row of Table 4; ``iterations`` and ``seconds`` count from the start."""

    iterations: int
    seconds: float
    nodes: int
    triangles: int
    quality: float

    @property
    def boundary_nodes(self) -> int:
        """Nodes on the boundary, of a domain without holes: what Euler's formula leaves."""
        return 2 * self.nodes - 2 - self.triangles


NEARLY_THE_SAME_START = "its start has 16 boundary nodes less than that of w1 = 1, too few to matter here"
SAME_END = "our population settles where that of the other rows does"
NO_CROWD = "it starts next to the ideal number and stays there"

TABLES = (
    Table(
        "2",
        "Table 2: boundary weight w1 (Example 3, FNPBS)",
        (
            Row("table-2/w1-1", "w1 = 1", 187.156, 1420, 712, rounds=10),
            Row("table-2/w1-0.8", "w1 = 0.8", 463.609, 1404, 780, rounds=10, note=NEARLY_THE_SAME_START),
            Row("table-2/w1-0.9", "w1 = 0.9", 421.422, 1404, 752, rounds=10, note=NEARLY_THE_SAME_START),
            Row("table-2/w1-1.2", "w1 = 1.2", 192.903, 1432, 715, rounds=10, note="other counts follow the same rule"),
            Row("table-2/w1-1.5", "w1 = 1.5", 198.813, 1460, 720, rounds=10, note=SAME_END),
            Row("table-2/w1-2", "w1 = 2", 278.859, 1508, 694, rounds=10, note=SAME_END),
        ),
    ),
    Table(
        "3",
        "Table 3: interior weight w2 (Example 3, FNPBS)",
        (
            Row("table-3/w2-1", "w2 = 1", 187.156, 1420, 712, rounds=10),
            Row("table-3/w2-0.8", "w2 = 0.8", 116.469, 1139, 711, rounds=10),
            Row("table-3/w2-0.7", "w2 = 0.7", 99.328, 983, 707, rounds=10),
            Row("table-3/w2-0.6", "w2 = 0.6", 91.515, 826, 707, 0.9525, rounds=10),
            Row("table-3/w2-0.57", "w2 = 0.57", 215.093, 660, 655, rounds=10, note=NO_CROWD),
        ),
    ),
    Table(
        "2.2",
        "Section 2.2, first table: odd bubbles on Example 3 (FNPBS)",
        (
            Row("section-2.2/coarse-without", "without", 187.156, 1420, 712, rounds=10),
            Row("section-2.2/coarse-with", "with odd bubbles", 194.594, 1420, 709),
        ),
    ),
    Table(
        "2.2",
        "Section 2.2, second table: odd bubbles on the dense variant (FNPBS)",
        (
            Row("section-2.2/dense-without", "without", 19.61, 1822, 1602),
            Row("section-2.2/dense-with", "with odd bubbles", 9.15, 1822, 1598, 0.9425),
        ),
    ),
    Table(
        "methods",
        "Traditional method against FNPBS (Example 3)",
        (
            Row("table-4", "FNPBS", 187.156, 1420, 712, 0.9435, rounds=10),
            Row("table-1", "BPM", 300.719, 1420, None, 0.9558),
        ),
    ),
    Table(
        "5",
        "Table 5, Example 1: uniform rectangle",
        (
            Row("table-5/example-1-fnpbs", "FNPBS", 154.094, quality=0.9626, rounds=10),
            Row("table-5/example-1-accelerated", "accelerated", 108.406, quality=0.9532, rounds=6),
        ),
    ),
    Table(
        "5",
        "Table 5, Example 2: square with a hole",
        (
            Row("table-5/example-2-fnpbs-4-rounds", "FNPBS, 4 rounds", 82.125, None, 587, 0.9087, rounds=4),
            Row("table-5/example-2-fnpbs-adaptive", "FNPBS, self-adaptive", 102.765, quality=0.9396, rounds=5),
            Row("table-5/example-2-fnpbs", "FNPBS, 10 rounds"),
            Row("table-5/example-2-accelerated", "accelerated", 11.0, quality=0.9564, rounds=4),
        ),
        final_tolerance=0.05,
    ),
    Table(
        "5",
        "Table 5, Example 3: locally dense square",
        (
            Row("table-5/example-3-fnpbs", "FNPBS", 187.156, 1420, 712, 0.9435, rounds=10),
            Row("table-5/example-3-accelerated", "accelerated", 29.375, 826, 707, 0.9453, rounds=3),
        ),
    ),
    Table(
        "5",
        "Table 5, Example 4: bitten half disc",
        (
            Row("table-5/example-4-fnpbs", "FNPBS", 117.828, quality=0.9407),
            Row("table-5/example-4-accelerated", "accelerated", 30.266, quality=0.9362, rounds=5),
        ),
    ),
)

ROWS = {row.case: row for table in TABLES for row in table.rows}

# The state after each round, the initial one first.
TABLE_4 = (
    State(0, 0.0, 1420, 2758, 0.9742),
    State(250, 56.953, 1202, 2339, 0.8562),
    State(500, 93.578, 1013, 1963, 0.8268),
    State(750, 115.625, 847, 1631, 0.8230),
    State(1000, 129.156, 748, 1434, 0.8650),
    State(1250, 138.813, 726, 1391, 0.9052),
    State(1500, 147.438, 721, 1381, 0.9231),
    State(1750, 155.938, 716, 1371, 0.9286),
    State(2000, 164.313, 714, 1367, 0.9351),
    State(2250, 172.719, 712, 1363, 0.9392),
    State(2750, 187.156, 712, 1363, 0.9435),
)

# What Table 4 depends on: its case with one thing changed, none first.
VARIANTS = {
    REFERENCE: "as above",
    "table-4/own-step": "scaled force, time step 0.2: the methods' own",
    "table-4/apart-1.2": "deletions 1.2 d apart, not 1.21",
    "table-4/above-7.9": "deletion above 7.9, not 7.8",
    "table-4/boundary-2.8": "deletion on the boundary above 2.8, not 3.5",
    "table-4/placed": "deletion in order of placement",
    "table-4/worst": "deletion of the most crowded first",
    "table-4/no-insertion": "no insertion",
    "table-4/exact-start": "no displacement of the first bubbles",
}

COMPARISONS = (
    Comparison("Example 1: FNPBS, accelerated", "table-5/example-1-fnpbs", "table-5/example-1-accelerated", 0.3),
    Comparison("Example 2: FNPBS, accelerated", "table-5/example-2-fnpbs", "table-5/example-2-accelerated", 0.7),
    Comparison(
        "Example 2: FNPBS of 4 rounds, accelerated",
        "table-5/example-2-fnpbs-4-rounds",
        "table-5/example-2-accelerated",
        0.7,
    ),
    Comparison("Example 3: FNPBS, accelerated", "table-5/example-3-fnpbs", "table-5/example-3-accelerated", 0.7),
    Comparison("Example 4: FNPBS, accelerated", "table-5/example-4-fnpbs", "table-5/example-4-accelerated", 0.7),
    Comparison("Example 3: BPM, FNPBS", "table-1", "table-4", 0.38),
    Comparison("dense variant: without odd bubbles, with", "section-2.2/dense-without", "section-2.2/dense-with", 0.53),
)

# Table 1: share of the time of the traditional method, in per cent.
TABLE_1 = {
    "initialization": 0.109,
    "adjacency": 5.028,
    "forces": 11.991,
    "new positions": 51.195,
    "population control": 31.674,
}

CASES = tuple(ROWS | VARIANTS)
