"""The mesh of a file divided among the processes of a parallel solver, and what there is to tell of it."""

from collections.abc import Mapping
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
from bubblemesh.problem.warnings import divided_by_geometry
from bubblemesh.records import record


@record
class DividedFile:
    """A mesh with its partition, data of its triangles, figures for a report, and the stem of its file."""

    mesh: Mesh
    fields: Fields
    report: Mapping[str, Any]
    name: str


def divided_file(path: Path, parts: int) -> DividedFile:
    """Divide the mesh of a file; CaseError if it has fewer triangles than parts, else errors as of `whole_mesh`."""
    mesh, notes = whole_mesh(path)
    with located(str(path)):
        partition = Partition.of(mesh.points, mesh.triangles, parts, mesh.quads)
        mesh = replace(mesh, partition=partition)
    measures = measures_of(mesh.points, mesh.triangles, mesh.fields)
    report = {
        "case": path.name,
        "version": __version__,
        **mesh_figures(measures, None),
        "partition": partition.figures(),
        "warnings": [*(f"{path}: {note}" for note in notes), *divided_by_geometry(partition)],
    }
    name = next((stem_of(path.name, form) for form in formats_by_ending(path.name)), path.stem)
    fields = {"quality": measures.radius_ratios, **mesh.fields}
    return DividedFile(mesh, fields, report, name)
