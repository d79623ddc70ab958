"""Names that a format spells otherwise are read back as they were, whatever other formats were written beside it."""

from dataclasses import replace

import numpy as np
import pytest
from squares import holed_square

from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files

SPELLED = "su2", "med", "fort.14", "gr3", "slf", "ugrid", "openfoam"
# In words, the first is the second one.
LABELS = ("a b", "a_b", "c", "dé", "a_b_2")


def places(mesh):
    """Middles of the edges of each label."""
    middles = mesh.points[mesh.facets[:, :2]].mean(axis=1)
    return {
        label: sorted(map(tuple, np.round(middles[mesh.facet_labels == k], 5).tolist()))
        for k, label in enumerate(mesh.labels)
    }


@pytest.mark.parametrize("form", SPELLED)
@pytest.mark.parametrize("others", [(), SPELLED])
def test_labels_are_those_that_were_written(form, others, tmp_path):
    mesh = holed_square(labels=LABELS)
    formats = list(dict.fromkeys([form, *others]))
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "plate", formats))
    name = f"plate{FORMATS[form].files[0]}"  # no two of them have the same ending
    assert places(Mesh.read(tmp_path / name)) == places(mesh)


@pytest.mark.parametrize("labels", [("front", "back", "c", "d", "e"), ("front", "front_1", "back_1", "back", "e")])
def test_labels_with_names_of_openfoam_s_own_patches(labels, tmp_path):
    mesh = holed_square(labels=labels)
    write_files(mesh, {}, {}, MeshFiles(tmp_path, "plate", ["openfoam"]))
    assert places(Mesh.read(tmp_path / "plate.msh")) == places(mesh)


@pytest.mark.parametrize("name", ["a.nodes.npz", "a.nodes.csv"])
def test_a_point_with_the_name_of_a_label_has_another_one(name, tmp_path):
    mesh = holed_square()
    inner = int(np.flatnonzero(~np.isin(np.arange(len(mesh.points)), mesh.facets))[0])
    mesh = replace(mesh, labelled_nodes=np.array([inner]), node_labels=np.array([0]), point_labels=("hole",))
    mesh.write(tmp_path / name)
    if name.endswith("npz"):
        label = np.load(tmp_path / name)["label"]
    else:
        label = np.array([line.split(",")[3] for line in (tmp_path / name).read_text().splitlines()[1:]])
    assert label[inner] == "hole_point"
    assert np.count_nonzero(label == "hole") == 12
