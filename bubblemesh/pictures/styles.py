"""Options, colours and styles of pictures; a style sets sizes, line widths and fonts."""

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from bubblemesh.arrays import LARGEST_NUMBER, is_real
from bubblemesh.errors import CaseError
from bubblemesh.messages import meant
from bubblemesh.records import record

View = tuple[float, float, float, float]
"""Part of the plane: x0, y0, x1, y1."""

INK = "#22303c"
SOFT = "#55636f"  # of texts and lines beside the mesh
BARE = "#eef3f6"  # of triangles without a quantity
# Dark enough for thin lines on white, pale enough under edges in ink, and distinct for colour-blind readers.
LABEL_COLOURS = ("#1f5fa8", "#d1495b", "#2e8b57", "#8e44ad", "#c9820a", "#00798c", "#7f4f24", "#4a4e69")
REGION_COLOURS = (
    *("#cfe0f1", "#f4c9b4", "#d3dd8e", "#f6e5ae", "#f3c3d3", "#a5d8c9", "#c8c2e4", "#dcdcdc"),
    *("#e59a72", "#8fb8e0", "#a9bd4f", "#df86a8", "#5fb89f", "#e3c04d", "#9b8fd0", "#ababab"),
    *("#c9a583", "#f28f8f", "#8fdcf0", "#9fbf93", "#e0a6e8", "#d8f5c8", "#7fa3b8", "#b8935a"),
)
SMALLEST, LARGEST = 10, 2400  # width in millimetres, and dots per inch
LEAST_SHARE = 1e-12  # shortest side of a view over its largest coordinate: rounding leaves no numbers in shorter ones


def region_colour(region: int) -> int:
    """Number of the colour of a region: those of many come again, but for the first, which is mostly that around."""
    return region if region == 0 else 1 + (region - 1) % (len(REGION_COLOURS) - 1)


@record
class Style:
    """Look of a picture; widths of lines and heights of letters are in points, 1/72 inch."""

    width: float | None  # in millimetres; None to make the longer side of the mesh as long as ``long_side``
    long_side: float
    dpi: float  # of bitmaps, those inside of vector files included
    most_vectors: int  # triangles in a vector file; those of a larger mesh become a bitmap
    edges: tuple[float, float]  # least and largest width; between them a fixed share of the edges' length
    boundary: tuple[float, float]  # the same of the boundary
    labels: bool  # whether the boundary is coloured by label, by default
    axes: bool  # whether coordinates are beside the mesh, by default
    figures: bool  # whether the colour bar has mean and least value
    bar: float  # length of the colour bar over its width
    settings: Any  # of matplotlib, for fonts


SANS = {"font.family": "DejaVu Sans", "mathtext.fontset": "dejavusans", "font.size": 10.0}
SERIF = {"font.family": "STIXGeneral", "mathtext.fontset": "stix", "font.size": 8.0, "pdf.fonttype": 42}
QUANTITIES = ("quality", "size", "spacing", "label", "material", "none")  # that a picture shows of any mesh
STYLES = {
    "screen": Style(None, 190.0, 120.0, 5000, (0.08, 0.5), (1.2, 2.2), True, True, True, 30.0, SANS),
    # One column of a journal's page, with lines just wide enough for print.
    "paper": Style(85.0, 190.0, 600.0, 20_000, (0.05, 0.25), (0.5, 0.8), False, False, False, 45.0, SERIF),
}


class PlotOptionError(CaseError):
    """An option, named as on the command line, has a wrong value, or asks for something that the mesh lacks."""

    def __init__(self, option: str, problem: str) -> None:
        super().__init__(f"{option}: {problem}")
        self.option, self.problem = option, problem

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.option, self.problem), vars(self)


@record
class PlotOptions:
    """Options of a picture; those that are None follow from the mesh and the style."""

    # ``quality``, ``size``, ``spacing``, ``label``, ``material``, ``none``, or the name of a field of the mesh; if None
    # the quality, or the size where triangles are too many to see each.
    color: str | None = None
    colormap: str | None = None  # ``quality`` or one of matplotlib's
    limits: tuple[float, float] | None = None  # values at the ends of the colour map
    edges: bool | None = None  # whether those of the triangles are drawn
    nodes: bool = False
    ellipses: bool = False  # of the metric in which the mesh was made, at its nodes
    labels: bool | None = None  # whether the boundary is coloured by label
    axes: bool | None = None  # whether coordinates are beside the mesh
    view: View | None = None  # if None, the whole mesh
    title: str | None = None
    style: str = "screen"  # key of ``STYLES``
    width: float | None = None  # in millimetres
    dpi: float | None = None  # of bitmaps

    @property
    def look(self) -> Style:
        """The style."""
        return STYLES[self.style]

    @property
    def whole_width(self) -> float | None:
        """Width in millimetres that the picture has to have, if any."""
        return self.width or self.look.width

    def check(self) -> None:
        """Check the values; PlotOptionError for one that no picture can have."""
        for name in ("color", "colormap", "title", "style"):
            if not isinstance(getattr(self, name), str | None):
                raise PlotOptionError(name, f"must be a text (found {getattr(self, name)!r})")
        if self.color == "":
            raise PlotOptionError("color", f"must not be empty: give {', '.join(QUANTITIES)}, or a field of the mesh")
        if self.style not in STYLES:
            raise PlotOptionError("style", f"{self.style!r} is unknown: {meant(self.style, STYLES)}")
        for name, value in (("width", self.width), ("dpi", self.dpi)):
            if value is not None and not (is_real(value) and SMALLEST <= value <= LARGEST):
                found = f"{value:g}" if is_real(value) else repr(value)
                raise PlotOptionError(name, f"is {found}: it has to be between {SMALLEST} and {LARGEST}")
        if self.limits is not None and not _ascending(self.limits, 1):
            raise PlotOptionError("range", "give two numbers, the first less than the second")
        if self.view is not None:
            _check_view(self.view)


def plot_options(given: Mapping[str, Any]) -> PlotOptions:
    """Options of a picture by their names; their values may be arrays of numbers. CaseError if a name is unknown."""
    known = [field.name for field in fields(PlotOptions)]
    for name in given:
        if name not in known:
            raise CaseError(f"plot: there is no option {name!r}: {meant(name, known)}")
    return PlotOptions(**{k: v.tolist() if isinstance(v, np.ndarray | np.generic) else v for k, v in given.items()})


def _check_view(view: Any) -> None:
    """Check a part of the plane; PlotOptionError if no picture can show it."""
    if not _ascending(view, 2):
        raise PlotOptionError("view", f"give numbers x0 y0 x1 y1 with x0 < x1 and y0 < y1 (found {view!r})")
    largest = max(map(abs, view))
    if largest > LARGEST_NUMBER:
        raise PlotOptionError("view", f"its numbers have to be at most {LARGEST_NUMBER:g} (found {largest:g})")
    if min(view[2] - view[0], view[3] - view[1]) < LEAST_SHARE * largest:
        raise PlotOptionError("view", f"its sides are too short for numbers as large as {largest:g}: show more")


def _ascending(given: Any, pairs: int) -> bool:
    """Whether a value is ``pairs`` finite numbers, and after them as many again, each greater than its counterpart."""
    if not (isinstance(given, list | tuple) and len(given) == 2 * pairs and all(map(is_real, given))):
        return False
    return all(-math.inf < low < high < math.inf for low, high in zip(given[:pairs], given[pairs:], strict=True))
