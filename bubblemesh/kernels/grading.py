"""Tensors that grow from place to place no faster than by some part over a length of 1, compiled or in NumPy alike."""

import numpy as np

from bubblemesh.arrays import Floats, Integers, members
from bubblemesh.kernels.library import call, or_numpy
from bubblemesh.kernels.tensors import intersected_at, lengths

SWEEPS = 100_000  # at most


def grown_in_numpy(
    points: Floats, begin: Integers, ends: Integers, tensors: Floats, growth: float, settled: float
) -> Floats:
    """The same as `grown`, in NumPy."""
    result, told, news, counts = tensors.copy(), tensors.copy(), np.arange(len(points)), np.diff(begin)
    for _ in range(SWEEPS):  # each time a size is less by more than what counts as none
        if len(news) == 0:
            break
        told[news] = result[news]
        of, rank = members(counts[news])
        origin, end = news[of], ends[begin[news][of] + rank]
        length = lengths(told[origin], points[end] - points[origin])
        result = intersected_at(result, end, told[origin] / ((1 + growth * length) ** 2)[:, None])
        reached = np.unique(end)
        change = np.abs(result[reached] - told[reached]).max(axis=1)
        news = reached[change > settled * (told[reached, 0] + told[reached, 2])]
    return result


@or_numpy(grown_in_numpy)
def grown(points: Floats, begin: Integers, ends: Integers, tensors: Floats, growth: float, settled: float) -> Floats:
    """Tensors (n, 3) at points (n, 2) after they have spread to their neighbours, as far as any is finer for it.

    The neighbours of point k are those of ``ends`` (m,) from ``begin[k]`` (n + 1,) to ``begin[k + 1]``. At a neighbour
    the ellipse of a point is larger by the factor 1 + growth * L, where L is how far it is in its metric; the tensor
    there is intersected with that. It is passed on again if any entry has changed by more than ``settled``, in terms
    of its trace. Every sweep passes on what the last one has changed.
    """
    result = np.array(tensors, order="C")
    call(
        "grow_tensors",
        n=len(points),
        points=np.ascontiguousarray(points),
        begin=begin,
        ends=ends,
        growth=float(growth),
        settled=settled,
        sweeps=SWEEPS,
        tensors=result,
    )
    return result
