"""Reading of plane triangles, their labels and their data from mesh files of any format.

There are several functions, for different purposes:

- `read_triangles`: triangles as the file has them, with everything else in the file,
- `read_mesh`: a mesh with labels, regions and data, in either orientation,
- `whole_mesh.whole_mesh`: a mesh that is counter-clockwise and has labels on all of its boundary,
- `inspection.inspected_triangles` and `inspection.inspected_mesh`: these two with notes on faults, to measure them,
- `fields.read_field` and `fields.read_nodal_field`: one field of data on triangles.
"""

from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, SMALLEST_EXTENT, Floats, Integers, first_rows
from bubblemesh.errors import BubblemeshError, CaseError, FileError, prefixed
from bubblemesh.files import is_confined, local_copy, opened, reason
from bubblemesh.meshes.edges import find_sides
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.quads import halved
from bubblemesh.meshfiles.curved_cells import curved_notes
from bubblemesh.meshfiles.groups import ENDS, cell_groups
from bubblemesh.meshfiles.merging import are_apart, places
from bubblemesh.meshfiles.names import named
from bubblemesh.meshfiles.sources.layers import flattened
from bubblemesh.meshfiles.sources.source import Block, Source
from bubblemesh.meshfiles.sources.table import SELF_CONTAINED, read_source
from bubblemesh.messages import LONGEST_REASON, cause, counted, place
from bubblemesh.records import record

EDGES = ("line", "line3")
NO_FACES = (*EDGES, "vertex")
NO_LABELS = "point 0", "no point"
PLANE = 1e-12  # of the extent
REAL = "iuf"  # kinds of NumPy types

# Corners of each kind of face.
TRIANGLES = {kind: [[0, 1, 2]] for kind in ("triangle", *(f"triangle{n}" for n in (6, 7, 10, 15, 21, 28, 36, 45, 55)))}
QUADS = {kind: [[0, 1, 2, 3]] for kind in ("quad", *(f"quad{n}" for n in (8, 9, 16, 25, 36, 49, 64, 81, 100)))}
CORNERS = TRIANGLES | QUADS
LINEAR = ("triangle", "quad")


@record
class MeshFile:
    """The triangles of a mesh file, and everything else in it."""

    path: Path
    points: Floats  # (n, 2) of the nodes that triangles use
    nodes: Integers  # (n,): numbers of these nodes in the file
    index: Integers  # (m,): index of each of the file's nodes among these, -1 for unused ones
    triangles: Integers  # (t, 3), in any orientation
    cells: Integers  # (t,): number of the part of a face, among all parts, to which each triangle belongs
    quads: Integers  # (q, 2): pairs of triangles that are a convex quadrilateral of the file
    left_out: tuple[str, ...]  # kinds of cells other than the requested faces, edges and points
    source: Source
    faces: tuple[int, ...]  # blocks of the source's cells to which the triangles belong

    @property
    def curved(self) -> tuple[str, ...]:
        """Notes on faces that may fold over because of nodes other than corners; FileError if a node is missing."""
        blocks = [self.source.cells[k] for k in self.faces]
        with prefixed(self.path):
            return curved_notes(self.source.points, [block for block in blocks if block.type not in LINEAR])


def read_triangles(
    path: Path,
    parts: Mapping[str, Sequence[Sequence[int]]] = CORNERS,
    refusal: str | None = None,
    *,
    as_they_are: bool = False,
) -> MeshFile:
    """Read the triangles of a mesh file.

    If each part has nodes of its own, nodes in the same place are merged.

    Parameters
    ----------
    path
        The file.
    parts
        For each kind of face, the parts into which it is cut, each by three or four of its nodes. Parts with four nodes
        are cut into two triangles along the better diagonal.
    refusal
        Text of an error for cells of other kinds, apart from edges and points; without it they are left out.
    as_they_are
        Whether nodes in the same place are not merged.

    Raises
    ------
    FileError
        If the file cannot be read, holds no triangles, is not plane, or has faulty points or cells.
    """
    source = _read(path)
    others = [block for block in source.cells if block.type not in (*parts, *NO_FACES)]
    refused = sorted({block.type for block in others if len(block.data)})
    if refusal is not None and refused:
        raise FileError(f"{path}: holds cells of the kind {', '.join(refused)}: {refusal}")
    faces = _blocks(source, parts)
    if not faces:
        raise FileError(f"{path}: holds no triangles")
    with prefixed(path):
        corners = [_parts(source.cells[k], parts) for k in faces]
    nodes = np.unique(np.concatenate([cells.ravel() for cells in corners]))
    if nodes[0] < 0 or nodes[-1] >= len(source.points):
        raise FileError(f"{path}: a triangle has a node that is not there: the file is damaged")
    points = np.asarray(source.points[nodes], float)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise FileError(f"{path}: its points have no two or three coordinates: the file is damaged")
    bad = ~(np.abs(points) <= LARGEST_NUMBER).all(axis=1)
    if bad.any():
        what = f"no number, or above {LARGEST_NUMBER:g}"
        raise FileError(f"{path}: node {nodes[bad][0]} has a coordinate that is {what}")
    if 0 < np.ptp(points, axis=0).max() <= SMALLEST_EXTENT:
        raise FileError(f"{path}: is smaller than {SMALLEST_EXTENT:g}: choose another unit of length")
    if np.ptp(points[:, 2:], axis=0).max(initial=0) > PLANE * np.ptp(points, axis=0).max():
        raise FileError(f"{path}: is a surface in space: only meshes in the xy plane are read")
    left_out = tuple(sorted({block.type for block in others}))
    points, group, used = points[:, :2], np.arange(len(nodes)), nodes
    if not as_they_are and are_apart(corners):
        with prefixed(path):
            _, first, group = np.unique(places(points, digits(source)), return_index=True, return_inverse=True)
        points, nodes = points[first], nodes[first]
    index = np.full(len(source.points), -1)
    index[used] = group.ravel()
    cut = [_triangles(path, points, index[cells]) for cells in corners]
    dented = sum(part.dented for part in cut)
    if dented:
        what = "1 quadrilateral is not convex" if dented == 1 else f"{dented} quadrilaterals are not convex"
        source = replace(source, notes=(*source.notes, f"{what}: triangles are read in their place"))
    triangles, cells, quads = _one_after_the_other(cut)
    return MeshFile(path, points, nodes, index, triangles, cells, quads, left_out, source, faces)


def _parts(block: Block, parts: Mapping[str, Sequence[Sequence[int]]]) -> Integers:
    """Nodes (p, 3) or (p, 4) of the parts of a block of cells; FileError if the cells do not have node numbers."""
    chosen, nodes = np.asarray(parts[block.type]), np.asarray(block.data)
    if nodes.dtype.kind not in REAL or nodes.ndim != 2 or nodes.shape[1] <= chosen.max():
        raise FileError(f"has cells of the kind {block.type} whose nodes are no numbers of nodes: it is damaged")
    return nodes.astype(np.int64, copy=False)[:, chosen].reshape(-1, chosen.shape[1])


class _Cut(NamedTuple):
    """Triangles (t, 3) of a block, the cell (t,) of each, pairs (q, 2) that are convex quadrilaterals, other pairs."""

    triangles: Integers
    cells: Integers
    quads: Integers
    whole: int  # cells
    dented: int


def _triangles(path: Path, points: Floats, cells: Integers) -> _Cut:
    """Triangles of cells (m, 3) or (m, 4); FileError if a quadrilateral has no area or crosses itself."""
    if cells.shape[1] == 3:
        return _Cut(cells, np.arange(len(cells)), np.zeros((0, 2), np.int64), len(cells), 0)
    found = halved(points, cells)
    if len(found.crossed):
        at = place(points[cells[found.crossed[0]]].mean(axis=0), float(np.ptp(points, axis=0).max()))
        raise FileError(f"{path}: a quadrilateral has no area or crosses itself at {at}: the file is damaged")
    return _Cut(found.triangles, found.cells, found.quads, len(cells), len(found.dented))


def _one_after_the_other(cut: Sequence[_Cut]) -> tuple[Integers, Integers, Integers]:
    """Triangles, their cells, and pairs of all blocks together."""
    triangles = np.cumsum([0, *(len(part.triangles) for part in cut)])
    cells = np.cumsum([0, *(part.whole for part in cut)])
    return (
        np.concatenate([part.triangles for part in cut]),
        np.concatenate([part.cells + k for part, k in zip(cut, cells, strict=False)]),
        np.concatenate([part.quads + k for part, k in zip(cut, triangles, strict=False)]),
    )


def digits(source: Source) -> float:
    """Rounding error of coordinates near 1, as a file holds them."""
    kind = np.asarray(source.points).dtype
    return float(np.finfo(kind if kind.kind == "f" else float).eps)


class MeshWithData(NamedTuple):
    """A mesh from a file with its data, by corners only; ``labels`` and ``regions`` are empty if the file has none."""

    mesh: Mesh  # in any orientation
    cell_data: Mapping[str, Floats]  # (t,) or (t, k)
    point_data: Mapping[str, Floats]  # (n,) or (n, k)
    left_out: tuple[str, ...]  # kinds of cells
    notes: tuple[str, ...] = ()  # on choices, such as the last of several times
    curved: tuple[str, ...] = ()  # notes on cells that may fold over because of nodes other than corners
    matching: tuple[Integers, ...] = ()  # nodes (k, 2) of two periodic sides each
    node_sets: tuple[str, ...] = ()  # names of sets of nodes, which are not read
    digits: float = float(np.finfo(float).eps)  # rounding error of coordinates near 1, as the file holds them
    ids: tuple[Mapping[str, int], ...] = ({}, {}, {})  # in the file, of labels, regions and labelled points with names


def read_mesh(path: Path) -> MeshWithData:
    """Read a mesh file's triangles, labelled edges, regions and data; the same errors as `read_triangles`.

    Quadrilaterals become two triangles each, with the data of their cell. Names that the file does not hold are taken
    from NAME.labels.json beside it.
    """
    file = read_triangles(path)
    source = named(file.source, path)
    file = replace(file, source=source)
    regions, region, region_ids = cell_groups(source, file.faces, "region")
    facets, label, labels, label_ids, stray = _facets(file)
    points, point, named_points, point_ids = _labelled_points(file)
    mesh = Mesh(
        file.points,
        file.triangles,
        facets,
        label,
        labels,
        regions=regions,
        triangle_regions=region[file.cells] if regions else region,
        labelled_nodes=points,
        node_labels=point,
        point_labels=named_points,
        quads=file.quads,
        open_labels=tuple(label for label in labels if label in source.open_sets),
        geographic=source.geographic,
    )
    point_data = {name: np.asarray(values)[file.nodes] for name, values in source.point_data.items()}
    matching = tuple(file.index[nodes] for nodes in source.matching)
    matching = tuple(nodes[(nodes >= 0).all(axis=1)] for nodes in matching)  # nodes on edges are not in triangles
    return MeshWithData(
        mesh,
        cell_data_of(file),
        _numbers(point_data),
        file.left_out,
        (*source.notes, *stray),
        file.curved,
        matching,
        source.node_sets,
        digits(source),
        (label_ids, region_ids, point_ids),
    )


def reading_notes(read: MeshWithData) -> list[str]:
    """Notes on what was chosen of a file, such as the last of several times, and on what was left out."""
    return [*read.notes, *read.curved, *left_out_notes(read.left_out)]


def left_out_notes(kinds: Sequence[str]) -> tuple[str, ...]:
    """A note on kinds of cells that are left out, if there are any."""
    return (f"cells that are no triangles or quadrilaterals are left out: {', '.join(kinds)}",) if kinds else ()


def _facets(file: MeshFile) -> tuple[Integers, Integers, tuple[str, ...], Mapping[str, int], tuple[str, ...]]:
    """Labelled edges (f, 2) by indices of used nodes, index (f,) of each edge's label, the labels, and their ids.

    Edges that no triangle has are left out, with a note; of those that are there twice with one label, the second.
    """
    source, blocks = file.source, _blocks(file.source, EDGES)
    labels, label, ids = cell_groups(source, blocks, "label")
    if not labels:
        return np.zeros((0, 2), np.int64), label, (), ids, ()
    edges = np.concatenate([source.cells[k].data[:, :2] for k in blocks]).astype(np.int64)
    if edges.min() < 0 or edges.max() >= len(source.points):
        raise FileError(f"{file.path}: an edge has a node that is not there: the file is damaged")
    edges = file.index[edges]
    used = np.flatnonzero((edges >= 0).all(axis=1))  # an edge with an unused node is not a side of a triangle
    ways = edges[used], edges[used, ::-1]
    sides = (find_sides(file.triangles, len(file.points), pairs)[0] for pairs in ways)
    kept = used[np.maximum(*sides) >= 0]
    stray = len(used) - len(kept)
    kept = kept[first_rows(np.column_stack([np.sort(edges[kept], axis=1), label[kept]]))]
    notes = (f"{counted(stray, 'labelled edge')} that no triangle has: left out",) if stray else ()
    numbers, label = np.unique(label[kept], return_inverse=True)
    return edges[kept], label, tuple(labels[k] for k in numbers), ids, notes


def _labelled_points(file: MeshFile) -> tuple[Integers, Integers, tuple[str, ...], Mapping[str, int]]:
    """Labelled nodes (v,) among the used ones, the index (v,) of each node's label, the labels, and their ids.

    Points of Gmsh without a group have the number 0; ends of periodic sides follow from the sides.
    """
    blocks = _blocks(file.source, ("vertex",))
    labels, label, ids = cell_groups(file.source, blocks, "point")
    if not labels:
        return np.zeros(0, np.int64), label, (), ids
    nodes = np.concatenate([file.source.cells[k].data[:, 0] for k in blocks]).astype(np.int64)
    if nodes.min() < 0 or nodes.max() >= len(file.source.points):
        raise FileError(f"{file.path}: a point has a node that is not there: the file is damaged")
    nodes = file.index[nodes]
    own = np.array([name not in NO_LABELS and name.rstrip("-") != ENDS for name in labels])
    kept = own[label] & (nodes >= 0)
    numbers, label = np.unique(label[kept], return_inverse=True)
    return nodes[kept], label, tuple(labels[k] for k in numbers), ids


def cell_data_of(file: MeshFile) -> dict[str, Floats]:
    """Data (t,) or (t, k) of the triangles of a file, by name, as far as the data of their cells are numbers."""
    data = file.source.cell_data.items()
    return _numbers({name: np.concatenate([np.asarray(of[k]) for k in file.faces])[file.cells] for name, of in data})


def _numbers(data: Mapping[str, Any]) -> dict[str, Floats]:
    """The arrays, by name, that hold real numbers or truth values."""
    return {name: values.astype(float) for name, values in data.items() if values.dtype.kind in REAL + "b"}


def _blocks(source: Any, kinds: Container[str]) -> tuple[int, ...]:
    """Numbers of the blocks of cells of some kinds that are not empty."""
    return tuple(k for k, block in enumerate(source.cells) if block.type in kinds and len(block.data))


def _read(path: Path) -> Source:
    """Read everything in a file, or the lower side of a layer of prisms; FileError if it cannot be read."""
    if is_confined() and path.suffix.lower() not in SELF_CONTAINED:
        raise CaseError(f"{path}: may name other files: an untrusted case gives data as {', '.join(SELF_CONTAINED)}")
    if path == Path("-") and not path.exists():
        raise FileError("-: a mesh is not read from the standard input: write it to a file first")
    with prefixed(path), opened(path) as stream:
        if not stream.peek(1):
            raise FileError("is empty")
    source = local_copy(path)
    try:
        with prefixed(path), np.errstate(invalid="raise"):  # NaN in place of a whole number
            return flattened(read_source(source))
    except BubblemeshError:
        raise
    except MemoryError:  # a wrong count may also ask for too much memory
        raise FileError(f"{path}: needs more memory than there is: it is damaged, or has to be thinned out") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {reason(error)}") from error
    except Exception as error:  # libraries raise all kinds of errors for damaged files
        raise FileError(f"{path}: is no mesh that can be read ({_reason(error)})") from error


def _reason(error: Exception) -> str:
    """Text on what an error of a reader, or of NumPy and h5py in it, means for the file."""
    if isinstance(error, IndexError):
        return "it ends too early, or holds less than it tells"
    if isinstance(error, UnicodeDecodeError):
        return "it holds bytes that are no text: it is damaged, or in binary form"
    told = cause(error, LONGEST_REASON)
    if isinstance(error, KeyError):
        return f"it is damaged, or what it needs is not known here: {told}"
    return f"its numbers are not as its format asks for: {told}" if isinstance(error, ValueError) else told
