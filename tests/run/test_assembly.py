"""A mesh of connected bubbles has the labels of its domain."""

import numpy as np

from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import InnerParts
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import InnerPoint
from bubblemesh.packing.net import connect_inside
from bubblemesh.packing.placement.diffusion import ErrorDiffusion
from bubblemesh.run.assembly import mesh_of
from bubblemesh.spacing.expression import Expression
from bubblemesh.spacing.spacing import Spacing


def test_labelled_points_are_nodes_however_many_there_are():
    compared = []

    class Name(str):
        __hash__ = str.__hash__

        def __eq__(self, other):
            compared.append(self)
            return super().__eq__(other)

    names = [Name(f"well {k}") for k in range(300)]
    points = tuple(
        InnerPoint((0.1 + 0.8 * (k % 20) / 20, 0.1 + 0.8 * (k // 20) / 15), name) for k, name in enumerate(names)
    )
    domain, spacing = (
        Domain.of(rings.rectangle(0, 0, 1, 1), parts=InnerParts(points=points)),
        Spacing(Expression.parse("0.05")),
    )
    net = connect_inside(ErrorDiffusion()(domain, spacing, 10_000), domain, spacing)
    compared.clear()
    mesh = mesh_of(net, domain)
    assert len(compared) < 10 * len(names)
    assert [mesh.point_labels[k] for k in mesh.node_labels] == names
    np.testing.assert_allclose(mesh.points[mesh.labelled_nodes], [point.at for point in points])
