"""What a case asks for and cannot have: warnings, each with its place."""

from collections import defaultdict
from collections.abc import Mapping
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.curves import turning
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.gaps import gaps
from bubblemesh.spacing.grading import GROWTH, Graded
from bubblemesh.spacing.refinement import Sources
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.wording import place

__all__ = [
    "missed_budget",
    "narrow_walls",
    "poor_result",
    "refined_boundary",
    "sharp_angles",
    "slowed_growth",
    "straight_facets",
]

SAMPLING = 1 / 64  # of the domain's size, along straight walls
ROUNDING = 1e-6
SHARPEST = 5.0  # degrees
POOR_QUALITY = 0.2
BUDGET_TOLERANCE = 0.02  # of a wanted number of nodes
FEWEST, MOST = 0.9, 1.15  # nodes in terms of the ideal number
FEW_NODES = 100  # below which the boundary decides the number


def sharp_angles(domain: Domain) -> list[str]:
    """Corners where the domain's angle is so small that the triangles there cannot be good."""
    boundary = domain.boundary
    open_ = np.flatnonzero(~boundary.closed)
    ahead = boundary.tangents(open_, np.zeros(len(open_)))
    back = -boundary.tangents(open_, boundary.lengths[open_])
    leaving, arriving = _meeting(boundary.start[open_], boundary.end[open_])
    angle = np.full(len(open_), np.inf)
    # A full turn is no angle of a domain: it is none at all, rounded down.
    between = (turning(ahead[leaving], back[arriving]) + ROUNDING) % (2 * np.pi) - ROUNDING
    np.minimum.at(angle, leaving, np.degrees(between))
    sharp = np.flatnonzero(angle < SHARPEST)
    warnings = [
        f"the angle at {place(corner)} is {abs(round(a, 3)):.2g} degrees: triangles there are as sharp"
        for corner, a in zip(boundary.corners[boundary.start[open_[sharp]]], angle[sharp], strict=True)
    ]
    return list(dict.fromkeys(warnings))


def _meeting(start: Integers, end: Integers) -> tuple[Integers, Integers]:
    """Pairs i, j of pieces such that j ends at the corner where i starts; several where rings touch."""
    ending = defaultdict(list)
    for j, corner in enumerate(end.tolist()):
        ending[corner].append(j)
    pairs = [(i, j) for i, corner in enumerate(start.tolist()) for j in ending[corner]]
    meeting = np.array(pairs, np.int64).reshape(-1, 2)
    return meeting[:, 0], meeting[:, 1]


def narrow_walls(domain: Domain, spacing: Spacing) -> list[str]:
    """The place where the domain is narrowest in terms of the spacing, if narrower than that."""
    piece, s = _samples(domain)
    d = spacing(domain.boundary.points(piece, s))
    places, widths, _ = gaps(domain, piece, s, d)
    if len(places) == 0:
        return []
    there = spacing(places)
    worst = int(np.argmin(widths / there))
    return [
        f"the domain is {widths[worst]:.3g} wide at {place(places[worst])}, narrower than the spacing there "
        f"({there[worst]:.3g}): only boundary nodes fit"
    ]


def _samples(domain: Domain) -> tuple[Integers, Floats]:
    """Pieces and arc lengths of points along the whole boundary, inside the chords of its polygonal copy."""
    line = domain.polyline
    parts = np.ceil(line.step / (SAMPLING * domain.size)).astype(int)
    chord = np.repeat(np.arange(len(parts)), parts)
    part = np.arange(len(chord)) - (np.cumsum(parts) - parts)[chord]
    return line.piece[chord], line.s[chord] + (part + 0.5) * line.step[chord] / parts[chord]


def refined_boundary(short: Sources, coarse: Sources) -> list[str]:
    """Where short edges and tight curves made the spacing finer."""
    warnings = []
    if len(short):
        k = int(short.sizes.argmin())
        several = f"{len(short) // 2} boundary edges are" if len(short) > 2 else "1 boundary edge is"
        warnings.append(
            f"{several} shorter than the spacing, the shortest ({short.sizes[k]:.3g}) at "
            f"{place(short.points[k])}: the mesh is finer around them"
        )
    if len(coarse):
        k = int(coarse.sizes.argmin())
        warnings.append(
            f"the spacing is too coarse for the curve at {place(coarse.points[k])}: it is reduced to "
            f"{coarse.sizes[k]:.3g} there"
        )
    return warnings


def slowed_growth(grading: Graded) -> list[str]:
    """Where the spacing grows so fast, or jumps, that it was made to grow more slowly."""
    if grading.steepest is None:
        return []
    at, size, growth = grading.steepest
    return [
        f"the spacing grows by {growth:.2g} per length at {place(at)}, from {size:.3g}: it is held to {GROWTH:g}, "
        f"finer on {grading.share:.1%} of the area, at most {grading.ratio:.3g} times"
    ]


def straight_facets(count: int) -> list[str]:
    """Boundary edges of second order that could not follow their curve."""
    if count == 0:
        return []
    edges = "1 boundary edge keeps" if count == 1 else f"{count} boundary edges keep"
    return [f"{edges} a straight second-order form: on its curve a triangle would fold over; refine the spacing there"]


def missed_budget(wanted: int, found: int) -> list[str]:
    """A number of nodes that the mesh does not have, to 2 %, or to one node if they are few."""
    if abs(found - wanted) <= max(BUDGET_TOLERANCE * wanted, 1):
        return []
    which = "more" if found > wanted else "fewer"
    return [
        f"the mesh has {found} nodes, {abs(found / wanted - 1):.1%} {which} than the {wanted} asked "
        "for: no scale that was tried comes nearer"
    ]


def poor_result(figures: Mapping[str, Any], ideal_nodes: float | None) -> list[str]:
    """What the finished mesh falls short of; without an ideal number of nodes their number is not judged."""
    warnings = []
    worst = figures["quality"]["worst"][0]
    if worst["quality"] < POOR_QUALITY:
        warnings.append(f"the worst triangle, at {place(worst['at'])}, has a quality of {worst['quality']:.3f} only")
    if ideal_nodes is not None and max(figures["nodes"], ideal_nodes) > FEW_NODES:
        ratio = figures["nodes"] / ideal_nodes
        if not FEWEST <= ratio <= MOST:
            warnings.append(f"the mesh has {ratio:.2f} times the {ideal_nodes:.0f} nodes that the spacing asks for")
    if figures["boundary_nodes"] == figures["nodes"]:
        warnings.append("all nodes are on the boundary: the spacing is too large for a node inside")
    return warnings
