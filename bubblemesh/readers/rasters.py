"""Rasters: arrays in NumPy's files, of which .npy holds one and .npz several by name, and pictures as grey values."""

import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import BubblemeshError, CaseError, FileError
from bubblemesh.files import opened

COORDINATES = ("x", "y")
NUMBERS = "iuf"  # kinds of arrays
DEEP = 65535.0  # white in pictures of 16 bits
PLAIN = ("1", "L", "LA", "La", "P", "PA", "RGB", "RGBA", "RGBX", "RGBa", "CMYK", "YCbCr", "LAB", "HSV")


class Gridded(NamedTuple):
    """An array with its name, and the coordinates of its columns and rows where the file has them."""

    name: str
    values: Floats
    x: Floats | None
    y: Floats | None


def read_gridded(path: Path, name: str | None) -> Gridded:
    """The array ``name`` of a file, or the only one of it beside the coordinates ``x`` and ``y``.

    FileError if the file cannot be read; CaseError if the name is needed, unknown, or one of an array that does not
    hold real numbers.
    """
    arrays = _arrays(path)
    known = [key for key in arrays if key not in COORDINATES]
    if name is None and len(known) != 1:
        listed = f" ({', '.join(known)})" if known else ""
        raise CaseError(f"has {len(known)} arrays{listed}: give the name of one")
    chosen = known[0] if name is None else name
    if chosen not in arrays:
        raise CaseError(f"has no array {chosen!r}: it has {', '.join(arrays) or 'none'}")
    x, y = (None if arrays.get(key) is None else _real(arrays[key], key) for key in COORDINATES)
    return Gridded(chosen, _real(arrays[chosen], chosen), x, y)


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


def read_grey(path: Path) -> Floats:
    """Grey values (rows, columns) from 0, black, to 1, white, the first row on top.

    Colours count by their brightness; what is transparent is white. FileError if the file cannot be read, or is too
    large; CaseError if its pixels are neither grey values nor colours.
    """
    # Imported here since most cases have no pictures.
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with opened(path) as stream, Image.open(stream) as picture:
                return _grey(picture)
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise FileError(f"has more than {Image.MAX_IMAGE_PIXELS} pixels: reduce it") from None
    except UnidentifiedImageError:
        raise FileError("is no picture of a known format") from None
    except BubblemeshError:
        raise
    except Exception as error:  # damaged files fail in any way
        raise FileError(f"is no picture that can be read: {error}") from error


def _grey(picture: Any) -> Floats:
    if picture.mode.startswith("I;16") or (picture.mode == "I" and picture.format == "PNG"):
        return np.clip(np.asarray(picture, float) / DEEP, 0, 1)
    if picture.mode not in PLAIN:
        raise CaseError(f"has pixels of the kind {picture.mode}: give a picture of grey values or colours")
    shade, alpha = np.moveaxis(np.asarray(picture.convert("RGBA").convert("LA"), float) / 255, 2, 0)
    return 1 - alpha * (1 - shade)
