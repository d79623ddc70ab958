"""Inspection of mesh files of any origin: their triangles, to be measured, with notes on what to know about them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bubblemesh.meshes.metric import MeasuresInMetric, tensors_in
from bubblemesh.meshes.quality import LAYER, Measures
from bubblemesh.meshfiles.faults import faults
from bubblemesh.meshfiles.read import MeshWithData, digits, left_out_notes, read_mesh, read_triangles, reading_notes


def inspected_triangles(path: Path) -> tuple[Measures, list[str]]:
    """Measures of the triangles of a file, and notes on it; the same errors as `read_triangles`.

    Labels, regions and data are not looked at, and may be damaged.
    """
    file = read_triangles(path)
    notes = [*file.source.notes, *file.curved, *left_out_notes(file.left_out)]
    notes += faults(file.points, file.triangles, digits(file.source))
    return Measures(file.points, file.triangles), named_notes(path, notes)


def inspected_mesh(path: Path) -> tuple[MeshWithData, list[str]]:
    """Mesh of a file, as `read_mesh` reads it, and notes on it; the same errors."""
    read = read_mesh(path)
    notes = [*reading_notes(read), *faults(read.mesh.points, read.mesh.triangles, read.digits)]
    return read, named_notes(path, notes)


def measures_in_metric(read: MeshWithData, field: str | None = None) -> tuple[MeasuresInMetric, list[str]]:
    """Measures of a mesh without its boundary layers, in the metric of its file, with the errors of `with_metric`.

    There is a note on layers that are left out.
    """
    # Imported here since few meshes have a metric.
    from bubblemesh.meshfiles.metric import with_metric

    read = with_metric(read, field)
    points, triangles = read.mesh.points, read.mesh.triangles
    packed = read.cell_data.get(LAYER, np.zeros(len(triangles))) == 0
    tensors = tensors_in({name: values[packed] for name, values in read.cell_data.items()})
    assert tensors is not None  # as the mesh is now one with a metric
    layers = np.count_nonzero(~packed)
    notes = [f"{layers} triangles of boundary layers are left out, as in reports"] if layers else []
    return MeasuresInMetric(points, triangles[packed], tensors), notes


def named_notes(path: Path, notes: Sequence[str]) -> list[str]:
    """Notes that begin with the name of the file."""
    return [f"{path}: {note}" for note in notes]
