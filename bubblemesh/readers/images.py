"""Pictures as grey values."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.errors import BubblemeshError, CaseError, FileError
from bubblemesh.files import opened

DEEP = 65535.0  # white in pictures of 16 bits
PLAIN = ("1", "L", "LA", "La", "P", "PA", "RGB", "RGBA", "RGBX", "RGBa", "CMYK", "YCbCr", "LAB", "HSV")


def read_grey(path: Path) -> Floats:
    """Grey values (rows, columns) from 0, black, to 1, white, the first row on top.

    Colours count by their brightness; what is transparent is white.

    Raises
    ------
    FileError
        If the file cannot be read, or is too large.
    CaseError
        If its pixels are neither grey values nor colours.
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
