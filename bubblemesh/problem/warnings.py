"""Warnings of what a case asks for and cannot have, each with its place."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers, concatenated, members, select
from bubblemesh.geometry.corners import ANGLE_ROUNDING, PINCH_OUT
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.following import SEVERAL
from bubblemesh.geometry.narrow_parts import FacingWalls, Gaps
from bubblemesh.messages import counted, place
from bubblemesh.spacing.rules.gap_sources import NarrowPlace, size_across, surely_wide
from bubblemesh.spacing.rules.grading import STEEPEST_GROWTH, LimitedSpacing
from bubblemesh.spacing.rules.rules import ACROSS, Rules
from bubblemesh.spacing.rules.sources import Sources, short_pieces
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import Extremes

if TYPE_CHECKING:
    from bubblemesh.layers.figures import LabelLayers

SAMPLING = 1 / 64  # of the domain's size, along straight walls
MOST_SAMPLES = 100_000
NARROW = 0.7  # spacings: triangles across what is wider are good
# Where parts have been filled, as in corners: what is left has angles of 25 degrees, and nothing is to be done.
NARROW_IF_FILLED = 0.5
MORE_ACROSS = 1.5  # times: so many more spacings across are advised
BEYOND = 1e-3  # of the length of a side: how far from its end one looks at the tip of a slit
MOST_ANGLES = 5  # that a warning lists one by one
GAP_BY_MISTAKE = 1e-3  # of the spacing: narrower parts may be gaps by mistake
MANY_TIMES = 1.5  # the nodes of a spacing: more of them have a warning
JOIN = "join beside the line or file closes a gap that is not meant"
UNFILLED = Rules(across=0.0)
COMMON_SIDE = "regions drawn in the case have a common side where they have the same coordinates"
SIMPLE = 0.2  # of the spacing: what a border may be simplified by
FELT = 1.01  # times finer: no mesh shows less
LEAST_SHARE = 1e-3  # of the area: less is not told in figures
FAR_SHORTER = 0.05  # of the spacing: edges as short are hardly meant, also where a limit of growth makes room for them
SMALL_PART = 500  # nodes, below which seams are most of the work on a part


def sharp_angles(domain: Domain) -> list[str]:
    """Warnings of corners where lines enclose so small an angle in the domain that triangles there cannot be good."""
    boundary, ends = domain.boundary, domain.corner_fans
    angle = np.degrees(ends.angle_to(ends.following))
    sharp = np.flatnonzero(ends.within(boundary) & (angle < PINCH_OUT))
    sharp = sharp[~_at_tips_of_slits(domain, sharp)]
    sharp = sharp[np.argsort(angle[sharp], kind="stable")]
    sharp = sharp[np.sort(np.unique(ends.corner[sharp], return_index=True)[1])]
    if len(sharp) == 0:
        return []
    at = [place(boundary.corners[ends.corner[k]]) for k in sharp[:MOST_ANGLES]]
    size = [f"{abs(round(angle[k], 3)):.2g} degrees" for k in sharp[:MOST_ANGLES]]
    if len(sharp) == 1:
        return [f"the angle at {at[0]} is {size[0]}: triangles there are as sharp in any mesh"]
    which = "they are" if len(sharp) <= MOST_ANGLES else "the sharpest are"
    angles = ", ".join(f"{degrees} at {spot}" for degrees, spot in zip(size, at, strict=True))
    return [
        f"{len(sharp)} angles of the domain are below {PINCH_OUT:g} degrees, {which} {angles}: triangles there are as "
        "sharp in any mesh"
    ]


def _at_tips_of_slits(domain: Domain, some: Integers) -> Booleans:
    """Whether ends (k,) of pieces are at the tip of a slit of no angle, around which the domain is, not the other way.

    Directions that differ by rounding do not tell which it is: a place just beyond the tip does.
    """
    boundary, fans = domain.boundary, domain.corner_fans
    piece, corner = fans.piece[some], fans.corner[some]
    two = (np.bincount(fans.corner, minlength=len(boundary.corners))[corner] == 2) & ~boundary.inner[piece]
    flat = np.abs(fans.angle_to(fans.following)[some]) <= ANGLE_ROUNDING
    ahead = np.column_stack([np.cos(fans.direction[some]), np.sin(fans.direction[some])])
    beyond = boundary.corners[corner] - BEYOND * boundary.lengths[piece][:, None] * ahead
    return two & flat & domain.contains(beyond)


def larger_than_the_domain(extremes: Extremes, size: float, unit: str | None) -> list[str]:
    """Warning of a spacing that is nowhere as fine as the ``size`` of the domain, of a file with a ``unit``, if any."""
    finest = extremes.minimum
    if finest <= size:
        return []
    least = "at least " if finest < extremes.maximum else ""
    made = "" if unit is None else f" (units: {unit} made its lengths metres)"
    return [
        f"the spacing is {least}{finest / size:.3g} times the size of the domain ({size:.3g}): are its units those of "
        f"the domain{made}?"
    ]


def small_parts(parts: int | None, nodes: float) -> list[str]:
    """Warning of so many parts, if a number is given, that each has few of the nodes."""
    if parts is None or parts == 1 or nodes >= parts * SMALL_PART:
        return []
    most = max(int(nodes / SMALL_PART), 1)
    return [
        f"parts: {parts} of about {nodes / parts:.0f} nodes each take longer than one piece, and the mesh is less good "
        f"along their seams: ask for at most {most}"
    ]


def narrow_parts(
    walls: FacingWalls,
    spacing: Spacing,
    left_out: NarrowPlace | None,
    requested: Spacing | None,
    rules: Rules = UNFILLED,
) -> list[str]:
    """The place where the domain is narrowest in terms of the spacing, if clearly narrower than that.

    Likewise where a line or point inside the domain is nearest to another one, or to a wall. Of a ``requested`` spacing
    in a metric the size across counts. If narrow parts are left as they are since they would take too many nodes, the
    key that fills them is named; if they have been filled, as ``rules`` say or by default, a larger value of it.
    """
    if surely_wide(walls, spacing):
        return []
    boundary, corner = walls.domain.boundary, walls.reentrant
    piece, s = _samples(walls.domain)
    d, ahead_of = spacing(boundary.points(piece, s)), spacing(boundary.corners[corner.corner])
    gaps = concatenated([walls.facing(piece, s, d, d), walls.facing_corners(corner, ahead_of)])
    sized = requested if requested is not None and requested.in_metric else spacing
    warnings = []
    force, filled = "", left_out is None and rules.across != 0
    if left_out is not None:
        force = "; more would take many times the nodes: across: 1 in the spacing forces them"
    elif filled and not rules.minimum:
        force = f"; across: {MORE_ACROSS * (rules.across or ACROSS):g} in the spacing makes it finer there"
    least = NARROW_IF_FILLED if filled else NARROW
    for at, width, d_there in _narrowest(select(gaps, ~gaps.inner), sized, least):
        warnings.append(
            f"the domain is {width:.3g} wide at {place(at)}, narrower than the spacing there ({d_there:.3g}): only "
            f"boundary nodes fit{force}"
        )
    for at, width, d_there in _narrowest(select(gaps, gaps.inner), sized, least):
        can_join = len(walls.domain.parts.lines) > 0 or any(ring.origin for ring in walls.domain.parts.rings)
        join = f"; {JOIN if can_join else COMMON_SIDE}" if width < GAP_BY_MISTAKE * d_there else ""
        warnings.append(
            f"what is inside the domain leaves a strip of {width:.3g} at {place(at)}, narrower than the spacing there "
            f"({d_there:.3g}): no nodes fit into it{force}{join}"
        )
    return warnings


def _narrowest(gaps: Gaps, spacing: Spacing, least: float) -> list[tuple[Floats, float, float]]:
    """Place, width and spacing where the width is least in terms of the spacing, if it is below so many of these."""
    if len(gaps.number) == 0:
        return []
    there = size_across(gaps, spacing)
    worst = int(np.argmin(gaps.widths / there))
    narrow = gaps.widths[worst] < least * there[worst]
    return [(gaps.places[worst], gaps.widths[worst], there[worst])] if narrow else []


def _samples(domain: Domain) -> tuple[Integers, Floats]:
    """Pieces and arc lengths of points along all lines, inside the chords of their polygonal copy."""
    piece, s, step = domain.boundary.stations()
    thinned = slice(None, None, len(piece) // MOST_SAMPLES + 1)
    piece, s, step = piece[thinned], s[thinned], step[thinned]
    parts = np.ceil(step / (SAMPLING * domain.size)).astype(int)
    chord, part = members(parts)
    return piece[chord], s[chord] + (part + 0.5) * step[chord] / parts[chord]


class RefiningEdges(NamedTuple):
    """Numbers of the edges that are shorter than the spacing."""

    of_boundary: int  # and of borders between regions
    of_lines: int
    loose: int  # of those of the boundary that end in a vertex where nothing else does

    @classmethod
    def of(cls, domain: Domain, short: Sources) -> "RefiningEdges":
        """The edges at whose ends a spacing is made finer, two ``short`` sources for each."""
        boundary = domain.boundary.select(np.flatnonzero(~domain.boundary.closed))
        corner = np.column_stack([boundary.start, boundary.end])
        embedded = boundary.inner & (boundary.left == boundary.right)
        of_lines = set(map(bytes, boundary.corners[corner[embedded]]))
        degree = np.bincount(corner.ravel(), minlength=len(boundary.corners))
        single = set(map(bytes, boundary.corners[degree == 2]))
        edges = [edge for edge in short.points.reshape(-1, 2, 2) if bytes(edge) not in of_lines]
        loose = sum(bytes(a) in single or bytes(b) in single for a, b in edges)
        return cls(len(edges), len(short) // 2 - len(edges), loose)

    def __str__(self) -> str:
        numbers = {("boundary edge", ""): self.of_boundary, ("edge", " of lines"): self.of_lines}
        return " and ".join(f"{counted(number, noun)}{of}" for (noun, of), number in numbers.items() if number)


class FinerSpacing(NamedTuple):
    """Reasons that make the spacing of a packing finer than the one that a case asks for, and the nodes with it."""

    short: Sources  # edges of the boundary and of lines
    coarse: Sources  # places on tight curves
    edges: RefiningEdges
    gaps: Sources  # across narrow parts
    spacing: LimitedSpacing  # of the packing, beside the one without detail
    plain_nodes: float  # without detail
    expected_nodes: float
    followable: str | None  # how rings could be followed as curves, if they could be and none is
    followable_lines: bool  # whether lines of files could be
    file_length: float | None  # in the case, of 1 in a file with regions that are not simplified yet


def detail(found: FinerSpacing) -> list[str]:
    """Warnings of short edges and tight curves that made the spacing finer; one if all detail takes many nodes.

    Rings of regions that share borders are not followed as curves: where a file has such, they can be simplified, but
    for vertices in which borders meet.
    """
    at = found.spacing.ratio_at
    edges = f"{found.edges} shorter than the spacing"
    causes = {edges: found.short, "tight curves": found.coarse, "narrow parts": found.gaps}
    few = found.expected_nodes < MANY_TIMES * found.plain_nodes
    if few or at is None or not any(map(len, causes.values())):
        return refined_boundary(found.short, found.coarse, found.edges)
    size = found.spacing.ratio * float(found.spacing.spacing(np.array([at]))[0])
    simplify = (
        f"simplify: {SIMPLE * size / (found.file_length or 1.0):.1g} in the file leaves out vertices of short edges"
    )
    corners = f"{found.followable} takes short edges for curves"
    of_lines = "corners: 30 beside the file of the lines takes short edges for curves, simplify leaves out vertices"
    keys = {
        simplify: found.edges.loose >= SEVERAL and found.file_length is not None,
        corners: found.edges.of_boundary >= SEVERAL and found.followable is not None,
        of_lines: found.edges.of_lines >= SEVERAL and found.followable_lines,
        JOIN: len(found.gaps) > 0 and GAP_BY_MISTAKE * found.spacing.ratio > 1,
        "across: 0 in the spacing leaves narrow parts as they are": len(found.gaps) > 0,
    }
    advice = ", ".join(key for key, helps in keys.items() if helps)
    return [
        f"the mesh needs about {found.expected_nodes:.0f} nodes, {found.expected_nodes / found.plain_nodes:.3g} times "
        f"those of the spacing, for {' and '.join(cause for cause, sources in causes.items() if len(sources))}: the "
        f"spacing is {found.spacing.ratio:.3g} times finer at {place(at)}{f' ({advice})' if advice else ''}"
    ]


def refined_boundary(short: Sources, coarse: Sources, edges: RefiningEdges) -> list[str]:
    """Warnings of short edges and tight curves that made the spacing finer."""
    warnings = []
    if len(short):
        k = int(short.sizes.argmin())
        warnings.append(
            f"{edges} {'are' if len(short) > 2 else 'is'} shorter than the spacing, the shortest "
            f"({short.sizes[k]:.3g}) at {place(short.points[k])}: the mesh is finer around them"
        )
    if len(coarse):
        k = int(coarse.sizes.argmin())
        warnings.append(
            f"the spacing is too coarse for the curve at {place(coarse.points[k])}: it is reduced to "
            f"{coarse.sizes[k]:.3g} there"
        )
    return warnings


def far_shorter_edges(domain: Domain, given: Spacing, rules: Rules, hidden: Floats | None) -> list[str]:
    """Warning of edges far shorter than the given spacing, from which it grows if ``rules`` limit its growth.

    Of each piece those not longer than a length (p,) are ``hidden``, as of `short_pieces`.
    """
    if rules.growth is None:
        return []
    short = short_pieces(domain, given, hidden).not_below(rules.minimum)
    d = given(short.points).reshape(-1, 2).min(axis=1)
    short = short.select(np.repeat(short.sizes[::2] < FAR_SHORTER * d, 2))
    return refined_boundary(short, Sources.none(), RefiningEdges.of(domain, short))


def limited_growth(grading: LimitedSpacing, limit: float | None, scale: float | None) -> list[str]:
    """Warning of a spacing that grows so fast, or jumps, that it is held to less than the case's own limit.

    Slopes go with a ``scale`` that was found for a number of nodes.
    """
    if grading.steepest is None or (limit is not None and limit <= STEEPEST_GROWTH) or grading.ratio < FELT:
        return []
    at, size, growth = grading.steepest
    share = f"{grading.share:.1%}" if grading.share >= LEAST_SHARE else f"less than {LEAST_SHARE:.1%}"
    spacing = "the spacing" if scale is None else f"the spacing, times {scale:.3g} for the wanted number of nodes,"
    return [
        f"{spacing} grows by {growth:.2g} per length at {place(at)}, from {size:.3g}: it is held to "
        f"{STEEPEST_GROWTH:g}, finer on {share} of the area, at most {grading.ratio:.3g} times"
    ]


def low_layers(found: "Sequence[LabelLayers]") -> list[str]:
    """Warnings of layers that are lower than what was asked for."""
    return [text for layers in found for text in layers.lacking]
