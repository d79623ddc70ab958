"""The goal of an adaptation, and what is told of one that is not reached."""

from collections.abc import Callable
from functools import partial

import numpy as np

from bubblemesh.adaptivity.sizes import FINER
from bubblemesh.arrays import is_real, is_whole
from bubblemesh.case.spacing import SpacingTerms
from bubblemesh.errors import CaseError, Key
from bubblemesh.problem.spacing import NODES
from bubblemesh.records import record

MOST_TIMES = 16.0  # the nodes of the mesh before, in a metric
REACHED = 1.02  # times a wanted error: if more is expected it is told


@record
class Target:
    """Goal of an adaptation: a relative error, or a number of nodes; without both, as many nodes as there are."""

    error: float | None = None
    nodes: int | None = None
    anisotropic: bool = False  # whether sizes depend on the direction
    mark: str = ""  # before the names of arguments in messages: those of the command line have -- there

    def __post_init__(self) -> None:
        error, nodes = self.called("error"), self.called("nodes")
        if self.error is not None and self.nodes is not None:
            raise CaseError(f"{error} and {nodes} exclude each other: give one of them")
        if self.error is not None and not (is_real(self.error) and 0 < self.error < 1):
            raise CaseError(f"{error}: must be a share of the gradient's norm, between 0 and 1 (found {self.error!r})")
        if self.nodes is not None and not is_whole(self.nodes, 3):
            raise CaseError(f"{nodes}: must be a whole number of at least 3 (found {self.nodes!r})")
        if not isinstance(self.anisotropic, bool | np.bool_):
            raise CaseError(f"{self.called('anisotropic')}: must be true or false (found {self.anisotropic!r})")

    def called(self, argument: str) -> str:
        """Name of an argument in messages."""
        return f"{self.mark}{argument}"

    def instead_of(self, before: int, terms: SpacingTerms) -> Callable[[int], str] | None:
        """Warning of a number of nodes in place of those before; None if it or the case's terms say how far to go."""
        said = self.error is not None or self.nodes is not None or terms.nodes is not None
        return None if said else partial(_other_number, before, self.called("nodes"))

    def nodes_key(self, terms: SpacingTerms) -> Key:
        """Argument that says how many nodes the mesh gets, or the key of the case's terms that does so without any."""
        if self.error is None and self.nodes is None and terms.nodes is not None:
            return NODES
        return Key([self.called("nodes" if self.error is None else "error")])

    @property
    def figures(self) -> dict[str, float | None]:
        """The goal as reports hold it."""
        return {"error": self.error, "nodes": self.nodes, "anisotropic": bool(self.anisotropic)}


def missed_error(wanted: float, expected: float, step: float, share: float, *, anisotropic: bool) -> str:
    """Warning of a relative error that is above the wanted one on the next mesh, with what is in the way.

    That is one step, with the error ``step`` if nothing else holds, or the case's limits: ``spacing.minimum``, which
    holds at a ``share`` of the nodes, or others.
    """
    far, limited = step > REACHED * wanted, expected > REACHED * step
    most = f"{MOST_TIMES:g} times as many nodes" if anisotropic else f"sizes of 1/{1 / FINER:g}"
    holding = f"spacing.minimum holds at {share:.1%} of the nodes" if share else "limits of the case hold"
    causes = {f"one step gives {most} at most": far, holding: limited or not far}
    cures = {"adapt again to the new solution": far, "lower it" if share else "lower them": limited or not far}
    in_the_way, cure = (
        word.join(text for text, holds in row.items() if holds) for word, row in ((", and ", causes), (", or ", cures))
    )
    return f"an error of {wanted:g} is asked for, and {expected:.3g} is expected: {in_the_way}: {cure}"


def _other_number(before: int, argument: str, found: int) -> str:
    """Warning of about as many nodes as are found, in place of those before; the ``argument`` asks for a number."""
    same = f"as many nodes as the mesh of the solution has, {before}, are"
    if found < before:
        return f"{same} more than the limits of the case allow: the new mesh gets about {found}"
    return (
        f"{same} too few: the boundary and the other keys of the spacing take about {found}, and leave next to none "
        f"for the solution: ask for more by {argument}"
    )
