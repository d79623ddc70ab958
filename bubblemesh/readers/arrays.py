"""Arrays in NumPy's files: .npy holds one, .npz several with names."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import CaseError, FileError
from bubblemesh.files import opened

COORDINATES = ("x", "y")
NUMBERS = "iuf"  # kinds of arrays


class Gridded(NamedTuple):
    """An array with its name, and the coordinates of its columns and rows where the file has them."""

    name: str
    values: Floats
    x: Floats | None
    y: Floats | None


def read_gridded(path: Path, name: str | None) -> Gridded:
    """The array ``name`` of a file, or the only one of it beside the coordinates ``x`` and ``y``.

    Raises
    ------
    FileError
        If the file cannot be read.
    CaseError
        If the name is needed, unknown, or one of an array that does not hold real numbers.
    """
    arrays = _arrays(path)
    known = [key for key in arrays if key not in COORDINATES]
    if name is None and len(known) != 1:
        raise CaseError(f"has {len(known)} arrays{_listed(known)}: give the name of one")
    chosen = known[0] if name is None else name
    if chosen not in arrays:
        raise CaseError(f"has no array {chosen!r}: it has {', '.join(arrays) or 'none'}")
    x, y = (None if arrays.get(key) is None else _real(arrays[key], key) for key in COORDINATES)
    return Gridded(chosen, _real(arrays[chosen], chosen), x, y)


def _listed(names: list[str]) -> str:
    return f" ({', '.join(names)})" if names else ""


def _arrays(path: Path) -> dict[str, Any]:
    with opened(path) as stream:  # the library would leave damaged files open
        try:
            loaded = np.load(stream, allow_pickle=False)
            return {path.stem: loaded} if isinstance(loaded, np.ndarray) else dict(loaded)
        except Exception as error:  # damaged files fail in any way, and text as pickled data
            raise FileError("is no .npy or .npz file of numbers, or a damaged one") from error


def _real(array: Any, name: str) -> Floats:
    if not isinstance(array, np.ndarray) or array.dtype.kind not in NUMBERS:
        raise CaseError(f"{name} does not hold real numbers (found {getattr(array, 'dtype', 'a file')})")
    return array.astype(float)
