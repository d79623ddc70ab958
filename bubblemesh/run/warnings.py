"""Warnings of what a mesh is and was not asked to be."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bubblemesh.messages import place
from bubblemesh.problem.compatibility import FEW_NODES
from bubblemesh.problem.warnings import MOST_ANGLES

if TYPE_CHECKING:
    from bubblemesh.layers.figures import LabelLayers
    from bubblemesh.meshes.partition import Partition
    from bubblemesh.packing.demands import Demands
    from bubblemesh.packing.refinement import Refined
    from bubblemesh.problem.node_target import NodeTarget
    from bubblemesh.run.metric import MetricRow, ShortenedRow
    from bubblemesh.run.water import WaterRow

POOR_QUALITY = 0.2
FEWEST, MOST = 0.9, 1.15  # nodes in terms of the ideal number
MOSTLY_DRY = 0.5  # share of the nodes
COARSER = 2.0  # times the sizes that a solution asks for: larger ones have a warning
JUMP = 4.0  # ratio of the sizes across of ellipses at both ends of an edge, from which it is told
TURN = 60.0  # degrees between their long axes, from which it is told


def poor_result(figures: Mapping[str, Any], ideal_nodes: float | None, *, packed_finer: bool) -> list[str]:
    """Warnings of a poor mesh; without an ideal number of nodes their number is not judged.

    Where the spacing of the packing is finer than the one asked for more nodes than the ideal number are no fault.
    """
    warnings = []
    worst = figures["quality"]["worst"][0]
    if worst["quality"] < POOR_QUALITY:
        warnings.append(f"the worst triangle, at {place(worst['at'])}, has a quality of {worst['quality']:.3f} only")
    if ideal_nodes is not None and max(figures["nodes"], ideal_nodes) > FEW_NODES:
        ratio = figures["nodes"] / ideal_nodes
        if ratio < FEWEST or (ratio > MOST and not packed_finer):
            warnings.append(f"the mesh has {ratio:.2f} times the {ideal_nodes:.0f} nodes that the spacing asks for")
    if figures["boundary_nodes"] == figures["nodes"]:
        warnings.append("all nodes are on the boundary: the spacing is too large for a node inside")
    return warnings


def dry_water(water: "WaterRow | None") -> list[str]:
    """Warning of depths most of which are above the water's level, as heights are."""
    if water is None or water.dry <= MOSTLY_DRY:
        return []
    return [
        f"the depth is not above 0 at {water.dry:.0%} of the nodes, which are dry: it counts down from the water's "
        "level; of heights take the negative ones, as -raster.NAME"
    ]


def unsteady_ellipses(metric: "MetricRow | None", *, adapted: bool) -> list[str]:
    """Warnings of a metric that turns so fast that its ellipses are made shorter, and of one that jumps.

    How fast one that is ``adapted`` to a solution may grow is told by another key.
    """
    if metric is None:
        return []
    jumps = [
        f"{what} at {place(at)}"
        for jumps, what, at in (
            (metric.steepest > JUMP, f"by a factor of {metric.steepest:.3g}", metric.steepest_at),
            (metric.turn > TURN, f"by {metric.turn:.0f} degrees", metric.turn_at),
        )
        if jumps
    ]
    told = [
        f"the metric jumps: ellipses at the ends of an edge differ {' and '.join(jumps)}, so that triangles are bad "
        f"there: {'a smaller spacing.growth' if adapted else 'gradation: 0.3 in the metric'} makes it grow gently"
    ]
    return [*_shorter_ellipses(metric.shortened), *(told if jumps else [])]


def _shorter_ellipses(row: "ShortenedRow | None") -> list[str]:
    if row is None:
        return []
    return [
        f"{', or '.join(row.reasons)}: at {row.share:.1%} of the nodes ellipses are shorter along than the metric asks "
        f"for, {row.ratio:.3g} times at {place(row.ratio_at)}"
    ]


def straight_facets(count: int) -> list[str]:
    """Boundary edges of second order that could not follow their curve."""
    if count == 0:
        return []
    edges = "1 boundary edge keeps" if count == 1 else f"{count} boundary edges keep"
    return [f"{edges} a straight second-order form: on its curve a triangle would fold over; refine the spacing there"]


def divided_by_geometry(partition: "Partition") -> list[str]:
    """A partition that METIS did not make, and why."""
    if partition.reason is None:
        return []
    return [f"the mesh is divided by geometry: {partition.reason}"]


def sharper_corners(refined: "Refined", demands: "Demands") -> list[str]:
    """Corners in which triangles are sharper than the least angle that is asked for."""
    corners = sorted(refined.excused, key=lambda corner: corner.angle)
    if not corners:
        return []
    angles = ", ".join(f"{corner.angle:.3g} degrees at {place(corner.at)}" for corner in corners[:MOST_ANGLES])
    more = f" and {len(corners) - MOST_ANGLES} more" if len(corners) > MOST_ANGLES else ""
    which = "a corner that is" if len(corners) == 1 else f"{len(corners)} corners that are"
    sharper = "below twice that, which an edge inside halves" if demands.inner_node else "sharper"
    return [
        f"angle_min: {demands.angle:g} holds but in {which} {sharper}, with {angles}{more}: no mesh can do better there"
    ]


def missed_node_target(target: "NodeTarget", found: int) -> list[str]:
    """A number of nodes that the mesh, with as many as were ``found``, should have and misses."""
    if not target.is_missed_by(found):
        return []
    which = "more" if found > target.nodes else "fewer"
    return [
        f"the mesh has {found} nodes, {abs(found / target.nodes - 1):.1%} {which} than the {target.nodes} asked "
        "for: no scale that was tried comes nearer"
    ]


def jumps_at_layers(found: "Sequence[LabelLayers] | None") -> list[str]:
    """Warnings of layers beside which triangles are much higher, or much smaller, so that cells are flat."""
    texts = [text for layers in found or () for text in (layers.flat, layers.jumping)]
    return [text for text in texts if text is not None]


def nodes_of_layers(nodes: int, own: float, scale: float) -> list[str]:
    """A number of nodes of which layers take so many that sizes beside them are much larger than a solution asks for.

    ``own`` nodes are those of the layers, ``scale`` is that of the spacing with which the number is met.
    """
    if scale <= COARSER:
        return []
    return [
        f"the layers take about {own:.0f} of the {nodes} nodes: the spacing beside them is {scale:.3g} times the one "
        "that the solution asks for with so many: ask for more nodes, or for fewer layers"
    ]
