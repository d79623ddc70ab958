"""The figures of cases and meshes on the terminal, as their reports hold them; those of two meshes side by side."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from rich.table import Table
from rich.text import Text

from bubblemesh import console
from bubblemesh.console import Terminal
from bubblemesh.meshes.histograms import Histogram
from bubblemesh.meshes.periodic import motion_text
from bubblemesh.messages import coordinate, counted, duration, place, run_seconds, shown

MOST_REPAIRS = 20  # that a table shows
MOST_NAMES = 20  # of labels or files
MOST_PARTS = 8  # regions or labels that a table shows
FAR_BEYOND = 10  # height of a triangle beside the last layer, in heights of that, from which on it is printed
CHANGES = {"rules": "the terms", "periodic": "one side alone"}  # what each change makes the spacing finer than
TITLES = {"quality": "q", "spacing": "edges l/d"}
BAR = 22  # characters, at most
BESIDE_BARS = 32  # characters of a line
EIGHTHS = " ▏▎▍▌▋▊▉█"  # of a character


def show_estimate(figures: Mapping[str, Any], to: Terminal) -> None:
    """Print the figures of an estimate: what a case asks for, before any packing."""
    x0, y0, x1, y1 = figures["bounds"]
    size = max(x1 - x0, y1 - y0)
    x, y = ([coordinate(end, size) for end in ends] for ends in ((x0, x1), (y0, y1)))
    scale = f", with the spacing times {figures['node_target']['scale']:.4g}" if "node_target" in figures else ""
    pieces = f"{counted(figures['pieces'], 'piece')}, " if figures["pieces"] > 1 else ""
    rows = {
        "domain": f"[{x[0]}, {x[1]}] x [{y[0]}, {y[1]}], area {figures['area']:.6g}, "
        f"{pieces}{counted(figures['holes'], 'hole')}",
        **_regions(figures["regions"]),
        **_rest(figures, size),
        "labels": _named(figures["labels"]),
        **_sides(figures, size),
        "spacing": _extremes(figures["spacing"], size),
        **{name: _change(figures[name], than, size) for name, than in CHANGES.items() if name in figures},
        **({"metric": _longest(figures["metric"])} if "metric" in figures else {}),
        **({"packed": _extremes(figures["packed_spacing"], size)} if "packed_spacing" in figures else {}),
        **({"layers": "\n".join(_layers(figures["layers"]))} if "layers" in figures else {}),
        "nodes": f"about {figures['expected_nodes']:.0f}{scale}",
        "method": figures["method"],
    }
    _show(rows, to)
    if "repairs" in figures:
        _show_repairs(figures["repairs"], size, to)


def _sides(figures: Mapping[str, Any], size: float) -> dict[str, str]:
    """Row with the motions of periodic sides, if there are any."""
    motions = [motion_text(row, size) for row in figures.get("periodic_sides", ())]
    return {"sides": "; ".join(motions)} if motions else {}


def _regions(rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Row with the areas of regions, if there are several."""
    return {"regions": _named([f"{row['name']} {row['area']:.6g}" for row in rows])} if len(rows) > 1 else {}


def _rest(figures: Mapping[str, Any], size: float) -> dict[str, str]:
    """Row with the parts that no point of a region names, if there are several."""
    if "rest" not in figures:
        return {}
    rest = figures["rest"]
    told = [f"{part['area']:.4g} at {place(part['at'], size)}" for part in rest["parts"]]
    if (more := rest["number"] - len(told)) > 0:
        told[-1] = f"{more:,} more, and the smallest, {told[-1]}"
    return {"rest": f"{rest['region']} has {rest['number']} parts that no point names: {', '.join(told)}"}


def _longest(figures: Mapping[str, Any]) -> str:
    """Line on the ellipses of a metric; the spacing gives only their area."""
    return f"ellipses of the area of such circles, up to {figures['aspect']:.3g} times as long as wide"


def _layers(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """A line on the boundary layers of each label."""
    for row in rows:
        where = "" if row["region"] is None else f" in {row['region']}"
        first, count, angle = row["first"], row["count"], row["orthogonality"]
        number = (
            counted(count["most"], "layer")
            if count["least"] == count["most"]
            else (f"{count['least']} to {count['most']} layers")
        )
        heights = f", first {row['wanted']:.3g} x {first['mean']:.3f} (kept on {first['kept']:.1%})" if angle else ""
        aspect = f", aspect {row['aspect']:.3g}" if first else ""
        upright = f", {angle['least']:.0f} degrees upright or more" if angle else ""
        flattest = "" if row["angle_max"] is None else f", angles up to {row['angle_max']['degrees']:.1f} degrees"
        about = "about " if row["angle_max"] is None else ""  # before the packing
        beyond = "" if row["across_front"] is None else f", {about}{row['across_front']:.2f} times the last one beyond"
        if beyond and (most := row["farthest"])["ratio"] > FAR_BEYOND:
            beyond += f" (up to {most['ratio']:.3g} at {place(most['at'])})"
        yield (
            f"{row['label']}{where}: {number} in {counted(row['columns'], 'column')}, {row['complete']:.1%} complete"
            f"{heights}{aspect}{upright}{flattest}{beyond}"
        )


def _show_repairs(rows: Sequence[Mapping[str, Any]], size: float, to: Terminal) -> None:
    """Print a table of the changes of rings: what was changed, where, and by how much the area changed."""
    table = console.new_table()
    table.add_column("repair")
    table.add_column("at", no_wrap=True)
    table.add_column("area", justify="right", no_wrap=True)
    for row in rows[:MOST_REPAIRS]:
        table.add_row(row["what"], place(row["at"], size), f"{row['area']:+.4g}" if row["area"] else "0")
    if len(rows) > MOST_REPAIRS:
        rest = sum(row["area"] for row in rows[MOST_REPAIRS:])
        table.add_row(f"and {len(rows) - MOST_REPAIRS:,} more", "", f"{rest:+.4g}")
    to.print(table)


def _named(names: Sequence[str]) -> str:
    few = names if len(names) <= MOST_NAMES else [*names[:MOST_NAMES], f"and {len(names) - MOST_NAMES:,} more"]
    return ", ".join(few)


def _extremes(spacing: Mapping[str, Any], size: float) -> str:
    least, largest = place(spacing["minimum_at"], size), place(spacing["maximum_at"], size)
    return f"{spacing['minimum']:.4g} at {least} to {spacing['maximum']:.4g} at {largest}"


def _change(figures: Mapping[str, Any], than: str, size: float) -> str:
    """Line on how much finer the spacing became, and than what."""
    where = "" if figures["ratio_at"] is None else f" at {place(figures['ratio_at'], size)}"
    return f"finer than {than} on {figures['share']:.1%} of the area, at most {figures['ratio']:.3g} times{where}"


def show_quality(figures: Mapping[str, Any], to: Terminal) -> None:
    """Print the quality of a mesh; ``figures`` are those of a report, with or without spacing and time."""
    quality = figures["quality"]
    ideal = None if "layers" in figures else figures.get("ideal_nodes")
    x0, y0, x1, y1 = figures["bounds"]
    size = max(x1 - x0, y1 - y0)
    output = figures.get("parameters", {}).get("output", {})
    at_corners = " at corners" if output.get("order") == 2 else ""
    rows = {
        "nodes": f"{figures['nodes']}{at_corners}"
        + (f", {figures['nodes'] / ideal:.3f} of the ideal number" if ideal else ""),
        "triangles": f"{figures['triangles']}, area {figures['area']:.9g}",
        "quality q": f"mean {quality['mean']:.4f}, 1 % below {quality['p01']:.3f}, least {quality['min']:.3f}",
        "angles": f"{quality['angle_min']:.1f} to {quality['angle_max']:.1f} degrees",
        "worst q": ", ".join(f"{worst['quality']:.3f} at {place(worst['at'], size)}" for worst in quality["worst"][:3]),
    }
    if "obtuse_fraction" in quality:  # which only the command `quality` asks for
        rows["angles"] += f", {quality['obtuse_fraction']:.1%} of the triangles are obtuse"
    if quality["irregular_fraction"] is not None:
        rows["irregular"] = f"{quality['irregular_fraction']:.1%} of the inner nodes do not have six neighbours"
    if "spacing" in figures:
        spacing = figures["spacing"]
        rows["edges l/d"] = f"{spacing['mean']:.3f} ± {spacing['std']:.3f}, 98 % in " + (
            f"[{spacing['p01']:.2f}, {spacing['p99']:.2f}]"
        )
    if "metric" in figures:
        rows["metric"] = _metric(figures["metric"], size)
    rows |= _rest(figures, size) | _sides(figures, size) | _asked_for(figures)
    if "stop_reason" in figures:
        rows["stopped"] = f"{figures['stop_reason']}"
        rows["time"] = duration(run_seconds(figures["seconds"]))
    _show(rows, to)
    if len(regions := figures.get("regions", ())) > 1:  # one alone has the figures of the whole mesh
        _show_parts(regions, ("region", "triangles", "area"), to)
    if labels := figures.get("labels"):
        _show_parts(labels, ("label", "edges", "length"), to)
    if "repairs" in figures:
        _show_repairs(figures["repairs"], size, to)


def _show_parts(rows: Sequence[Mapping[str, Any]], heads: tuple[str, str, str], to: Terminal) -> None:
    """Print a table of regions or labels, one a row: name, number of cells, area or length; many are cut."""
    _, cells, size = heads
    told = [(row["name"], row[cells], row[size]) for row in rows]
    if len(rows) > MOST_PARTS + 1:  # a last row on a single one would save nothing
        rest = rows[MOST_PARTS:]
        sums = (sum(row[key] for row in rest) for key in (cells, size))
        told[MOST_PARTS:] = [(f"and {len(rest):,} more", *sums)]
    table = console.new_table()
    table.add_column(heads[0], no_wrap=True)
    for head in heads[1:]:
        table.add_column(head, justify="right", no_wrap=True)
    for name, count, extent in told:
        table.add_row(shown(name), f"{count:,}", f"{extent:.6g}")
    to.print(table)


def _metric(figures: Mapping[str, Any], size: float) -> str:
    """Lines on how well a mesh fits its metric; quality and edge lengths are those in the metric."""
    line = (
        f"ellipses up to {figures['aspect']:.3g} times as long as wide, {figures['edges_within']:.1%} of the edges in "
        "[0.71, 1.41]"
    )
    row = figures.get("shortened")
    if row is None:
        return line
    return (
        f"{line}\nshorter along at {row['share']:.1%} of the nodes, {row['ratio']:.3g} times at "
        f"{place(row['ratio_at'], size)}: as such, q mean {row['quality_mean']:.4f}, 1 % below "
        f"{row['quality_p01']:.3f}, least {row['quality_min']:.3f}"
    )


def _asked_for(figures: Mapping[str, Any]) -> dict[str, str]:
    """Rows for features that only some cases use."""
    rows = dict[str, str]()
    if "crs" in figures:
        rows["crs"] = _plane(figures["crs"])
    if "water" in figures:
        rows["water"] = _water(figures["water"])
    if "adaptation" in figures:
        rows |= _adaptation(figures["adaptation"])
    if "node_target" in figures:
        target = figures["node_target"]
        meshes = counted(len(target["attempts"]), "attempt")
        rows["target"] = f"{target['nodes']} nodes, met by the spacing times {target['scale']:.4g}, in {meshes}"
    if "refinement" in figures:
        rows["refined"] = _refinement(figures["refinement"])
    if "layers" in figures:
        rows["layers"] = "\n".join(_layers(figures["layers"]))
    if "parts" in figures:
        parts = figures["parts"]
        rows["parts"] = f"{parts['number']} of {parts['least_nodes']} to {parts['most_nodes']} nodes"
    if "partition" in figures:
        rows["partition"] = _partition(figures["partition"])
    return rows


def _refinement(figures: Mapping[str, Any]) -> str:
    """Line on the nodes added for demands on triangles, and on what was reached."""
    corners = len(figures["excused"])
    but = f", but for {counted(corners, 'sharper corner')}" if corners else ""
    least = f", least angle {figures['least_angle']:.1f} degrees{but}" if figures["angle_min"] else ""
    area = f", largest area {figures['largest_excess']:.2f} of the one allowed" if figures["largest_excess"] else ""
    left = figures["overconstrained"]
    inside = "" if left is None else f", {counted(left, 'triangle')} with all nodes on the boundary"
    return f"{counted(figures['nodes_added'], 'node')} added{least}{area}{inside}"


def _partition(figures: Mapping[str, Any]) -> str:
    """Line on the parts of a mesh and what they share."""
    sizes, halo = figures["triangles"], figures["halo"]
    apart = counted(figures["in_several_pieces"], "part")
    pieces = f", {apart} in several pieces" if figures["in_several_pieces"] else ""
    return (
        f"{counted(figures['parts'], 'part')} by {figures['by']}, {sizes['min']} to {sizes['max']} triangles each, "
        f"{counted(figures['edge_cut'], 'edge')} cut, halos of {halo['min']} to {halo['max']} triangles{pieces}"
    )


def _water(figures: Mapping[str, Any]) -> str:
    """Line on depths, and on the figures that models of tides need."""
    least, largest = figures["depth"]
    step = "all dry"
    if figures["time_step"] is not None:
        step = f"Courant number 1 at a time step of {figures['time_step']:.3g} s, at {place(figures['time_step_at'])}"
    return (
        f"depth {least:.4g} to {largest:.4g} m; {step}; at most {figures['most_neighbours']} neighbours, "
        f"{counted(figures['land_triangles'], 'triangle')} with all nodes on closed boundaries, "
        f"{counted(figures['dead_ends'], 'dead end')}, {figures['cut_off']} cut off"
    )


def _plane(figures: Mapping[str, Any]) -> str:
    """Line on the systems of coordinates."""
    least, largest = figures["scale"]
    written = "as they are in it" if figures["target"] == "auto" else f"in {figures['target']}"
    plane = figures["plane"].partition(" +k")[0]
    longer = f"lengths are {least - 1:.2%} to {largest - 1:.2%} longer; the spacing allows for this"
    return f"{figures['source']} in the plane {plane}, where {longer}; coordinates are written {written}"


def _adaptation(figures: Mapping[str, Any]) -> dict[str, str]:
    """Rows on the error of a solution before and after, if known."""
    true = ""
    if figures.get("effectivity") is not None:
        true = f", {figures['effectivity']:.3f} times the true one of {figures['true_error']:.4g}"
    kept = f"{figures['unchanged']:.0%} of the nodes are where sizes stay"
    start = "they are the start" if figures["start"] == "present nodes" else "the start is a new one"
    by = " by the number of nodes alone, less what the directions gain" if figures.get("anisotropic") else ""
    return {
        "solution": f"{figures['field']} on {figures['nodes_before']} nodes, estimated error {figures['error']:.4g}, "
        f"{figures['relative_error']:.2%}{true}",
        "adapted": f"to an expected error of {figures['expected_relative_error']:.2%}{by}; {kept}: {start}",
    }


def show_files(folder: str, files: Sequence[str]) -> None:
    """Print which files were written."""
    _show({"files": _named(files) + ("" if folder in (".", "") else f" in {folder}")}, console.terminal)


def _show(rows: Mapping[str, str], to: Terminal) -> None:
    for name, value in rows.items():
        to.print(Text.assemble((f"{name:11}", "bold"), value))


def show_comparison(
    names: Sequence[str],
    rows: Iterable[tuple[str, str, str, str]],
    histograms: Mapping[str, Sequence[Histogram | None]],
) -> None:
    """Print two meshes side by side on the standard output: figures, differences, and histograms as bars of text."""
    for letter, name in zip("AB", names, strict=True):
        console.output.print(Text.assemble((f"{letter:11}", "bold"), name))
    table = console.new_table()
    table.add_column("")
    for column in ("A", "B", "B - A"):
        table.add_column(column, justify="right", no_wrap=True)
    for cells in rows:
        table.add_row(*cells)
    console.output.print(table)
    for title, both in histograms.items():
        if any(histogram is not None for histogram in both):
            console.output.print()
            console.output.print(_bars(TITLES[title], both))


def _bars(title: str, both: Sequence[Histogram | None]) -> Table:
    """Shares of two histograms of the same bins, bin by bin."""
    known = [histogram for histogram in both if histogram is not None]
    edges = [f"{edge:.2f}" for edge in known[0].edges]
    bins = [f"below {edges[0]}", *(f"{low} to {high}" for low, high in pairwise(edges)), f"above {edges[-1]}"]
    shares = [None if h is None else [n / h.total for n in (h.below, *h.counts, h.above)] for h in both]
    largest = max(max(column) for column in shares if column is not None)
    length = min(BAR, max((console.output.width - BESIDE_BARS) // 2, 0))
    table = console.new_table()
    for column in (title, "A", "", "B", ""):
        table.add_column(column, justify="right" if column in ("A", "B") else "left", no_wrap=True)
    for k, name in enumerate(bins):
        cells = [(None if column is None else column[k]) for column in shares]
        if any(cells) or 0 < k < len(bins) - 1:
            table.add_row(name, *(text for share in cells for text in _bar(share, largest, length)))
    return table


def _bar(share: float | None, largest: float, length: int) -> tuple[str, str]:
    """A share in percent, and a bar in eighths of a character's width; that of the largest has the full length."""
    if share is None:
        return "-", ""
    full, part = divmod(round(8 * length * share / largest), 8)
    return f"{share:.1%}", EIGHTHS[-1] * full + EIGHTHS[part].strip()
