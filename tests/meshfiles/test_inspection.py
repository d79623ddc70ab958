"""Mesh files inspected by a program, as `quality` does it."""

import meshio
import numpy as np
import pytest

from bubblemesh.errors import CaseError
from bubblemesh.meshes.quality import mesh_figures
from bubblemesh.meshfiles.inspection import inspected_mesh, inspected_triangles, measures_in_metric

POINTS = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0]]
TRIANGLES = [[0, 1, 2], [0, 3, 2], [1, 4, 2]]  # of which the second turns right


@pytest.fixture
def written(tmp_path):
    def write(**data):
        path = tmp_path / "three.vtu"
        cells = [("triangle", TRIANGLES), ("tetra", np.zeros((0, 4), int))]
        meshio.Mesh(POINTS, cells, cell_data={k: [v, np.zeros(0)] for k, v in data.items()}).write(path)
        return path

    return write


def test_triangles_are_measured_with_notes_on_the_file(written):
    path = written()
    measures, notes = inspected_triangles(path)
    assert mesh_figures(measures, None)["area"] == pytest.approx(1.5)
    turned = "1 triangle turns the other way than the rest, the first at (0.333333, 0.666667)"
    assert notes[-1] == f"{path}: {turned}: the mesh may lie upon itself there"
    read, also = inspected_mesh(path)
    assert (len(read.mesh.triangles), also) == (3, notes)


def test_layers_have_no_part_in_the_measures_in_a_metric(written):
    tensors = {"metric_11": [4.0] * 3, "metric_12": [0.0] * 3, "metric_22": [4.0] * 3}
    read, _ = inspected_mesh(written(layer=[0.0, 1.0, 1.0], **tensors))
    measures, notes = measures_in_metric(read)
    assert len(measures.triangles) == 1
    assert notes == ["2 triangles of boundary layers are left out, as in reports"]
    with pytest.raises(CaseError, match="holds no metric"):
        measures_in_metric(inspected_mesh(written())[0])
