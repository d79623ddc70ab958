"""Groups in mesh files: ids and names for labels of edges, regions of triangles and labelled points."""

import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import CaseError
from bubblemesh.files import FORBIDDEN, LARGEST_ID, LONGEST_NAME, is_writable
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshes.periodic import motion_data
from bubblemesh.meshes.quads import Cells
from bubblemesh.meshfiles.text import dumped

LABELS_FILE = ".labels.json"
NOTHING_KEPT: Mapping[str, Mapping[str, str]] = {}
PARTITION, NODE_OWNER = "partition", "owner"  # data of triangles and of nodes: the part that has each
GLOBAL_NODE, GLOBAL_CELL = "GlobalNodeId", "GlobalElementId"  # data of pieces: numbers in the whole mesh
ALL_NODES, ALL_ELEMENTS = "NALL", "EALL"  # sets in files for CalculiX, of this package and of its own mesher
ENDS = "periodic-ends"  # name of the points where periodic sides meet others
LARGEST_TAG = 2**53  # above, floating-point numbers do not hold all integers
LONGEST_WORD = 60  # characters of a plain word; CalculiX and Abaqus allow 80

Fields = Mapping[str, Floats]
"""Values for each triangle, (t,) arrays by name."""


class Group(NamedTuple):
    """Id of a label, a region or a labelled point, from 1, and the dimension of its cells."""

    id: int
    dimension: int


KINDS_OF_GROUPS = {0: "points", 1: "labels", 2: "regions"}  # by their dimension


# meshio's names of facets and cells, by the number of their nodes.
FACET_KINDS = {2: "line", 3: "line3"}
CELL_KINDS = {3: "triangle", 6: "triangle6", 4: "quad", 9: "quad9"}


# Numbers of groups count labels, then regions, then labelled points, from 1. They are the ids of the groups, so that
# readers may know groups by id alone, unless the mesh has ids of its own.


def facet_numbers(mesh: Mesh) -> Integers:
    """Return the (f,) numbers of the facets' labels among all groups."""
    return mesh.facet_labels.astype(np.int64) + 1


def region_numbers(mesh: Mesh) -> Integers:
    """Return the (t,) numbers of the triangles' regions among all groups."""
    return mesh.triangle_regions.astype(np.int64) + 1 + len(mesh.labels)


def node_numbers(mesh: Mesh) -> Integers:
    """Return the (v,) numbers of the labelled points among all groups."""
    return mesh.node_labels.astype(np.int64) + 1 + len(mesh.labels) + len(mesh.regions)


def facet_ids(mesh: Mesh) -> Integers:
    """Return the (f,) ids of the facets' labels."""
    return _ids_at(mesh, facet_numbers(mesh))


def region_ids(mesh: Mesh) -> Integers:
    """Return the (t,) ids of the triangles' regions."""
    return _ids_at(mesh, region_numbers(mesh))


def node_ids(mesh: Mesh) -> Integers:
    """Return the (v,) ids of the labelled points."""
    return _ids_at(mesh, node_numbers(mesh))


def _ids_at(mesh: Mesh, numbers: Integers) -> Integers:
    """Ids (m,) of groups by their numbers (m,)."""
    return numbers if not mesh.ids else ids_of_groups(mesh)[numbers - 1]


def ids_of_groups(mesh: Mesh) -> Integers:
    """Return the (g,) ids of all groups, in the order of their numbers."""
    return np.array([group.id for group in group_names(mesh).values()], np.int64)


def free_id(mesh: Mesh) -> int:
    """An id that no group has."""
    ids = ids_of_groups(mesh).tolist()
    return next(_unused_ids(len(ids), set(ids)))


def _unused_ids(groups: int, taken: Collection[int]) -> Iterator[int]:
    """Ids above the numbers of so many groups, without those that are taken."""
    return (number for number in count(groups + 1) if number not in taken)


def cell_ids(mesh: Mesh, cells: Cells) -> Integers:
    """Return the (m,) region ids of cells of a mesh."""
    return region_ids(mesh)[cells.triangles[:, 0]]


def cell_values(values: Floats, cells: Cells) -> Floats:
    """Return the (m,) values of cells: those (t,) of the triangles, of two halves their mean."""
    return np.asarray(values, float)[cells.triangles].mean(axis=1)


def point_ids(mesh: Mesh) -> Integers:
    """Return the (n,) id of each node: that of its own label, else of a facet at it, else 0."""
    ids = np.zeros(len(mesh.points), np.int64)
    for ends in mesh.facets.T[1::-1]:
        ids[ends] = facet_ids(mesh)
    ids[mesh.labelled_nodes] = node_ids(mesh)
    return ids


def group_names(mesh: Mesh) -> dict[str, Group]:
    """Groups of the labels, regions and labelled points by their names, in the order of their numbers.

    CaseError if a name does not fit all formats, or if two labels, two regions or two points have the same name or id.
    """
    dimensions = named_groups(mesh.labels, mesh.regions, mesh.point_labels)
    ids = ids_with_own(dimensions, mesh.ids)
    return {name: Group(k, dimension) for k, (name, dimension) in zip(ids, dimensions.items(), strict=True)}


def named_groups(labels: Sequence[str], regions: Sequence[str], points: Sequence[str]) -> dict[str, int]:
    """Dimensions of the groups of labels, regions and labelled points by their names, in the order of their numbers.

    CaseError if a name does not fit all formats, or if two labels, two regions or two points have the same one.
    """
    kinds = {1: labels, 2: regions, 0: points}
    for names in kinds.values():
        twice = next((name for name, times in Counter(names).items() if times > 1), None)
        if twice is not None:
            raise CaseError(f"the name {twice!r} is there twice: give all that belong to it the same index")
        bad = next((name for name in names if not is_writable(name)), None)
        if bad is not None:
            raise CaseError(
                f"the label {bad!r} cannot be written to a mesh file: use a name of at most {LONGEST_NAME} "
                f"characters without {FORBIDDEN}"
            )
    dimensions = (dimension for dimension, names in kinds.items() for _ in names)
    return dict(zip(_different(labels, regions, points), dimensions, strict=True))


def _different(labels: Sequence[str], regions: Sequence[str], points: Sequence[str]) -> list[str]:
    """Names of all groups: as readers keep one group for each, those that another one has become longer."""
    found: dict[str, None] = {}
    for names, suffix in ((labels, ""), (regions, "_region"), (points, "_point")):
        taken = {*found, *names}
        for name in names:
            free = _unused(name, suffix, taken) if name in found else name
            found[free] = None
            taken.add(free)
    return list(found)


def with_ids_as_read(mesh: Mesh, ids: Sequence[Mapping[str, int]]) -> Mesh:
    """The mesh with the ids that a file has for its labels, regions and points, unless they are numbers from 1."""
    kinds = mesh.labels, mesh.regions, mesh.point_labels
    known = [of_kind.get(name) for of_kind, names in zip(ids, kinds, strict=True) for name in names]
    if all(number in (None, k) for k, number in enumerate(known, start=1)):
        return mesh
    names = zip(_different(*kinds), known, strict=True)
    return replace(mesh, ids={name: number for name, number in names if number is not None})


def ids_with_own(dimensions: Mapping[str, int], own: Mapping[str, int]) -> list[int]:
    """Ids of all groups of `named_groups`, in the order of their numbers; some have ids of their own, by their names.

    The others have their numbers, or, where another group has that id, one above all numbers. CaseError if two groups
    of a dimension have the same id of their own; names of no group do not count.
    """
    if not own:
        return list(range(1, len(dimensions) + 1))
    first: dict[Group, str] = {}
    for name in own.keys() & dimensions.keys():
        other = first.setdefault(Group(own[name], dimensions[name]), name)
        if other != name:
            kind, (one, two) = KINDS_OF_GROUPS[dimensions[name]], sorted([name, other])
            raise CaseError(f"{one!r} and {two!r} have the same id {own[name]}: {kind} need different ones")
    taken = {group.id for group in first}
    spare = _unused_ids(len(dimensions), taken)
    numbered = enumerate(dimensions, start=1)
    return [own[name] if name in own else next(spare) if number in taken else number for number, name in numbered]


def _unused(name: str, suffix: str, taken: Collection[str]) -> str:
    while name in taken:
        name += suffix
    return name


def as_they_are(mesh: Mesh) -> dict[str, str]:
    """Return the names of all groups, each as its own spelling."""
    return {name: name for name in group_names(mesh)}


def plain_words(mesh: Mesh, reserved: Iterable[str] = (), dimensions: Iterable[int] = (0, 1, 2)) -> dict[str, str]:
    """For the name of each group of the given dimensions, a word of letters, digits, ``_`` and ``-``.

    The words begin with a letter, and differ by more than case, which some readers ignore. No word is a reserved one;
    these are given in upper case.
    """
    words: dict[str, str] = {}
    taken = set(reserved)
    for name, group in group_names(mesh).items():
        if group.dimension not in dimensions:
            continue
        bare = re.sub(r"[\u0300-\u036f]", "", unicodedata.normalize("NFKD", name))  # letters without their accents
        word = re.sub(r"[^A-Za-z0-9_-]", "_", bare)[:LONGEST_WORD]
        if not re.match(r"[A-Za-z]", word):
            word = f"group_{word}"
        while word.upper() in taken:
            word = f"{word}_{group.id}"
        words[name] = word
        taken.add(word.upper())
    return words


def names_of_points(mesh: Mesh) -> list[str]:
    """Return the names of the groups of the labelled points, in the order of their labels."""
    return [name for name, group in group_names(mesh).items() if group.dimension == 0]


def labels_text(
    mesh: Mesh,
    spellings: Mapping[str, Mapping[str, str] | None],
    *,
    complete: bool,
    kept: Mapping[str, Mapping[str, str]] = NOTHING_KEPT,
) -> str | None:
    """Text of the sidecar: id and dimension of each group by name, and its name in formats that spell it differently.

    Labelled points have the numbers of their nodes, from 0; periodic sides the label of their counterpart and the shift
    to it, or the angle in degrees and the centre of the turn to it.

    Parameters
    ----------
    mesh
        The mesh.
    spellings
        For each format that is written, the spelling of each name; None if it has ids only.
    complete
        Whether all formats hold the labelled points and periodic pairs of the mesh.
    kept
        Spellings by format of each name in files that were written before, and stay.

    Returns
    -------
    str or None
        None if no sidecar is needed, since every format holds everything, with the names as they are.
    """
    more = _places(mesh) | _counterparts(mesh)
    entries = {}
    for number, (name, group) in enumerate(group_names(mesh).items(), start=1):
        other = {form: words[name] for form, words in spellings.items() if words and words.get(name, name) != name}
        written = {**kept.get(name, {}), **other}
        entries[name] = group._asdict() | more.get(number, {}) | ({"written": written} if written else {})
    if complete and None not in spellings.values() and not any("written" in entry for entry in entries.values()):
        return None
    return dumped(entries, indent=2) + "\n"


def _places(mesh: Mesh) -> dict[int, dict[str, Any]]:
    """Nodes of the labelled points, by the numbers of their groups."""
    found: dict[int, dict[str, Any]] = {}
    for number, node in zip(node_numbers(mesh).tolist(), mesh.labelled_nodes.tolist(), strict=True):
        found.setdefault(number, {"nodes": []})["nodes"].append(node)
    return dict(sorted(found.items()))


def _counterparts(mesh: Mesh) -> dict[int, dict[str, Any]]:
    """Counterparts of the periodic sides, by the numbers of their labels."""
    found: dict[int, dict[str, Any]] = {}
    for sides in mesh.periodic_sides:
        for one, other, sign in ((sides.first, sides.second, 1), (sides.second, sides.first, -1)):
            found[one + 1] = {"periodic": {"with": mesh.labels[other], **motion_data(sides.motion, sign)}}
    return found


# Names of the numbers of groups in readers of meshio and writers of this package.
TAGS = ("gmsh:physical", "medit:ref", "su2:tag", "cell_tags", "material", "label")
POINT_TAGS = ("point_tags", "node_groups")  # the same of nodes: those of MED, of SfePy
# Names of data that are numbers of groups and parts in formats, solvers and writers of this package.
KEPT = {*TAGS, *POINT_TAGS, "mat_id", "attribute", "Label", PARTITION, NODE_OWNER, GLOBAL_NODE, GLOBAL_CELL}
DIMENSIONS = {"point": 0, "label": 1, "region": 2}


class CellGroups(NamedTuple):
    """Names of the groups of cells in a file, and the index (c,) of each cell's group; empty if it has none."""

    names: tuple[str, ...]
    of_cells: Integers
    ids: Mapping[str, int]  # of those whose ids are known by their names


def cell_groups(mesh: Any, blocks: Sequence[int], noun: str) -> CellGroups:
    """Groups of the cells in some blocks.

    The blocks of a `meshio.Mesh` are given by their numbers, all with the same kind of group. Groups without a name are
    called by the ``noun`` (point, label or region) and their number.
    """
    for name in TAGS:
        if blocks and name in mesh.cell_data:
            tags = np.concatenate([np.asarray(mesh.cell_data[name][k]) for k in blocks])
            if tags.ndim == 1 and np.array_equal(tags, np.round(tags)) and (np.abs(tags) <= LARGEST_TAG).all():
                numbers, index = np.unique(tags.astype(np.int64), return_inverse=True)
                names = [_name(mesh, int(number), noun) for number in numbers]
                different = {name: k for k, name in enumerate(dict.fromkeys(names))}  # families of MED may share groups
                index = np.array([different[name] for name in names], np.int64)[index]
                return CellGroups(tuple(different), index, _ids_of(mesh, different, noun))
    return _of_sets(mesh, blocks, noun)


def _ids_of(mesh: Any, names: Collection[str], noun: str) -> dict[str, int]:
    """Ids that a file, or that of labels beside it, gives groups by their names."""
    known = ((str(name), int(number)) for name, (number, kind) in mesh.field_data.items() if kind == DIMENSIONS[noun])
    return {name: number for name, number in known if name in names and 0 < number <= LARGEST_ID}


def _name(mesh: Any, tag: int, noun: str) -> str:
    for name, (number, dimension) in mesh.field_data.items():
        if (number, dimension) == (tag, DIMENSIONS[noun]):
            return str(name)
    names = getattr(mesh, "cell_tags", {}).get(tag)  # of MED files
    return ", ".join(names) if names else f"{noun} {tag}"


def _of_sets(mesh: Any, blocks: Sequence[int], noun: str) -> CellGroups:
    """Groups by the sets of cells that the file names; a cell in several sets belongs to the smallest."""
    counts = [len(mesh.cells[k].data) for k in blocks]
    start = np.cumsum([0, *counts])
    sets = {}
    for name, chosen in mesh.cell_sets.items():
        members = [start[i] + np.asarray(chosen[k], np.int64) for i, k in enumerate(blocks) if chosen[k] is not None]
        cells = np.concatenate([np.zeros(0, np.int64), *members])
        if len(cells):
            sets[str(name)] = cells
    if not sets:
        return CellGroups((), np.zeros(0, np.int64), {})
    names = sorted(sets, key=lambda name: -len(sets[name]))
    index = np.full(start[-1], -1)
    for number, name in enumerate(names):
        index[sets[name]] = number
    present, index = np.unique(index, return_inverse=True)
    groups = tuple(f"no {noun}" if k < 0 else names[k] for k in present)
    return CellGroups(groups, index, _ids_of(mesh, groups, noun))
