"""Ellipses along a bent front, and how they and others are packed."""

import numpy as np
from metrics import tensor_metric

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.tensors import of_axes
from bubblemesh.packing.ellipses.net import flipped_net
from bubblemesh.packing.methods import METHODS
from bubblemesh.packing.rounds import rounds

METHOD = METHODS["ellipses"]
SQUARE = Domain.of(rings.polygon([[0, 0], [1, 0], [1, 1], [0, 1]]))


def front():
    """Ellipses along a bent front, ten times as long as wide."""

    def tensors(x, y):
        slope = 0.4 * np.pi * np.cos(2 * np.pi * x)
        long = np.hypot(1, slope)
        across = np.minimum(0.01 + 0.2 * np.abs(y - 0.5 - 0.2 * np.sin(2 * np.pi * x)) / long, 0.1)
        return of_axes(across, np.full(len(x), 0.1), np.column_stack([1 / long, slope / long]))

    return tensor_metric(tensors, 10.0).straightened()


def packed(domain, spacing, watch=lambda share: None, method=METHOD):
    """All rounds of a domain and a spacing."""
    return list(rounds_of(domain, spacing, watch, method))


def rounds_of(domain, spacing, watch=lambda share: None, method=METHOD):
    """The same one by one, each when it is asked for."""
    levels = method.levels(domain, spacing, 0)
    return rounds(method.placement(domain, levels[0], 10**6), domain, levels, method, watch)


def settled_ellipses():
    """Ellipses of the front that have settled, but are not finished."""
    net = settled_net()
    return flipped_net(net, net.bubbles, net.triangles, front())


def settled_net():
    """A net of the front that has settled, but is not finished."""
    return next(rounds_of(SQUARE, front())).net
