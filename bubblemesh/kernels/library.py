"""The compiled library of the kernels, if there is one."""

import ctypes
import os
from collections.abc import Callable
from functools import cache, partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Booleans, Floats, Integers, ShortIntegers
from bubblemesh.errors import CaseError, FileError

VERSION = 26  # of the library's functions, as in source/library.c
CHOICE = "BUBBLEMESH_ENGINE"  # environment variable that chooses one of the engines
COMPILED, NUMPY = "compiled", "numpy"
_VIEW = ctypes.c_char * 0
# What each function takes: i a whole number, d a number, and the letters of `ARRAYS` for arrays.
SIGNATURES = {
    "anneal": "iiIiIiHiIDDiBDDdDdiDiDDiiDII",
    "bulge_distances": "iDIDidD",
    "descend": "iiiiiIIDdddDDdddDiD",
    "enclose": "iiUiIII",
    "guarded_move": "iiIDDdD",
    "hilbert_index": "iIiI",
    "interpolate": "iDdddddiIIDIDD",
    "legalise_triangles": "iiIiIHDDiIiIHIII",
    "metric_anneal": "iiIiIDDDiBiDDiiiddddddiddII",
    "metric_flips": "iiIDDiIiddII",
    "metric_relax": "iiIiIDDiiddddddD",
    "metric_smooth": "iiIDDDDDDDDiIidddddi",
    "nearest_chords": "iDiiiDDDIIdI",
    "order_triangles": "iiIIII",
    "pair_forces": "iiIDDdDD",
    "pairs_within": "iDDdiII",
    "ranks": "iIiIiI",
    "refine_triangles": "iiIiIIIIII",
    "relax": "iiIDDdDiDdiDD",
    "separate_patches": "iiIiIBiiBII",
    "shape_measures": "iDID",
    "spread": "iIDiDdi",
}
NUMBERS: dict[str, Callable[[Any], object]] = {"i": ctypes.c_int64, "d": ctypes.c_double}
ARRAYS = {"B": np.bool_, "D": np.float64, "H": np.int32, "I": np.int64, "U": np.uint32}

Argument = Booleans | Floats | Integers | ShortIntegers | NDArray[np.uint32] | int | float


class Library:
    """Functions in C, each of which returns 0, or -1 if memory was short."""

    def __init__(self, path: str) -> None:
        try:
            self._functions = ctypes.CDLL(path)
            version = self._functions.kernels_version()
        except (OSError, AttributeError) as error:
            raise FileError(f"{path} cannot be loaded ({error}): install bubblemesh anew") from None
        if version != VERSION:
            raise FileError(f"{path} is of another version of bubblemesh: install bubblemesh anew")

    def call(self, name: str, *arguments: Argument) -> None:
        """Call a function with contiguous arrays of the types that it takes, and numbers; other threads may run.

        Raises
        ------
        MemoryError
            If it has too little memory.
        TypeError, ValueError
            For arguments of other types or layouts, with which it would read or write outside of the arrays.
        """
        given = [take(argument) for take, argument in zip(_takers(name), arguments, strict=True)]
        if getattr(self._functions, name)(*given):
            raise MemoryError


@cache
def _takers(name: str) -> list[Callable[[Any], object]]:
    """For each argument of a function in C, the function that converts it to what C takes."""
    return [NUMBERS.get(letter) or partial(_array, np.dtype(ARRAYS[letter])) for letter in SIGNATURES[name]]


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
def library() -> Library | None:
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
        return Library(spec.origin)
    if choice == COMPILED:
        raise FileError(f"{CHOICE}={choice}: no kernels are compiled here: install bubblemesh where a C compiler is")
    return None


def engine() -> str:
    """Name of what runs the kernels: ``compiled`` or ``numpy``."""
    return NUMPY if library() is None else COMPILED
