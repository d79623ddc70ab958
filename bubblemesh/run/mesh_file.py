"""The mesh of a file, to be written again: as it is, or divided among the processes of a parallel solver."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from bubblemesh import __version__
from bubblemesh.errors import located
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.metric import measures_of
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.quality import mesh_figures
from bubblemesh.meshfiles.formats import formats_by_ending, stem_of
from bubblemesh.meshfiles.groups import Fields
from bubblemesh.meshfiles.whole_mesh import whole_mesh
from bubblemesh.records import record
from bubblemesh.run.warnings import divided_by_geometry


@record
class MeshOfFile:
    """A mesh with data of its triangles, figures for a report, and the stem of its file."""

    mesh: Mesh
    fields: Fields
    report: dict[str, Any]
    name: str


def mesh_of_file(path: Path) -> MeshOfFile:
    """The mesh of a file, with its labels and regions; the same errors as `whole_mesh`."""
    mesh, notes = whole_mesh(path)
    measures = measures_of(mesh.points, mesh.triangles, mesh.fields)
    report = {
        "case": path.name,
        "version": __version__,
        **mesh_figures(measures, None),
        "warnings": [f"{path}: {note}" for note in notes],
    }
    name = next((stem_of(path.name, form) for form in formats_by_ending(path.name)), path.stem)
    return MeshOfFile(mesh, {"quality": measures.radius_ratios, **mesh.fields}, report, name)


def divided_mesh_of_file(path: Path, parts: int) -> MeshOfFile:
    """The mesh of a file in parts; the errors of `mesh_of_file`, CaseError if it has fewer triangles than parts."""
    whole = mesh_of_file(path)
    mesh = whole.mesh
    with located(str(path)):
        partition = Partition.of(mesh.points, mesh.triangles, parts, mesh.quads)
    warnings = [*whole.report["warnings"], *divided_by_geometry(partition)]
    report = whole.report | {"partition": partition.figures(), "warnings": warnings}
    return replace(whole, mesh=replace(mesh, partition=partition), report=report, name=f"{whole.name}-{parts}")
