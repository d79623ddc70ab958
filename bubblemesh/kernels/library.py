"""The compiled library of the kernels, if there is one, and the choice between its functions and their twins in NumPy.

A kernel is written as two functions of the same parameters, of which callers know the second one::

    def lengths_in_numpy(vectors: Floats) -> Floats:
        return np.hypot(*vectors.T)

    @or_numpy(lengths_in_numpy)
    def lengths(vectors: Floats) -> Floats:
        result = np.empty(len(vectors))
        call("lengths", n=len(vectors), vectors=np.ascontiguousarray(vectors), result=result)
        return result
"""

import ctypes
import os
from collections.abc import Callable
from functools import cache, partial, wraps
from importlib.util import find_spec
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers, ShortIntegers
from bubblemesh.errors import CaseError, FileError

VERSION = 32  # of the library's functions, as in source/library.c
CHOICE = "BUBBLEMESH_ENGINE"  # environment variable that chooses one of the engines
COMPILED, NUMPY = "compiled", "numpy"
_VIEW = ctypes.c_char * 0
# What each function takes, by the names of its parameters: i a whole number, d a number, and the letters of `ARRAYS`
# for arrays.
SIGNATURES = {
    "anneal": (
        "n:i t:i triangles:I m:i edges:I known:i twins:H facet_count:i facets:I start:D x:D fixed:i calm:B d:D "
        "strength:D cutoff:d most:D dt:d steps:i c:D cycles:i inside:D beside:D seed:i first:i speeds:D count:I "
        "done:I"
    ),
    "bulge_distances": "n:i places:D of:I cubics:D steps:i flattest:d distance:D",
    "descend": (
        "n:i t:i m:i fixed:i b:i triangles:I counts:D edges:I d:D flattest:d worst:d shortest:d scale:D most:D "
        "weight:d momentum:d step:d tangents:D steps:i x:D"
    ),
    "enclose": "n:i t:i cells:U m:i walls:I triangles:I counts:I",
    "first_groups": "n:i t:i triangles:I chosen:B groups:I",
    "flip_to_shapes": ("t:i triangles:I measures:D roots:D m:i owners:I turned:I after:D there:D least:d fresh:B"),
    "flips_of_shapes": ("n:i t:i triangles:I f:i facets:I measures:D fresh:B good:d owners:I turned:I count:I"),
    "grow_tensors": "n:i points:D begin:I ends:I growth:d settled:d sweeps:i tensors:D",
    "guarded_move": "n:i t:i triangles:I x:D move:D keep:d share:D",
    "hilbert_index": "n:i cells:I bits:i index:I",
    "interpolate": (
        "m:i points:D x:d y:d scale:d unit:d count:d n:i key:I corner:I sides:D vertices:I values:D result:D"
    ),
    "least_around": "n:i m:i edges:I rings:i values:I",
    "legalise_triangles": (
        "n:i t:i triangles:I known_m:i known_edges:I known_twins:H start:D x:D m:i facets:I open:i ordered:I twins:H "
        "edges:I count:I outcome:I"
    ),
    "metric_anneal": (
        "n:i t:i triangles:I f:i facets:I x:D m:D roots:D fixed:i calm:B cycles:i inside:D beside:D seed:i first:i "
        "steps:i dt:d c:d cutoff:d most:d keep:d shortest:d passes:i sure:d flattest:d edges:I count:I"
    ),
    "metric_costs": (
        "n:i t:i triangles:I x:D inside:D inside_roots:D inside_slopes:D own:D own_roots:D own_slopes:D weight:d "
        "slack:d bend:d trust:d worst:i costs:D"
    ),
    "metric_flips": "n:i t:i triangles:I x:D m:D f:i facets:I passes:i sure:d flattest:d edges:I count:I",
    "metric_relax": (
        "n:i t:i triangles:I e:i edges:I x:D m:D fixed:i steps:i dt:d c:d cutoff:d most:d keep:d shortest:d speeds:D"
    ),
    "metric_shapes": "t:i triangles:I x:D roots:D eta:D",
    "metric_smooth": (
        "n:i t:i triangles:I x:D inside:D inside_roots:D inside_slopes:D own:D own_roots:D own_slopes:D axes:D "
        "count:i order:I sweeps:i weight:d slack:d bend:d trust:d worst:i delta:d most:d tries:i"
    ),
    "nearest_chords": (
        "n:i places:D count:i leaves:i length:i boxes:D points:D rectangles:D first:I counts:I slack:d nearest:I"
    ),
    "order_triangles": "n:i t:i triangles:I ordered:I edges:I count:I",
    "pair_forces": "n:i m:i ends:I contact:D strength:D cutoff:d x:D force:D",
    "pairs_within": "n:i x:D d:D reach:d room:i ordered:I count:I",
    "ranks": "n:i ascending:I m:i numbers:I with_equal:i result:I",
    "refine_triangles": "n:i t:i triangles:I m:i edges:I number:I middle:I kept:I sides:I count:I",
    "relax": "n:i m:i ends:I contact:D strength:D cutoff:d x:D fixed:i most:D dt:d steps:i c:D speeds:D",
    "separate_patches": "n:i m:i edges:I k:i seeds:I free_nodes:B inner:i outer:i displaced:B moving:I count:I",
    "shape_measures": "t:i x:D triangles:I eta:D",
    "spread": "cells:i corners:I rise:D vertices:i values:D kept:d sweeps:i",
}
NUMBERS: dict[str, Callable[[Any], object]] = {"i": ctypes.c_int64, "d": ctypes.c_double}
ARRAYS = {"B": np.bool_, "D": np.float64, "H": np.int32, "I": np.int64, "U": np.uint32}

Argument = Booleans | Floats | Integers | ShortIntegers | NDArray[np.uint32] | int | float
P = ParamSpec("P")
R = TypeVar("R")


def or_numpy(twin: Callable[P, R]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorator of a function that calls C: without compiled kernels its twin in NumPy, with the same results, runs."""

    def either(kernel: Callable[P, R]) -> Callable[P, R]:
        @wraps(kernel)
        def chosen(*args: P.args, **kwargs: P.kwargs) -> R:
            return (twin if library() is None else kernel)(*args, **kwargs)

        return chosen

    return either


def or_none(kernel: Callable[P, R]) -> Callable[P, R | None]:
    """Decorator of a function that calls C: without compiled kernels it returns None, and callers find another way."""

    def nothing(*args: P.args, **kwargs: P.kwargs) -> R | None:
        return None

    return or_numpy(nothing)(kernel)


def call(name: str, /, **arguments: Argument) -> None:
    """Call a function in C with contiguous arrays of the types that it takes, and numbers; other threads may run.

    Raises
    ------
    MemoryError
        If it has too little memory.
    TypeError, ValueError
        For other parameters than its own, or arguments of other types or layouts, with which it would read or write
        outside of the arrays.
    """
    takers = _takers(name)
    if arguments.keys() != takers.keys():
        raise TypeError(f"{name} takes {', '.join(takers)} (found {', '.join(arguments)})")
    given = [take(arguments[parameter]) for parameter, take in takers.items()]
    if getattr(library(), name)(*given):  # it returns 0, or -1 if memory was short
        raise MemoryError


@cache
def _takers(name: str) -> dict[str, Callable[[Any], object]]:
    """For each parameter of a function in C, in their order, the function that converts it to what C takes."""
    pairs = [word.split(":") for word in SIGNATURES[name].split()]
    return {parameter: NUMBERS.get(letter) or partial(_array, np.dtype(ARRAYS[letter])) for parameter, letter in pairs}


def _array(dtype: np.dtype[Any], argument: Any) -> object:
    if argument.dtype != dtype:
        raise TypeError(f"kernels take an array of {dtype} here (found {argument.dtype})")
    # A view of the array takes an eighth of the time of its address, but the array must be writable.
    try:
        return _VIEW.from_buffer(argument)
    except TypeError:
        if not argument.flags.c_contiguous:
            raise ValueError("kernels take contiguous arrays") from None
        return argument.ctypes.data_as(ctypes.c_void_p)  # which keeps the array, as a view does


@cache
def library() -> ctypes.CDLL | None:
    """The library, or None where kernels run in NumPy: no compiler built it, or the environment asks for that.

    CaseError if the environment names an unknown engine, FileError if the library is missing, broken or of another
    version.
    """
    choice = os.environ.get(CHOICE, "")
    if choice not in ("", COMPILED, NUMPY):
        raise CaseError(f"{CHOICE}={choice}: there is no such engine: use {COMPILED} or {NUMPY}")
    if choice == NUMPY:
        return None
    spec = find_spec("bubblemesh.kernels._compiled")
    if spec is not None and spec.origin is not None:
        return loaded(spec.origin)
    if choice == COMPILED:
        raise FileError(f"{CHOICE}={choice}: no kernels are compiled here: install bubblemesh where a C compiler is")
    return None


def loaded(path: str) -> ctypes.CDLL:
    """The library in a file; FileError if it is broken or of another version."""
    try:
        found = ctypes.CDLL(path)
        version = found.kernels_version()
    except (OSError, AttributeError) as error:
        raise FileError(f"{path} cannot be loaded ({error}): install bubblemesh anew") from None
    if version != VERSION:
        raise FileError(f"{path} is of another version of bubblemesh: install bubblemesh anew")
    return found


def engine() -> str:
    """Name of what runs the kernels: ``compiled`` or ``numpy``."""
    return NUMPY if library() is None else COMPILED
