"""The spacing that a case asks for, and the finer one that a packing goes by where the boundary needs it."""

from dataclasses import replace
from typing import NamedTuple

from bubblemesh.arrays import Floats
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.narrow_parts import FacingWalls
from bubblemesh.problem.narrow_parts import FilledSpacing, Unfilled, with_narrow_parts_filled
from bubblemesh.problem.spacing import SpacingRequest
from bubblemesh.spacing.cover import Cover
from bubblemesh.spacing.rules.grading import STEEPEST_GROWTH, LimitedSpacing, compared
from bubblemesh.spacing.rules.rules import Rules, limited_across_sides, limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import Sources, coarse_curves, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ESTIMATE, Extremes, Survey, ideal_nodes, surveyed


class RequestedSpacing(NamedTuple):
    """The spacing that a case asks for, and the steps to it."""

    before_rules: Spacing  # that of the terms and their limits
    extremes_before: Extremes  # of that
    after_rules: LimitedSpacing  # made finer by rules such as ``growth``
    after_periodic: LimitedSpacing  # and as fine as on the other one of two periodic sides
    survey: Survey
    hidden: Floats | None  # (p,): edges below layers, up to so long on each piece, make nothing finer

    @property
    def spacing(self) -> Spacing:
        """The spacing itself."""
        return self.after_periodic.spacing


class Fitted(NamedTuple):
    """The spacing of a packing, and what made it finer than the one that is requested."""

    requested: Spacing  # beside which edges are short, curves tight and parts narrow
    short: Sources  # ends of boundary edges that are shorter than the spacing
    coarse: Sources  # places on curves that are too tight for it
    before_narrow_parts: LimitedSpacing  # made finer by these two
    walls: FacingWalls
    filled: FilledSpacing


def requested_spacing(
    domain: Domain, request: SpacingRequest, scale: float | None, max_nodes: int, hidden: Floats | None
) -> RequestedSpacing:
    """The spacing of a request at some scale, finer where its rules and periodic sides ask for it.

    Edges below layers are ``hidden`` up to some length (p,) of each piece, and make nothing finer.
    CaseError where it is not positive and finite, and LimitError where it needs more than so many nodes.
    """
    before_rules, cover = request.at(scale), Cover(domain)
    survey = surveyed(domain, before_rules, max_nodes, cover)
    extremes_before = survey.extremes
    given = replace(before_rules, floor=extremes_before.minimum / 2)
    ruled = request.rules(domain, given, max_nodes, hidden)
    after_rules = replace(ruled, ground=None)
    after_periodic = limited_across_sides(domain, given, after_rules, ruled.ground)
    if max(after_rules.ratio, after_periodic.ratio) > 1:
        survey = surveyed(domain, after_periodic.spacing, max_nodes, cover)
    return RequestedSpacing(before_rules, extremes_before, after_rules, after_periodic, survey, hidden)


def fitted_to_boundary(
    domain: Domain, requested: RequestedSpacing, spacing: Spacing, rules: Rules, max_nodes: int
) -> Fitted:
    """The spacing for a packing: finer at short edges, at tight curves and across narrow parts of the domain.

    What is short, tight or narrow is so beside the ``spacing``: the one that is requested, or that in a metric
    below it, whose sizes depend on the direction. LimitError if it needs more than so many nodes.
    """
    cover, expected, hidden = requested.survey.cover, requested.survey.ideal_nodes, requested.hidden
    short, coarse = short_pieces(domain, spacing, hidden), coarse_curves(domain, spacing, hidden)
    for_packing = limited_for_packing_across_sides(domain, requested.after_periodic, short.joined(coarse))
    if for_packing.spacing is not requested.spacing:
        expected = ideal_nodes(domain, for_packing.spacing, max_nodes, ESTIMATE, cover)
    walls = FacingWalls(domain)
    unfilled = Unfilled(cover, spacing, requested.after_periodic, for_packing, expected)
    return Fitted(
        spacing, short, coarse, for_packing, walls, with_narrow_parts_filled(walls, rules, unfilled, max_nodes)
    )


def beside_no_detail(
    domain: Domain, requested: RequestedSpacing, rules: Rules, filled: FilledSpacing, max_nodes: int
) -> tuple[LimitedSpacing, float]:
    """The spacing of a packing, with how much finer its detail made it, and the nodes that there are without detail.

    Nodes that a spacing takes since it grows too fast for a packing do not count as those of detail.
    """
    slow = rules.growth is not None and rules.growth <= STEEPEST_GROWTH
    if filled.spacing.steepest is None or slow:
        return filled.spacing, requested.survey.ideal_nodes
    plain = limited_for_packing_across_sides(domain, requested.after_periodic, Sources.none()).spacing
    nodes = ideal_nodes(domain, plain, max_nodes, ESTIMATE, requested.survey.cover)
    return compared(domain, filled.spacing, plain), nodes
