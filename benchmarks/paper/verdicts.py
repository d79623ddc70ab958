"""Whether what the paper prints holds here."""

from statistics import median

from benchmarks.paper.published import Comparison, Row, State
from benchmarks.paper.runs import Runs

FINAL = 0.01  # final nodes may differ by this part
ON_THE_WAY = 0.02  # nodes after a round of Table 4, likewise
ABOVE = 0.02  # mean q that is higher than the paper's by more counts as better


def verdict(row: Row, run: Runs, tolerance: float = FINAL) -> str:
    """Whether a row holds what the paper prints of it, and what it misses."""
    if row.initial is row.final is row.quality is None:
        return "not in the paper"
    misses = []
    initial = run.first.report["initial"]["nodes"]
    if row.initial is not None and initial != row.initial:
        misses.append(f"initial nodes {initial - row.initial:+d}")
    misses += _missed_nodes("final nodes", median(run.figures(lambda report: report["nodes"])), row.final, tolerance)
    quality = median(run.figures(lambda report: report["quality"]["mean"]))
    return _judged(misses, quality, row.quality, row.note)


def round_verdict(state: State, nodes: float, quality: float, tolerance: float = ON_THE_WAY) -> str:
    """The same for a row of Table 4."""
    return _judged(_missed_nodes("nodes", nodes, state.nodes, tolerance), quality, state.quality)


def claim_verdict(comparison: Comparison, share: float) -> str:
    """Whether a reduction, or an excess, is as large as claimed."""
    missing = comparison.claim - share
    return "reproduced" if missing <= 0 else f"not reproduced: {100 * missing:.1f} % short"


def _missed_nodes(what: str, nodes: float, printed: int | None, tolerance: float) -> list[str]:
    if printed is None or abs(nodes - printed) <= tolerance * printed:
        return []
    return [f"{what} {nodes / printed - 1:+.1%}"]


def _judged(misses: list[str], quality: float, printed: float | None, note: str = "") -> str:
    if printed is not None and quality < printed:
        misses = [*misses, f"mean q {quality - printed:+.4f}"]
    if misses:
        return "not reproduced: " + ", ".join(misses) + (f" ({note})" if note else "")
    return "better" if printed is not None and quality > printed + ABOVE else "reproduced"
