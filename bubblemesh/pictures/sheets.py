"""The sheet that a picture is drawn on: its size, and what is cut off."""

from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox

from bubblemesh.pictures.styles import PlotOptionError, PlotOptions, View

MM_PER_INCH = 25.4
MARGIN, NARROW_MARGIN = 0.12, 0.03  # inches
MOST_PIXELS = 30_000
TALL, TALL_IN_COLUMN = 1 / 1.6, 1.6  # height over width


def is_tall(box: View, options: PlotOptions) -> bool:
    """Whether the colour bar stands beside the mesh."""
    aspect = (box[3] - box[1]) / (box[2] - box[0])
    return aspect > (TALL if options.whole_width is None else TALL_IN_COLUMN)


def sheet(box: View, options: PlotOptions) -> tuple[Figure, float]:
    """A figure with room for the mesh, and the inches that a unit of length takes; the empty room is cut off later.

    Raises
    ------
    PlotOptionError
        If it would have too many pixels.
    """
    width, height = box[2] - box[0], box[3] - box[1]
    asked, dpi = options.whole_width, options.dpi or options.look.dpi
    long_side = options.look.long_side / MM_PER_INCH
    if asked is None:
        inches = long_side / max(width, height)
        size = (max(width * inches, 2.5) + 1.2, max(height * inches, 2.0) + 1.0)
    else:
        inches = min(asked / MM_PER_INCH / width, long_side / height)
        size = (asked / MM_PER_INCH, height * inches + 1.5)
    if max(size) * dpi > MOST_PIXELS:
        raise PlotOptionError(
            "dpi", f"the picture would be {max(size) * dpi:.0f} pixels long: at most {MOST_PIXELS} are drawn"
        )
    pads: Any = {} if asked is None else {"w_pad": 0.01, "h_pad": 0.02}
    layout = ConstrainedLayoutEngine(**pads)
    figure = Figure(figsize=size, dpi=dpi, layout=layout)
    FigureCanvasAgg(figure)
    return figure, inches


def cropped(figure: Figure, options: PlotOptions) -> Bbox:
    """The part of the figure to keep: all that is drawn, or the whole width where one is asked for."""
    figure.draw_without_rendering()
    drawn = figure.get_tightbbox()
    if options.whole_width is not None:
        return Bbox([[0, drawn.y0 - NARROW_MARGIN], [figure.get_figwidth(), drawn.y1 + NARROW_MARGIN]])
    return drawn.padded(MARGIN)
