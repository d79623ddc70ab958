"""Charts as SVG within a page, whose style sheet has their colours."""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from bubblemesh.meshes.histograms import Histogram
from bubblemesh.pages.markup import Markup, html, tag

WIDTH, HEIGHT = 340, 190
LEFT, RIGHT, TOP, BOTTOM = 40, 12, 12, 34  # margins of the plot
Scale = Callable[[float], float]


class ChartLine(NamedTuple):
    """Points of a line, its name, and whether each point has a mark."""

    name: str
    points: Sequence[tuple[float, float]]
    marked: bool


def bar(share: float) -> Markup:
    """A horizontal bar for the cell of a table, as long as the given share of the cell's width."""
    filling = tag("rect", width=f"{100 * min(max(share, 0), 1):.1f}", height=10, class_="bar")
    look = {"viewBox": "0 0 100 10", "preserveAspectRatio": "none", "class_": "cell", "aria_hidden": "true"}
    return tag("svg", filling, **look)


def quality_range(figures: Sequence[float], low: float) -> Markup:
    """A line from the least to the mean quality, with a bar at the first percentile, on a scale from ``low`` to 1.

    The figures are the least quality, the first percentile and the mean.
    """
    least, p01, mean = figures
    begin, middle, end = (4 + 92 * (q - low) / (1 - low) for q in figures)
    parts = [
        tag("title", f"least {least:.3f}, 1 % below {p01:.3f}, mean {mean:.4f}"),
        tag("line", x1=4, x2=96, y1=8, y2=8, class_="grid"),
        tag("line", x1=f"{begin:.1f}", x2=f"{end:.1f}", y1=8, y2=8, class_="line line-range"),
        tag("line", x1=f"{middle:.1f}", x2=f"{middle:.1f}", y1=4, y2=12, class_="line line-range"),
        tag("circle", cx=f"{end:.1f}", cy=8, r=3.5, class_="mark-0"),
    ]
    return tag("svg", *parts, viewBox="0 0 100 16", role="img", class_="range")


def histogram_chart(
    title: str, counted: Histogram, noun: str, ticks: Sequence[float], ideal: float | None = None
) -> Markup:
    """Chart of a histogram.

    Parameters
    ----------
    title
        Title of the chart.
    counted
        The histogram.
    noun
        What is counted, in the plural.
    ticks
        Values written along the axis.
    ideal
        Value marked by a line, if any.
    """
    edges, total = [float(edge) for edge in counted.edges], max(counted.total, 1)
    shares = [int(count) / total for count in counted.counts]
    top = _rounded_up(max(shares))
    across, up = _linear(edges[0], edges[-1], LEFT, WIDTH - RIGHT), _linear(0, top, HEIGHT - BOTTOM, TOP)
    bars = [
        tag(
            "rect",
            tag("title", f"{low:.4g} to {high:.4g}: {count} {noun}, {share:.1%}"),
            x=f"{across(low) + 0.5:.2f}",
            y=f"{up(share):.2f}",
            width=f"{across(high) - across(low) - 1:.2f}",
            height=f"{up(0) - up(share):.2f}",
            class_="bar",
        )
        for low, high, count, share in zip(edges, edges[1:], counted.counts.tolist(), shares, strict=False)
    ]
    outside = [f"{n:,} {word}" for n, word in ((counted.below, "below"), (counted.above, "above")) if n]
    mode = max(range(len(shares)), key=shares.__getitem__)
    summary = (
        f"Histogram of {total} {noun}. Most, {shares[mode]:.0%}, are from {edges[mode]:.4g} to {edges[mode + 1]:.4g}."
    )
    mark = None
    if ideal is not None:
        x = f"{across(ideal):.1f}"
        mark = tag("line", x1=x, x2=x, y1=TOP, y2=HEIGHT - BOTTOM, class_="ideal")
    axes = [_grid(up, [0, top / 2, top], lambda value: f"{value:.0%}"), _ticks(across, ticks)]
    return _figure(title, summary, html(*axes, *bars, mark), [html(", ".join(outside))])


def line_chart(
    title: str, x_title: str, lines: Sequence[ChartLine], low: float, high: float, *, logarithmic: bool = False
) -> Markup:
    """Chart of one or two lines over a common axis, which differ in dashes and marks as well as in colour.

    The vertical axis goes from ``low`` to ``high``, and may be logarithmic.
    """
    xs = [x for line in lines for x, _ in line.points]
    across = _linear(min(xs), max(max(xs), min(xs) + 1), LEFT + 4, WIDTH - RIGHT - 8)
    up = _linear(*((math.log10(low), math.log10(high)) if logarithmic else (low, high)), HEIGHT - BOTTOM, TOP)
    if logarithmic:
        levels = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        step = max(1, len(levels) // 5)
        axis = _grid(up, [float(k) for k in levels[::step]], lambda value: f"1e{value:.0f}")
        heights: Scale = lambda y: up(math.log10(max(y, low)))  # noqa: E731
    else:
        axis = _grid(up, [low, (low + high) / 2, high], lambda value: f"{value:.4g}")
        heights = up
    drawn = [_line(line, number, across, heights) for number, line in enumerate(lines)]
    ends = "; ".join(f"{line.name} ends at {line.points[-1][1]:.4g}" for line in lines)
    ticks = _whole_ticks(min(xs), max(xs))
    caption = tag("text", x_title, x=(LEFT + WIDTH - RIGHT) / 2, y=HEIGHT - 3, class_="axis middle")
    keys = [tag("span", line.name, class_=f"key key-{k}") for k, line in enumerate(lines)] if len(lines) > 1 else []
    return _figure(title, f"{ends}.", html(axis, _ticks(across, ticks), caption, *drawn), keys)


def _line(line: ChartLine, number: int, across: Scale, up: Scale) -> Markup:
    """A line of a chart with its marks; the number chooses colour and dashes."""
    points = [(across(x), up(y)) for x, y in line.points]
    path = tag("polyline", points=" ".join(f"{x:.1f},{y:.1f}" for x, y in points), class_=f"line line-{number}")
    marks = [
        tag(
            "circle",
            tag("title", f"{line.name}, {x:g}: {value:.4g}"),
            cx=f"{px:.1f}",
            cy=f"{py:.1f}",
            r=2.6,
            class_=f"mark mark-{number}",
        )
        for (px, py), (x, value) in zip(points, line.points, strict=True)
        if line.marked
    ]
    return html(path, *marks)


def _figure(title: str, summary: str, drawing: Markup, notes: Iterable[Markup]) -> Markup:
    head = tag("figcaption", title, tag("span", *notes, class_="note"))
    picture = tag("svg", tag("title", f"{title}. {summary}"), drawing, viewBox=f"0 0 {WIDTH} {HEIGHT}", role="img")
    return tag("figure", head, picture, class_="chart")


def _linear(low: float, high: float, begin: float, end: float) -> Scale:
    return lambda value: begin + (value - low) / (high - low) * (end - begin)


def _grid(up: Scale, levels: Sequence[float], form: Callable[[float], str]) -> Markup:
    """Horizontal lines at the levels, with their values."""
    parts = []
    for level in levels:
        y = up(level)
        parts.append(tag("line", x1=LEFT, x2=WIDTH - RIGHT, y1=f"{y:.1f}", y2=f"{y:.1f}", class_="grid"))
        parts.append(tag("text", form(level), x=LEFT - 5, y=f"{y + 3.5:.1f}", class_="axis end"))
    return html(*parts)


def _ticks(across: Scale, values: Sequence[float]) -> Markup:
    y = HEIGHT - BOTTOM + 14
    return html(*(tag("text", f"{v:.4g}", x=f"{across(v):.1f}", y=y, class_="axis middle") for v in values))


def _whole_ticks(low: float, high: float) -> list[float]:
    step = max(1, math.ceil((high - low) / 8))
    nice = next(m * 10**k for k in range(12) for m in (1, 2, 5) if m * 10**k >= step)
    return [float(value) for value in range(math.ceil(low / nice) * nice, math.floor(high) + 1, nice)]


def _rounded_up(share: float) -> float:
    """The next larger round share."""
    return next(top for top in (0.02, 0.04, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0) if share <= top)
