"""Partitions for parallel solvers, against plain loops on small meshes."""

import dataclasses
import subprocess
import sys
from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from paths import ROOT
from squares import holed_square

from bubblemesh.errors import CaseError
from bubblemesh.meshes import division
from bubblemesh.meshes.division import by_geometry, largest_size
from bubblemesh.meshes.edges import neighbour_pairs
from bubblemesh.meshes.partition import Partition


def two_squares():
    """Triangles of two pieces that share no node."""
    mesh = holed_square(6)
    points = np.vstack([mesh.points, mesh.points + 10])
    return points, np.vstack([mesh.triangles, mesh.triangles + len(mesh.points)])


def plain():
    mesh = holed_square(9)
    return mesh.points, mesh.triangles


def curved():
    mesh, _ = holed_square(6).second_order()
    return mesh.points, mesh.triangles


@pytest.fixture(params=["METIS", "geometry"])
def way(request, monkeypatch):
    """Both ways to divide, of which the second is that without pymetis."""
    if request.param == "geometry":
        monkeypatch.setattr(division, "find_spec", lambda name: None)
    else:
        pytest.importorskip("pymetis")
    return request.param


def shared_edges(triangles):
    """Pairs of triangles of each edge that two have."""
    found = {}
    for k, (a, b, c) in enumerate(triangles[:, :3].tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            found.setdefault(frozenset(edge), []).append(k)
    return [tuple(pair) for pair in found.values() if len(pair) == 2]


def pieces(triangles, chosen):
    """Number of pieces that some triangles are of, by walking over shared edges."""
    beside = {k: set() for k in chosen}
    for i, j in shared_edges(triangles):
        if i in beside and j in beside:
            beside[i].add(j)
            beside[j].add(i)
    left, count = set(chosen), 0
    while left:
        ahead, count = [left.pop()], count + 1
        while ahead:
            new = beside[ahead.pop()] & left
            left -= new
            ahead += new
    return count


@pytest.mark.parametrize("count", [1, 2, 3, 8, 20])
@pytest.mark.parametrize("made", [plain, curved, two_squares])
def test_all_that_follows_from_the_owners_is_what_loops_find(way, made, count):
    points, triangles = made()
    partition = Partition.of(points, triangles, count)
    assert partition.by == way
    owner = partition.owner.tolist()
    assert len(owner) == len(triangles)
    at = [Counter() for _ in points]
    for triangle, part in zip(triangles.tolist(), owner, strict=True):
        for node in triangle:
            at[node][part] += 1
    assert partition.node_owner.tolist() == [min(c, key=lambda part: (-c[part], part)) for c in at]
    assert all(part in c for part, c in zip(partition.node_owner.tolist(), at, strict=True))
    corners = triangles[:, :3].tolist()
    halos = [
        [k for k in range(len(corners)) if owner[k] != part and any(part in at[node] for node in corners[k])]
        for part in range(count)
    ]
    assert [partition.halo(part).tolist() for part in range(count)] == halos
    assert partition.ghosts.tolist() == [[part, k] for part in range(count) for k in halos[part]]
    shared = [(a, b, node) for node, c in enumerate(at) for a, b in combinations(sorted(c), 2)]
    assert list(map(tuple, partition.interfaces.tolist())) == sorted(shared)
    cut = sum(owner[i] != owner[j] for i, j in shared_edges(triangles))
    sizes = [owner.count(part) for part in range(count)]
    assert partition.cut == cut
    assert partition.figures() == {
        "parts": count,
        "by": way,
        "triangles": {"min": min(sizes), "max": max(sizes)},
        "imbalance": pytest.approx(max(sizes) * count / len(owner) - 1),
        "edge_cut": cut,
        "shared_nodes": sum(len(c) > 1 for c in at),
        "halo": {"min": min(map(len, halos)), "max": max(map(len, halos)), "total": sum(map(len, halos))},
        "in_several_pieces": sum(
            pieces(triangles, [k for k in range(len(owner)) if owner[k] == part]) > 1 for part in range(count)
        ),
    }


@pytest.mark.parametrize("part", [3, -1, 1.5, None])
def test_there_is_no_halo_of_other_parts(part):
    partition = holed_square().partitioned(3).partition
    assert len(partition.halo(np.int32(2)))
    with pytest.raises(CaseError, match=r"halo: must be a part, from 0 to 2 \(found "):
        partition.halo(part)


def test_neighbours_are_pairs_that_share_an_edge_in_whichever_way_they_turn():
    _, triangles = plain()
    triangles[::3] = triangles[::3, ::-1]
    pairs = neighbour_pairs(triangles)
    assert sorted(map(sorted, pairs.tolist())) == sorted(map(sorted, shared_edges(triangles)))


@pytest.mark.parametrize("cells", [12, 60])
@pytest.mark.parametrize("count", [2, 5, 16, 37])
def test_parts_are_balanced(way, cells, count):
    mesh = holed_square(cells)
    sizes = Partition.of(mesh.points, mesh.triangles, count).sizes
    mean = len(mesh.triangles) / count
    assert sizes.sum() == len(mesh.triangles)
    assert sizes.min() >= 1
    assert sizes.max() <= (np.ceil(mean) if way == "geometry" else np.ceil(1.03 * mean))
    assert largest_size(len(mesh.triangles), count) == np.ceil(1.03 * mean)


@pytest.mark.parametrize(("cells", "count"), [(30, 100), (60, 23), (60, 200)])
def test_the_parts_of_metis_are_of_one_piece(cells, count):
    pytest.importorskip("pymetis")
    mesh = holed_square(cells)
    figures = Partition.of(mesh.points, mesh.triangles, count).figures()
    assert (figures["by"], figures["in_several_pieces"]) == ("METIS", 0)


def test_metis_cuts_fewer_edges_than_geometry(monkeypatch):
    pytest.importorskip("pymetis")
    mesh = holed_square(60)
    cut = Partition.of(mesh.points, mesh.triangles, 23).cut
    monkeypatch.setattr(division, "find_spec", lambda name: None)
    assert cut < Partition.of(mesh.points, mesh.triangles, 23).cut


@pytest.mark.parametrize("made", [plain, two_squares])
def test_each_triangle_may_be_a_part(way, made):
    points, triangles = made()
    partition = Partition.of(points, triangles, len(triangles))
    assert sorted(partition.owner.tolist()) == list(range(len(triangles)))
    assert partition.cut == len(shared_edges(triangles))


def test_two_parts_of_two_pieces_need_no_cut():
    points, triangles = two_squares()
    assert Partition.of(points, triangles, 2).cut == 0


@pytest.mark.parametrize("count", range(16, 65, 3))
def test_parts_of_few_triangles_are_balanced_by_whatever_divides_them(count):
    mesh = holed_square(6)
    partition = Partition.of(mesh.points, mesh.triangles, count)
    assert 1 <= partition.sizes.min() <= partition.sizes.max() <= np.ceil(1.03 * len(mesh.triangles) / count)
    assert (partition.reason is None) == (partition.by == "METIS")


def test_parts_of_a_part_are_refused():
    with pytest.raises(CaseError, match="the number of parts must be a whole one"):
        holed_square(9).partitioned(2.5)


@pytest.mark.parametrize("count", [-1, 0, 145])
def test_other_numbers_of_parts_are_refused(count):
    with pytest.raises(CaseError, match=f"a mesh of 144 triangles has from 1 to 144 parts, not {count}"):
        holed_square(9).partitioned(count)


def test_without_pymetis_the_reason_is_told(monkeypatch):
    monkeypatch.setattr(division, "find_spec", lambda name: None)
    partition = holed_square(9).partitioned(4).partition
    assert partition.by == "geometry"
    assert "pip install" in partition.reason


def test_where_metis_gives_empty_or_large_parts_geometry_divides(monkeypatch):
    pytest.importorskip("pymetis")
    monkeypatch.setattr(division, "by_metis", lambda neighbours, weights, count: np.zeros(len(weights), int))
    partition = holed_square(9).partitioned(4).partition
    assert partition.by == "geometry"
    assert partition.reason == "the parts of METIS have 0 to 144 triangles, of 36 on average"


@pytest.mark.parametrize("turn", [0.0, 0.3, np.pi / 2, 2.0])
def test_a_long_strip_is_cut_across_wherever_it_leads(turn):
    along = np.linspace(0, 10, 400)
    places = np.column_stack([along, np.tile([0, 0.1], 200)])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    owner = by_geometry(places @ rotation.T, np.ones(400, int), 4)
    assert (np.diff(owner) != 0).sum() == 3
    assert np.bincount(owner).tolist() == [100] * 4


def test_the_same_mesh_has_the_same_partition_in_another_process():
    code = "from squares import holed_square; print(holed_square(30).partitioned(7).partition.owner.tolist())"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT / "tests")
    assert run.stdout == f"{holed_square(30).partitioned(7).partition.owner.tolist()}\n"


def test_a_mesh_of_second_order_keeps_its_partition():
    mesh = holed_square(6).partitioned(5)
    curved, _ = mesh.second_order()
    assert curved.partition.owner.tolist() == mesh.partition.owner.tolist()
    again = dataclasses.replace(curved, partition=None).partitioned(5).partition
    assert curved.partition.node_owner.tolist() == again.node_owner.tolist()
    assert len(again.node_owner) == len(curved.points)
