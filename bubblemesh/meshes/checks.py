"""Arrays that meshes and data on them are given by, checked for what they are to be."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, Booleans, Floats, Integers, first_rows, unmasked
from bubblemesh.errors import CaseError
from bubblemesh.files import LARGEST_ID
from bubblemesh.meshes.partition import Partition
from bubblemesh.meshes.quads import require_pairs
from bubblemesh.messages import counted, either, shown

if TYPE_CHECKING:
    from bubblemesh.meshes.mesh import Mesh

Shape = tuple[int | str, ...]  # a letter stands for any length
KINDS = {"whole numbers": "iu", "real numbers": "iuf", "numbers": "iufc"}  # as NumPy knows them
LARGEST_FLOAT = float(np.finfo(float).max)


def checked(mesh: "Mesh") -> dict[str, Any]:
    """Fields of a mesh, with arrays in place of lists; CaseError, which names the field, if one is not as it must be.

    Depths and data of triangles may be missing somewhere, as NaN. Each array is looked through twice at most, which
    takes next to nothing beside what makes a mesh.
    """
    points = finite(mesh.points, "points", ("n", 2))
    n = len(points)
    triangles = indices(mesh.triangles, "triangles", n, "node", ("t", 3), ("t", 6))
    t, order = len(triangles), triangles.shape[1] // 3
    facets = indices(mesh.facets, "facets", n, "node", ("f", 1 + order))
    f = len(facets)
    labels, regions = texts(mesh.labels, "labels"), texts(mesh.regions, "regions")
    most = max(len(regions), 1)  # a file may have no regions, and all of its triangles the index 0
    region = indices(mesh.triangle_regions, "triangle_regions", most, "region", (t,), (0,))
    middles = finite(mesh.facet_middles, "facet_middles", (f, 2), (0, 2))
    labelled = indices(mesh.labelled_nodes, "labelled_nodes", n, "node", ("v",))
    point_labels = texts(mesh.point_labels, "point_labels")
    quads = indices(mesh.quads, "quads", t, "triangle", ("q", 2))
    require_pairs(triangles, quads)
    curved = indices(mesh.curved_edges, "curved_edges", n, "node", ("c", 2))
    _require_partition(mesh.partition, t)
    if not isinstance(mesh.geographic, bool | np.bool_):
        raise CaseError(f"geographic: must be True or False (found {shown(repr(mesh.geographic))})")
    return {
        "points": points,
        "triangles": triangles,
        "facets": facets,
        "facet_labels": indices(mesh.facet_labels, "facet_labels", len(labels), "label", (f,)),
        "labels": labels,
        "regions": regions,
        "triangle_regions": region if len(region) else np.zeros(t, np.int64),
        "labelled_nodes": labelled,
        "node_labels": indices(mesh.node_labels, "node_labels", len(point_labels), "point label", (len(labelled),)),
        "point_labels": point_labels,
        "facet_middles": middles if len(middles) else points[facets[:, :2]].mean(axis=1),
        "periodic": indices(mesh.periodic, "periodic", f, "facet", ("p", 2)),
        "quads": quads,
        "curved_edges": curved,
        "curved_middles": finite(mesh.curved_middles, "curved_middles", (len(curved), 2)),
        "depth": real_numbers(mesh.depth, "depth", (n,), (0,)),
        "metric": finite(mesh.metric, "metric", (n, 3), (0, 3), largest=LARGEST_FLOAT),
        "open_labels": texts(mesh.open_labels, "open_labels"),
        "ids": _ids(mesh.ids),
        "fields": _fields(mesh.fields, t),
    }


def require_triangles(mesh: "Mesh") -> None:
    """Check that there is something to measure and to draw; CaseError if there is not."""
    if len(mesh.triangles) == 0:
        raise CaseError("triangles: the mesh has none: only one with triangles has a quality and a picture")


def require_edges(mesh: "Mesh") -> None:
    """Check that facets are edges with a triangle on their left, each once for a label.

    CaseError with the first that is not: it would be another edge, or none, for what takes the mesh.
    """
    nodes, right = mesh.facets[:, :2], mesh.sides[:, 0] < 0
    for wrong, told in (
        (right & ~mesh.outer, "have no edge: leave it out"),
        (right, "have their triangle on the right: it has to be counter-clockwise, as its edges have to be"),
        (_again(np.column_stack([np.sort(nodes, axis=1), mesh.facet_labels])), "are there twice with the same label"),
    ):
        if wrong.any():
            row = int(np.argmax(wrong))
            raise CaseError(f"facets: the nodes {nodes[row].tolist()} in row {row} {told}")


def _again(rows: Integers) -> Booleans:
    """Mask (n,) of the rows (n, m) that equal one before them."""
    again = np.ones(len(rows), bool)
    again[first_rows(rows)] = False
    return again


def array_of(given: Any, name: str, what: str, *shapes: Shape) -> Any:
    """Array of a kind of numbers in ``KINDS``, of one of the shapes, with NaN where a masked one hides them.

    An empty list stands for a table without rows. CaseError, which begins with the name, for anything else.
    """
    try:
        values = np.asarray(unmasked(given))
    except (TypeError, ValueError):
        raise CaseError(f"{name}: must be an array of {what} (found rows of unequal length, or no numbers)") from None
    if values.shape == (0,):  # which NumPy takes for real numbers
        values = np.zeros((0, *(length for length in shapes[0][1:] if isinstance(length, int))), np.int64)
    if values.dtype.kind not in KINDS[what] or not any(_fits(values.shape, shape) for shape in shapes):
        found = shown(repr(given)) if values.ndim == 0 else f"the shape {values.shape}, type {values.dtype}"
        raise CaseError(
            f"{name}: must be {what} of shape {either([*dict.fromkeys(map(_written, shapes))])} (found {found})"
        )
    return values


def indices(given: Any, name: str, count: int, noun: str, *shapes: Shape) -> Integers:
    """Array of one of the shapes, of indices of ``count`` things that the noun names; CaseError for anything else."""
    values: Integers = array_of(given, name, "whole numbers", *shapes).astype(np.int64, copy=False)
    if values.size and (values.min() < 0 or values.max() >= count):
        place, found = _first(values, (values < 0) | (values >= count))
        raise CaseError(f"{name}: must be indices of {counted(count, noun)}, from 0 on (found {found} in row {place})")
    return values


def finite(given: Any, name: str, *shapes: Shape, largest: float = LARGEST_NUMBER) -> Floats:
    """Array of one of the shapes, of real numbers that are not above the ``largest``; CaseError for anything else."""
    values = real_numbers(given, name, *shapes)
    if values.size and not (values.min() >= -largest and values.max() <= largest):  # neither holds for NaN
        place, found = _first(values, ~(np.abs(values) <= largest))
        raise CaseError(f"{name}: must be finite and at most {largest:g} (found {found:g} in row {place})")
    return values


def real_numbers(given: Any, name: str, *shapes: Shape) -> Floats:
    """Array of one of the shapes, of real numbers, among them NaN; CaseError for anything else."""
    values: Floats = array_of(given, name, "real numbers", *shapes).astype(float, copy=False)
    return values


def texts(given: Any, name: str) -> tuple[str, ...]:
    """The texts of a sequence; CaseError, which begins with the name, if it is none, or something in it is no text."""
    if isinstance(given, str) or not isinstance(given, Sequence) or not all(isinstance(text, str) for text in given):
        raise CaseError(f"{name}: must be a list of texts (found {shown(repr(given))})")
    return tuple(given)


def _fits(found: tuple[int, ...], shape: Shape) -> bool:
    """Whether an array has a shape."""
    return len(found) == len(shape) and all(isinstance(m, str) or m == k for k, m in zip(found, shape, strict=True))


def _written(shape: Shape) -> str:
    """A shape as Python writes it, with letters for lengths that are open: (n, 2)."""
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"


def _first(values: Any, bad: Any) -> tuple[int, Any]:
    """Row of the first bad one of values (n,) or (n, k), and that value."""
    first = int(np.argmax(bad))
    return first // (values.size // len(values)), values.flat[first]


def _fields(fields: Any, triangles: int) -> dict[str, Floats]:
    """Data of the triangles by their names."""
    if not isinstance(fields, Mapping):
        raise CaseError(f"fields: must be a mapping of names to arrays (found {shown(repr(fields))})")
    names = texts([*fields], "fields")
    return {name: real_numbers(fields[name], f"fields: {name}", (triangles,)) for name in names}


def _ids(ids: Any) -> dict[str, int]:
    """Ids by names."""
    if not isinstance(ids, Mapping):
        raise CaseError(f"ids: must be a mapping of names to ids (found {shown(repr(ids))})")
    for name in texts([*ids], "ids"):
        number = ids[name]
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or not 0 < number <= LARGEST_ID:
            found = shown(repr(number))
            raise CaseError(f"ids: {name}: must be a whole number from 1 to {LARGEST_ID} (found {found})")
    return {name: int(number) for name, number in ids.items()}


def _require_partition(partition: Any, triangles: int) -> None:
    """Check that there is no partition, or one of so many triangles."""
    if partition is None:
        return
    if not isinstance(partition, Partition):
        raise CaseError(f"partition: must be a Partition or None (found {shown(repr(partition))})")
    if len(partition.owner) != triangles:
        found = f"one of {counted(len(partition.owner), 'triangle')}"
        raise CaseError(f"partition: must be one of {counted(triangles, 'triangle')} (found {found})")
