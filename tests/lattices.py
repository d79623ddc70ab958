"""Perfect hexagonal lattices, and a domain that one of them fills."""

import numpy as np

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.bubbles import Bubbles
from bubblemesh.packing.forces import VanDerWaals
from bubblemesh.packing.motion import SemiImplicitEuler
from bubblemesh.packing.relaxation import Dynamics
from bubblemesh.spacing.spacing import Spacing

SQRT3 = np.sqrt(3.0)
DAMPED = Dynamics(
    VanDerWaals(), SemiImplicitEuler(), lambda steps, _: [1.4] * len(steps)
)  # as the multilevel method has it


def uniform(d):
    """The same spacing everywhere."""
    return Spacing(lambda x, y: np.full(x.shape, d), floor=d)


def hexagonal(columns, rows, d=1.0):
    """Rows of points (columns * rows, 2) at distance d, every other row shifted by half of it."""
    j, i = np.divmod(np.arange(columns * rows), columns)
    return d * np.column_stack([i + 0.5 * (j % 2), SQRT3 / 2 * j])


def hexagon(side):
    """Points of the lattice of unit distance in a regular hexagon about the origin, boundary included."""
    i, j = np.mgrid[-side : side + 1, -side : side + 1].reshape(2, -1)
    inside = np.abs(i + j) <= side
    return np.column_stack([i + j / 2, SQRT3 / 2 * j])[inside]


def hexagon_domain(side):
    """The regular hexagon itself, which the lattice fills."""
    angle = np.arange(6) * np.pi / 3
    return Domain.of(rings.polygon(side * np.column_stack([np.cos(angle), np.sin(angle)])))


def packed_hexagon(side):
    """Domain, spacing 1 and the perfect packing of the hexagon."""
    domain, spacing = hexagon_domain(side), uniform(1.0)
    boundary = domain.boundary
    k = np.arange(1, side)
    piece, s = np.repeat(np.arange(6), len(k)), np.tile(k, 6).astype(float)
    on_boundary = np.vstack([boundary.corners, boundary.points(piece, s)])
    lattice = hexagon(side)
    inside = lattice[domain.signed_distance(lattice) > 0.5]
    x = np.vstack([on_boundary, inside])
    return domain, spacing, Bubbles(x, spacing(x), piece, s, 6, touched=np.zeros(len(x), bool))
