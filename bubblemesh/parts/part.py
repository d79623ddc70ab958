"""What a packed part is made of: its core, which is done for good, and the margin that seams may change yet."""

from typing import NamedTuple

from bubblemesh.arrays import Floats, Integers, ShortIntegers
from bubblemesh.meshes.census import Census
from bubblemesh.packing.rounds import Figures, Record


class Band(NamedTuple):
    """Nodes of a part on its boundary and along its cuts, and the triangles along the cuts."""

    x: Floats  # (n, 2): corners, then what slides on pieces, then the others
    corners: int
    piece: Integers  # (b,): pieces of the part on which nodes slide
    s: Floats  # (b,): arc lengths there
    triangles: Integers  # (t, 3)
    rim: Integers  # (r, 2): sides of them beyond which the core is
    rim_region: Integers  # (r,): region of the whole there


class Core(NamedTuple):
    """Core of a part: its triangles that are in no band."""

    x: Floats  # (m, 2): places of the nodes that the band has not
    triangles: ShortIntegers  # (t, 3): numbers of the band's nodes, then of these
    region: ShortIntegers  # (t,): region of the whole
    quality: Floats  # (t,): radius ratio, if figures are wanted
    target: Floats  # (t,): target spacing, if figures are wanted


class Margin(NamedTuple):
    """Margin of a packed part: all that is known of it beside its core."""

    band: Band
    figured: bool  # whether figures are wanted, and there
    census: Census | None  # of the core, if it has triangles and figures are wanted
    valence: Integers  # (n,): edges of the core at each node of the band, but for those of the rim
    regions: Integers  # (k,): of the core
    nodes: int  # of the core
    triangles: int
    start: Figures  # before the first round
    record: Record  # of all rounds


class Part(NamedTuple):
    """A packed part."""

    core: Core
    margin: Margin
