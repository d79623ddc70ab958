"""Rasters: arrays in NumPy's files, of which .npy holds one and .npz several by name, and pictures as grey values.

A small file can be unpacked to a large one: the size that it gives is checked before anything is unpacked, and no more
than that is unpacked.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, NamedTuple
from zipfile import ZipFile

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import BubblemeshError, CaseError, FileError, LimitError
from bubblemesh.files import opened
from bubblemesh.messages import cause
from bubblemesh.process.shared import warnings_are
from bubblemesh.readers.grids import MOST_VALUES
from bubblemesh.readers.grids.grids import GRIDS
from bubblemesh.readers.selection import one_of

NUMPY = (".npy", ".npz")
COORDINATES = ("x", "y")
NUMBERS = "iuf"  # NumPy's kinds of arrays with real numbers
ZIP = b"PK"
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
DEEP = 65535.0  # white in pictures of 16 bits
PLAIN = ("1", "L", "LA", "La", "P", "PA", "RGB", "RGBA", "RGBX", "RGBa", "CMYK", "YCbCr", "LAB", "HSV")
# Other readers of Pillow start programs, are seldom used, or use as much memory as a file asks for.
PICTURES = ("PNG", "JPEG", "TIFF", "BMP", "GIF", "WEBP", "JPEG2000", "PPM", "PCX", "SGI", "SUN", "TGA")
TILE_SIZES = (322, 323)  # tags of a TIFF
BAND = 1_000_000  # pixels that are converted at a time


class Gridded(NamedTuple):
    """An array with its name, and the coordinates of its columns and rows if the file has them."""

    name: str
    values: Floats
    x: Floats | None
    y: Floats | None


def read_gridded(path: Path, name: str | None) -> Gridded:
    """The array ``name`` of a file, or its only one, apart from the coordinates ``x`` and ``y``.

    FileError if the file cannot be read; LimitError if an array is too large; CaseError if a name is needed or unknown,
    or the array does not hold real numbers.
    """
    with opened(path) as stream, _known_by_its_ending(path):
        if not stream.peek(len(ZIP)).startswith(ZIP):
            return Gridded(_named([path.stem], name), _array(stream, path.stem), None, None)
        with _damage_reported(), ZipFile(stream) as archive:
            members = {member.removesuffix(".npy"): member for member in archive.namelist()}
            chosen = _named(list(members), name)

            def read(key: str) -> Floats:
                if not members[key].endswith(".npy"):
                    raise CaseError(f"{key} does not hold real numbers (found a file)")
                with archive.open(members[key]) as member:
                    return _array(member, key)

            x, y = (read(key) if key in members else None for key in COORDINATES)
            return Gridded(chosen, read(chosen), x, y)


def _named(arrays: list[str], name: str | None) -> str:
    """The name of one of the arrays of a file: the given one, or that of the only one apart from coordinates."""
    return name if name in arrays else one_of([key for key in arrays if key not in COORDINATES], name, "array")


@contextmanager
def _known_by_its_ending(path: Path) -> Iterator[None]:
    """Within the block, say of a file that cannot be read and has another ending than NumPy's what rasters are."""
    try:
        yield
    except FileError as error:
        if path.suffix.lower() in NUMPY:
            raise
        raise FileError(
            f"is no raster, which ends in {', '.join((*NUMPY, *GRIDS))}: give rows of x, y and a size to scattered, "
            "a picture to image"
        ) from error


@contextmanager
def _damage_reported() -> Iterator[None]:
    """Within the block, turn any error of a library into a FileError."""
    try:
        yield
    except BubblemeshError:
        raise
    except Exception as error:  # damaged files fail in any way
        raise FileError("is no .npy or .npz file of numbers, or a damaged one") from error


def _array(stream: IO[bytes], name: str) -> Floats:
    """The array in a stream, of which no more is read than its header says.

    LimitError if the array is too large, CaseError if it does not hold real numbers, FileError if it is damaged.
    """
    with _damage_reported():
        shape, by_columns, dtype = HEADERS[np.lib.format.read_magic(stream)](stream)
        count = math.prod(shape)
        if dtype.hasobject or min(shape, default=0) < 0:
            raise ValueError("no array of numbers")
        if dtype.kind not in NUMBERS:
            raise CaseError(f"{name} does not hold real numbers (found {dtype})")
        if count > MOST_VALUES:
            raise LimitError(f"{name} has {count:,} values, more than the {MOST_VALUES:,} that are read: thin it out")
        values = np.frombuffer(stream.read(count * dtype.itemsize), dtype)
        return values.reshape(shape, order="F" if by_columns else "C").astype(float)


def read_grey(path: Path) -> Floats:
    """Grey values (rows, columns) from 0, black, to 1, white, the first row on top.

    Colours become their brightness, transparent pixels white. FileError if the file cannot be read, LimitError if it
    has too many pixels, CaseError if these are neither grey values nor colours.
    """
    # Imported here since most cases have no pictures.
    from PIL import Image, UnidentifiedImageError

    try:
        with (
            warnings_are("ignore", "Image size"),  # of its own limit: the one here is lower
            opened(path) as stream,
            Image.open(stream, formats=PICTURES) as picture,
        ):
            _require_few_pixels(picture)
            return _grey(picture)
    except Image.DecompressionBombError:
        raise _too_many_pixels() from None
    except UnidentifiedImageError:
        raise FileError(f"is no picture of a known format ({', '.join(PICTURES)})") from None
    except BubblemeshError:
        raise
    except Exception as error:  # damaged files fail in any way
        raise FileError(f"is no picture that can be read: {cause(error)}") from error


def _require_few_pixels(picture: Any) -> None:
    tile = [int(getattr(picture, "tag_v2", {}).get(tag, 1)) for tag in TILE_SIZES]  # each is unpacked as a whole
    if max(math.prod(picture.size), math.prod(tile)) > MOST_VALUES:
        raise _too_many_pixels()


def _too_many_pixels() -> LimitError:
    return LimitError(f"has more than {MOST_VALUES:,} pixels: reduce it")


def _grey(picture: Any) -> Floats:
    deep = picture.mode.startswith("I;16") or (picture.mode == "I" and picture.format == "PNG")
    if not deep and picture.mode not in PLAIN:
        raise CaseError(f"has pixels of the kind {picture.mode}: give a picture of grey values or colours")
    columns, rows = picture.size
    grey = np.empty((rows, columns))
    step = max(BAND // columns, 1)
    for first in range(0, rows, step):
        band = picture.crop((0, first, columns, min(first + step, rows)))
        grey[first : first + step] = _deep_grey(band) if deep else _plain_grey(band)
    return grey


def _deep_grey(picture: Any) -> Floats:
    return np.clip(np.asarray(picture, float) / DEEP, 0, 1)


def _plain_grey(picture: Any) -> Floats:
    shade, alpha = np.moveaxis(np.asarray(picture.convert("RGBA").convert("LA"), float) / 255, 2, 0)
    return 1 - alpha * (1 - shade)
