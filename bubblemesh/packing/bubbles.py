"""The bubbles: what a round takes in and gives back."""

import numpy as np

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.records import record

NOWHERE = np.zeros(0, np.int64), np.zeros(0)  # no place on the boundary


@record
class Bubbles:
    """Bubbles at rest, in three groups: fixed corners, bubbles that slide on the boundary, interior bubbles."""

    x: Floats  # (n, 2): centres, in the order of the groups
    d: Floats  # (n,): spacing (diameter) at the centres
    piece: Integers  # (b,): boundary pieces of the b sliding bubbles
    s: Floats  # (b,): their arc lengths
    corners: int  # number of fixed bubbles: the corners of the boundary, in its order
    touched: Booleans  # (n,): new since the last population control, or next to a bubble that it deleted or inserted

    def __len__(self) -> int:
        return len(self.x)

    @property
    def sliding(self) -> slice:
        """Slice of the bubbles that move along their boundary piece only."""
        return slice(self.corners, self.boundary_count)

    @property
    def interior(self) -> slice:
        """Slice of the bubbles that move freely."""
        return slice(self.boundary_count, None)

    @property
    def boundary_count(self) -> int:
        """Number of bubbles on the boundary, corners included."""
        return self.corners + len(self.piece)

    def moved(self, x: Floats, d: Floats | None = None, s: Floats | None = None) -> "Bubbles":
        """The bubbles with their centres at x (n, 2), and if they are given, spacings d (n,) and arc lengths s (b,)."""
        d, s = self.d if d is None else d, self.s if s is None else s
        return Bubbles(x, d, self.piece, s, self.corners, self.touched)

    def select(self, keep: Integers) -> "Bubbles":
        """Bubbles of the numbers ``keep`` (k,), ascending, all corners among them."""
        slide = keep[(keep >= self.corners) & (keep < self.boundary_count)] - self.corners
        return Bubbles(self.x[keep], self.d[keep], self.piece[slide], self.s[slide], self.corners, self.touched[keep])

    def append(self, x: Floats, d: Floats, piece: Integers = NOWHERE[0], s: Floats = NOWHERE[1]) -> "Bubbles":
        """Bubbles with new ones at ``x`` (k, 2), of which the first j lie on the boundary at ``piece``, ``s``."""
        at, slides, new = self.boundary_count, len(piece), np.ones(len(x), bool)
        return Bubbles(
            np.concatenate([self.x[:at], x[:slides], self.x[at:], x[slides:]]),
            np.concatenate([self.d[:at], d[:slides], self.d[at:], d[slides:]]),
            np.concatenate([self.piece, piece]),
            np.concatenate([self.s, s]),
            self.corners,
            np.concatenate([self.touched[:at], new[:slides], self.touched[at:], new[slides:]]),
        )
