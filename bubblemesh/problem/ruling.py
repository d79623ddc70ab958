"""The part of a case that sets the spacing at each place: one of its terms, a limit, a rule, or the boundary."""

from collections.abc import Sequence

import numpy as np

from bubblemesh.arrays import Booleans, Floats
from bubblemesh.problem.problem import Problem
from bubblemesh.spacing.rules.rules import Rules, limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import Sources

FINER = 0.02  # relative difference from which a spacing is finer than another: grading is no more exact
HERE = "spacing."


def ruling(problem: Problem, points: Floats) -> list[str]:
    """Names (n) of what sets the spacing that the packing goes by at points (n, 2).

    Terms and limits are called by their keys below ``spacing``; ``growth``, ``per_circle`` or ``across`` made it finer
    than these, or ``periodic`` sides; then the ``growth`` that every packing has, if no key gives a smaller one, and
    the ``boundary``, by short sides, tight curves and narrow parts.
    """
    names = [str(key).removeprefix(HERE) for key in problem.before_rules.keys(points)]
    steps = [(_rules(problem.rules), problem.after_rules.spacing), ("periodic", problem.after_periodic.spacing)]
    if problem.spacing.in_metric:
        steps.append(("metric", problem.packing_spacing))
    else:
        grown = limited_for_packing_across_sides(problem.domain, problem.after_periodic, Sources.none())
        steps += [("growth", grown.spacing), ("boundary", problem.packing_spacing)]
    before = problem.before_rules.extended(points)
    for name, spacing in steps:
        d = spacing.extended(points)
        names = _renamed(names, d < (1 - FINER) * before, name)
        before = np.minimum(d, before)
    return names


def _renamed(names: Sequence[str], which: Booleans, name: str) -> list[str]:
    return [name if mine else given for given, mine in zip(names, which.tolist(), strict=True)]


def _rules(rules: Rules) -> str:
    """The keys of the rules that there are."""
    given = {"growth": rules.growth, "per_circle": rules.per_circle, "across": rules.across}
    return ", ".join(name for name, value in given.items() if value)
