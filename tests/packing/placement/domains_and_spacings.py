"""Domains with walls of each kind, and spacings along them."""

import numpy as np

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain

SQUARE = Domain.of(rings.rectangle(0, 0, 2, 2))
DOMAINS = {
    "square": SQUARE,
    "ring": Domain.of(rings.circle((0, 0), 2), [rings.ellipse((0.4, 0.2), (1.2, 0.6), 30)]),
    "spline": Domain.of(rings.path((0, 0), [rings.LineTo((2, 0)), rings.SplineTo([(1.5, 1), (0.4, 0.7), (0, 0)])])),
}
SPACINGS = {
    "uniform": lambda x, y: np.full(x.shape, 0.13),
    "linear": lambda x, y: 0.1 + 0.03 * (x + y + 4),
    "steep": lambda x, y: 0.01 + 0.5 * np.hypot(x - 1, y + 0.1),
    "kinked": lambda x, y: 0.05 + 0.3 * np.abs(x - 0.6),
    "waves": lambda x, y: 0.06 + 0.02 * np.sin(9 * x) * np.cos(7 * y),
}
