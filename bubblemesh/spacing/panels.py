"""Panels: short parts of the boundary, over which the spacing hardly changes."""

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.geometry.domain import Domain
from bubblemesh.spacing.spacing import Spacing

__all__ = ["panels"]

LONGEST = 0.5  # spacings
HALVINGS = 60


def panels(domain: Domain, spacing: Spacing) -> tuple[Integers, Floats, Floats]:
    """Piece, begin and length (k,) of panels that are short beside the spacing at their ends and middles."""
    boundary = domain.boundary
    piece = np.arange(len(boundary.lengths))
    begin, length = np.zeros(len(piece)), np.asarray(boundary.lengths, float)
    done = []
    for _ in range(HALVINGS):
        places = np.concatenate([begin, begin + length / 2, begin + length])
        d = spacing(boundary.points(np.tile(piece, 3), places)).reshape(3, -1).min(axis=0)
        short = length <= LONGEST * d
        done.append((piece[short], begin[short], length[short]))
        piece, begin, length = piece[~short], begin[~short], length[~short] / 2
        piece, begin, length = np.tile(piece, 2), np.append(begin, begin + length), np.tile(length, 2)
        if len(piece) == 0:
            break
    done.append((piece, begin, length))
    piece, begin, length = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((begin, piece))
    return piece[order], begin[order], length[order]
