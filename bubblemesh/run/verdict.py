"""Whether a mesh is what its case requires: if not, why."""

from collections.abc import Mapping
from typing import Any

from bubblemesh.errors import NODE_LIMIT, BubblemeshError, LimitError, NodeLimitError, RequirementError
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.messages import counted
from bubblemesh.packing.demands import Demands
from bubblemesh.packing.refinement import Refined
from bubblemesh.problem.problem import SEA_REQUIREMENTS
from bubblemesh.run.packing import PackedProblem
from bubblemesh.run.water import sea_figures


def verdict(packing: PackedProblem, figures: Mapping[str, Any], mesh: Mesh | SlicedMesh) -> BubblemeshError | None:
    """Why the mesh of a packing is not what the case requires, if it is not; ``figures`` are the report's."""
    if packing.cut_short is not None:
        return LimitError(f"limits.seconds: stopped by {packing.stop_reason}: the mesh is as it was then")
    if packing.refined is not None and packing.refined.stopped is not None:
        return _unrefined(packing.refined, packing.problem.demands)
    quality = figures["quality"]
    required = packing.problem.task.requirements
    of_sea = sea_figures(mesh) if isinstance(mesh, Mesh) and SEA_REQUIREMENTS & required.keys() else {}
    least = {"quality_min": quality["min"], "quality_mean": quality["mean"], "angle_min": quality["angle_min"]}
    largest = {"angle_max": quality["angle_max"], "valence_max": quality["valence_max"]}
    largest |= {f"{name}_max": count for name, count in of_sea.items()}
    low = {key: value for key, value in least.items() if value < required.get(key, value)}
    high = {key: value for key, value in largest.items() if value > required.get(key, value)}
    missed = ["{} is {}, below {}".format(key, *_apart(value, required[key])) for key, value in low.items()]
    missed += ["{} is {}, above {}".format(key, *_apart(value, required[key])) for key, value in high.items()]
    if missed:
        return RequirementError(f"the mesh is made, but misses what the case requires: {'; '.join(missed)}")
    return None


def _apart(value: float, required: float) -> tuple[str, str]:
    """Two numbers that differ as texts that do: counts in full, others with at least four digits."""
    if isinstance(value, int):
        return f"{value:,}", f"{required:,}"
    pairs = ((f"{value:.{digits}g}", f"{required:.{digits}g}") for digits in range(4, 18))
    return next(pair for pair in pairs if pair[0] != pair[1])


def _unrefined(refined: Refined, demands: Demands) -> BubblemeshError:
    """Why a refinement ended before its demands were met."""
    told = list[str]()
    if demands.angle > refined.angle:
        told.append(f"the least angle is {refined.angle:.4g} degrees")
    if refined.excess > 1:
        told.append(f"a triangle has {refined.excess:.3g} times the largest area")
    if refined.overconstrained:
        told.append(f"{counted(refined.overconstrained, 'triangle')} with all nodes on the boundary are left")
    stopped = f"by {NODE_LIMIT}: {demands.max_nodes}" if refined.out_of_nodes else refined.stopped
    kind = NodeLimitError if refined.out_of_nodes else RequirementError
    return kind(
        f"the refinement for angle_min, largest or overconstrained was stopped {stopped}: the mesh is made, "
        f"but {' and '.join(told)}"
    )
