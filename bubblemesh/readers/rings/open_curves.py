"""Curves of a drawing that are not part of any ring: strokes, centre lines, ticks of dimensions, leftovers."""

from itertools import count

import numpy as np

from bubblemesh.arrays import Booleans, Integers


def on_rings(nodes: Integers) -> Booleans:
    """Mask (m,) of the curves between ``nodes`` (m, 2) that are part of a closed walk which uses no curve twice.

    The others are the bridges of the graph, loose ends among them; Tarjan, A note on finding the bridges of a graph,
    Information Processing Letters 2 (1974).
    """
    at: dict[int, list[tuple[int, int]]] = {}
    for curve, (a, b) in enumerate(nodes.tolist()):
        at.setdefault(a, []).append((curve, b))
        at.setdefault(b, []).append((curve, a))
    numbers = count()
    number: dict[int, int] = {}
    lowest: dict[int, int] = {}  # earliest node reached from a node or beyond it, without the edge to it
    found = np.ones(len(nodes), bool)
    for root in at:
        if root in number:
            continue
        number[root] = lowest[root] = next(numbers)
        way = [(root, -1, iter(at[root]))]
        while way:
            node, came, ahead = way[-1]
            for curve, other in ahead:
                if other not in number:
                    number[other] = lowest[other] = next(numbers)
                    way.append((other, curve, iter(at[other])))
                    break
                if curve != came:
                    lowest[node] = min(lowest[node], number[other])
            else:
                way.pop()
                if way:
                    before = way[-1][0]
                    lowest[before] = min(lowest[before], lowest[node])
                    found[came] = lowest[node] <= number[before]
    return found
