import pytest

from bubblemesh.run.warnings import poor_result


def figures(nodes=1000, boundary=100, quality=0.7):
    worst = [{"quality": quality, "at": (1.0, 2.0)}]
    return {"quality": {"worst": worst}, "nodes": nodes, "boundary_nodes": boundary}


def test_good_result_has_no_warnings():
    assert poor_result(figures(), 1000.0, packed_finer=False) == []


def test_poor_triangle_is_named():
    assert poor_result(figures(quality=0.1), 1000.0, packed_finer=False) == [
        "the worst triangle, at (1, 2), has a quality of 0.100 only"
    ]


@pytest.mark.parametrize(("nodes", "warned"), [(880, True), (920, False), (1140, False), (1160, True), (90, True)])
def test_node_count_is_compared_with_the_ideal_one(nodes, warned):
    assert bool(poor_result(figures(nodes, boundary=80), 1000.0, packed_finer=False)) == warned
    assert poor_result(figures(nodes, boundary=80), None, packed_finer=False) == []
    assert bool(poor_result(figures(nodes, boundary=80), 1000.0, packed_finer=True)) == (nodes < 900)


def test_mesh_without_inner_nodes_is_mentioned():
    assert poor_result(figures(50, boundary=50), 50.0, packed_finer=False) == [
        "all nodes are on the boundary: the spacing is too large for a node inside"
    ]
