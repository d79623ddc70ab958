"""Completion of a mesh before it is written: curved edges, depths, its metric, other coordinates, a partition."""

from dataclasses import replace
from typing import NamedTuple, Self

from bubblemesh.errors import at_key
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.slices import SlicedMesh
from bubblemesh.problem.problem import Problem
from bubblemesh.run.measurement import Measured
from bubblemesh.run.water import WaterRow, depths_of


class Completed(NamedTuple):
    """A mesh as it is written."""

    mesh: Mesh | SlicedMesh
    straight: int = 0  # edges along curves that stay straight in a mesh of second order
    water: WaterRow | None = None  # if the mesh has depths

    @property
    def partition(self) -> Partition | None:
        """The partition of the mesh, if it has one."""
        return self.mesh.partition

    def divided(self, parts: int) -> Self:
        """The result with a partition into so many parts."""
        assert isinstance(self.mesh, Mesh)  # a partition needs all triangles at once
        with at_key("output", "partition"):
            return self._replace(mesh=self.mesh.partitioned(parts))


def completed(found: Measured, problem: Problem) -> Completed:
    """The mesh with its data and what its case asks for beside nodes and triangles; in slices it is complete."""
    mesh, task = found.mesh, problem.task
    if not isinstance(mesh, Mesh):
        return Completed(replace(mesh, frame=replace(mesh.frame, ids=task.ids)) if task.ids else mesh)
    plane, straight, water = problem.domain.plane, 0, None
    if task.order == 2:
        mesh, straight = mesh.second_order()
    if task.open_labels:
        mesh = replace(mesh, open_labels=task.open_labels)
    if task.ids:
        mesh = replace(mesh, ids=task.ids)
    if task.depth is not None:
        mesh = replace(mesh, depth=depths_of(mesh, task.depth))
        water = WaterRow.of(mesh)
    metric = mesh.metric if problem.written_metric is None else problem.written_metric.at(mesh.points)
    if plane is not None:
        mesh = replace(mesh.mapped(plane.written), geographic=plane.writes_degrees)
    return Completed(replace(mesh, metric=metric, fields=found.fields), straight, water)
