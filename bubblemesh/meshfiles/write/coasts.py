"""Text formats of models of coasts: ADCIRC's fort.14, SCHISM's hgrid.gr3, SMS's .2dm.

References
----------
ADCIRC, "Grid and Boundary Information File (fort.14)". SCHISM, "hgrid.gr3". Aquaveo, "SMS 2D Mesh Files (*.2dm)".
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.shores import Kind, Stretch, stretches
from bubblemesh.meshfiles.groups import Fields, cell_ids, group_names, ids_of_groups
from bubblemesh.meshfiles.text import lines, numbered, write_text

# Numbers of the boundaries without flow; in ADCIRC, those of natural boundary conditions.
ADCIRC: Mapping[Kind, int] = {"land": 20, "island": 21}
SCHISM: Mapping[Kind, int] = {"land": 0, "island": 1}
SMS_CELLS = {3: "E3T", 4: "E4Q"}
STRING = 10  # nodes on a line of a node string


def depths(mesh: Mesh) -> Floats:
    """Depth (n,) at each node; 0 if the mesh has no depth."""
    return mesh.depth if len(mesh.depth) else np.zeros(len(mesh.points))


def edge_labels(mesh: Mesh) -> dict[str, str]:
    """Return the names of the labels of edges, which these files hold as they are."""
    return {name: name for name, group in group_names(mesh).items() if group.dimension == 1}


def write_grid(mesh: Mesh, fields: Fields, path: Path, *, closed: Mapping[Kind, int]) -> None:
    """Write nodes with depths, cells, and the open, land and island boundaries, for ADCIRC or SCHISM.

    The numbers of boundaries without flow are ``closed``. The label of each boundary is a remark after its number of
    nodes. Regions, inner lines, labelled points and fields are not written.
    """
    write_text(path, _grid_text(mesh, closed))


write_adcirc = partial(write_grid, closed=ADCIRC)
write_schism = partial(write_grid, closed=SCHISM)


def _grid_text(mesh: Mesh, closed: Mapping[Kind, int]) -> Iterator[str]:
    yield f"mesh by bubblemesh\n{sum(len(cells.nodes) for cells in mesh.cells)} {len(mesh.points)}\n"
    yield from lines("%d %r %r %r", numbered(len(mesh.points)), mesh.points, depths(mesh))
    before = 0
    for nodes, _ in mesh.cells:
        width = nodes.shape[1]
        yield from lines(f"%d {width}{' %d' * width}", before + numbered(len(nodes)), nodes + 1)
        before += len(nodes)
    found = stretches(mesh)
    yield from _boundaries("open", [each for each in found if each.kind == "open"], {})
    yield from _boundaries("land", [each for each in found if each.kind != "open"], closed)


def _boundaries(word: str, found: Sequence[Stretch], numbers: Mapping[Kind, int]) -> Iterator[str]:
    yield f"{len(found)} = number of {word} boundaries\n"
    yield f"{sum(len(each.nodes) for each in found)} = total number of {word} boundary nodes\n"
    for count, each in enumerate(found, start=1):
        number = f" {numbers[each.kind]}" if numbers else ""
        yield f"{len(each.nodes)}{number} = number of nodes for {each.kind} boundary {count}: {each.label}\n"
        yield from lines("%d", each.nodes + 1)


def write_sms(mesh: Mesh, fields: Fields, path: Path) -> None:
    """Write nodes with the height of the bed, cells with materials, and a node string for each stretch of a label.

    Materials are the ids of regions, numbers of node strings those of labels. Fields and labelled points are not
    written.
    """
    write_text(path, _sms_text(mesh))


def _sms_text(mesh: Mesh) -> Iterator[str]:
    """Lines of the file of `write_sms`."""
    yield 'MESH2D\nMESHNAME "mesh by bubblemesh"\nNUM_MATERIALS_PER_ELEM 1\n'
    before = 0
    for cells in mesh.cells:
        count, width = cells.nodes.shape
        form = f"{SMS_CELLS[width]} %d{' %d' * width} %d"
        yield from lines(form, before + numbered(count), cells.nodes + 1, cell_ids(mesh, cells))
        before += count
    yield from lines("ND %d %r %r %r", numbered(len(mesh.points)), mesh.points, 0 - depths(mesh))
    ids = ids_of_groups(mesh).tolist()
    for label in range(len(mesh.labels)):
        for chain in _chains(mesh, label):
            nodes = [number + 1 for number in chain]
            nodes[-1] *= -1
            rows = [nodes[k : k + STRING] for k in range(0, len(nodes), STRING)]
            rows[-1].append(ids[label])
            yield from (f"NS {' '.join(map(str, row))}\n" for row in rows)


def _chains(mesh: Mesh, label: int) -> Iterator[list[int]]:
    """Chains of the nodes of a label's edges, without forks; a ring ends with its first node."""
    edges = mesh.facets[mesh.facet_labels == label, :2]
    leaving, coming = (np.bincount(nodes, minlength=len(mesh.points)) for nodes in edges.T)
    simple = (leaving == 1) & (coming == 1)
    after = dict(edges[simple[edges[:, 0]]].tolist())
    for a, b in edges[~simple[edges[:, 0]]].tolist():
        chain = [a, b]
        while (following := after.pop(chain[-1], None)) is not None:
            chain.append(following)
        yield chain
    while after:  # rings
        chain = [*after.popitem()]
        while (following := after.pop(chain[-1], None)) is not None:
            chain.append(following)
        yield chain
