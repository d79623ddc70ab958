"""Warnings of lines that end so near to something that they are hardly meant to."""

from collections.abc import Iterator

from bubblemesh.geometry.domain import Domain
from bubblemesh.messages import counted
from bubblemesh.spacing.spacing import Spacing

HARDLY_MEANT = 0.2  # spacings: between an end and what it does not meet


def missed_contacts(domain: Domain, spacing: Spacing) -> Iterator[str]:
    """The warning of open ends of lines that are far nearer to another line or to a wall than the spacing, if any.

    Who means such an end makes the spacing there finer than the gap.
    """
    if not domain.parts.lines or len(domain.open_ends.places) == 0:
        return
    gaps = domain.open_ends.gaps(HARDLY_MEANT * spacing(domain.open_ends.places))
    if gaps:
        first, there = gaps[0], float(spacing(gaps[0].at[None])[0])
        missing = f"give the point there, if {first.width:.2g} are missing"
        advice = f"join: {first.join} closes the gap" if first.join else missing
        more = f" (and {counted(len(gaps) - 1, 'more end')}, up to {gaps[-1].width:.2g} from something)"
        yield f"{first.text}, where the spacing is {there:.3g}: {advice}{more if len(gaps) > 1 else ''}"
