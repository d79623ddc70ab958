"""Pictures small enough for version control: at most 60 kB each, at about the size at which they are shown."""

import io
import re
from itertools import product
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from PIL import Image

MOST_BYTES = 60_000
COLOURS = (128, 64)
WIDTHS = (1200, 960, 800, 700, 600, 520, 440, 360)  # pixels
NUMBER = re.compile(r"-?\d+\.\d{2,}")
SPACE = re.compile(r"\s*\n\s*")
METADATA = re.compile(r"<metadata>.*?</metadata>", re.DOTALL)


def save(figure: Figure, path: Path, dpi: float = 80) -> None:
    """Write a figure as a small ``.svg`` or ``.png``, the same bytes each time: without a date and random ids."""
    with mpl.rc_context({"svg.hashsalt": "bubblemesh"}):
        figure.savefig(path, dpi=dpi, metadata={"Date": None} if path.suffix == ".svg" else {})
    lighten(path)


def lighten(path: Path) -> None:
    """Make a picture as small as it has to be, in place.

    Parameters
    ----------
    path : Path
        An ``.svg`` whose numbers are in points: they are rounded to tenths; or a ``.png``: it gets as few colours, and
        then as few pixels, as it takes.

    Raises
    ------
    SystemExit
        If it stays too large.
    """
    content = _svg(path) if path.suffix == ".svg" else _png(path)
    if len(content) > MOST_BYTES:
        raise SystemExit(f"{path}: has {len(content)} bytes, more than {MOST_BYTES}: draw it with less in it")
    path.write_bytes(content)


def _svg(path: Path) -> bytes:
    text = SPACE.sub("\n", METADATA.sub("", path.read_text(encoding="utf-8")))
    return NUMBER.sub(lambda found: f"{float(found[0]):.1f}".removesuffix(".0"), text).encode()


def _png(path: Path) -> bytes:
    content = path.read_bytes()
    picture = Image.open(path).convert("RGB")
    for width, colours in product(WIDTHS, COLOURS):
        if len(content) <= MOST_BYTES:
            break
        size = width, round(picture.height * width / picture.width)
        small = picture.resize(size, Image.Resampling.LANCZOS) if width < picture.width else picture
        packed = io.BytesIO()
        few = small.quantize(colours, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        few.save(packed, format="png", optimize=True)
        content = packed.getvalue()
    return content
