"""The figures of cases and meshes on the terminal, as their reports hold them."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.text import Text

from bubblemesh import console
from bubblemesh.messages import counted

ROUNDING = 1e-9  # of a domain's size
CHANGES = {"rules": "the terms", "periodic": "one side alone"}  # and what they make the spacing finer than


def show_estimate(figures: Mapping[str, Any]) -> None:
    """Show an estimate, whose figures tell what a case asks for, before any packing."""
    x0, y0, x1, y1 = figures["bounds"]
    size = max(x1 - x0, y1 - y0)
    scale = f", with the spacing times {figures['budget']['scale']:.4g}" if "budget" in figures else ""
    rows = {
        "domain": f"[{x0:.6g}, {x1:.6g}] x [{y0:.6g}, {y1:.6g}], area {figures['area']:.6g}, "
        f"{counted(figures['holes'], 'hole')}",
        "labels": ", ".join(figures["labels"]),
        "spacing": _extremes(figures["spacing"], size),
        **{name: _change(figures[name], than, size) for name, than in CHANGES.items() if name in figures},
        **({"packed": _extremes(figures["packed_spacing"], size)} if "packed_spacing" in figures else {}),
        "nodes": f"about {figures['expected_nodes']:.0f}{scale}",
        "method": figures["method"],
    }
    _show(rows)


def _extremes(spacing: Mapping[str, Any], size: float) -> str:
    least, largest = _place(spacing["minimum_at"], size), _place(spacing["maximum_at"], size)
    return f"{spacing['minimum']:.4g} at {least} to {spacing['maximum']:.4g} at {largest}"


def _change(figures: Mapping[str, Any], than: str, size: float) -> str:
    """Line on how much finer the spacing became than something."""
    where = "" if figures["ratio_at"] is None else f" at {_place(figures['ratio_at'], size)}"
    return f"finer than {than} on {figures['share']:.1%} of the area, at most {figures['ratio']:.3g} times{where}"


def show_quality(figures: Mapping[str, Any]) -> None:
    """Show the quality of a mesh; ``figures`` are those of a report, with or without spacing and time."""
    quality = figures["quality"]
    ideal = figures.get("ideal_nodes")
    rows = {
        "nodes": f"{figures['nodes']}" + (f", {figures['nodes'] / ideal:.3f} of the ideal number" if ideal else ""),
        "triangles": f"{figures['triangles']}, area {figures['area']:.9g}",
        "quality q": f"mean {quality['mean']:.4f}, 1 % below {quality['p01']:.3f}, least {quality['min']:.3f}",
        "angles": f"{quality['angle_min']:.1f} to {quality['angle_max']:.1f} degrees",
        "worst q": ", ".join(f"{worst['quality']:.3f} at {_place(worst['at'])}" for worst in quality["worst"][:3]),
    }
    if quality["irregular_fraction"] is not None:
        rows["irregular"] = f"{quality['irregular_fraction']:.1%} of the inner nodes have not six neighbours"
    if "spacing" in figures:
        spacing = figures["spacing"]
        rows["edges l/d"] = f"{spacing['mean']:.3f} ± {spacing['std']:.3f}, 98 % in " + (
            f"[{spacing['p01']:.2f}, {spacing['p99']:.2f}]"
        )
    if "adaptation" in figures:
        rows |= _adaptation(figures["adaptation"])
    if "budget" in figures:
        budget = figures["budget"]
        meshes = counted(len(budget["attempts"]), "attempt")
        rows["budget"] = f"{budget['nodes']} nodes, met by the spacing times {budget['scale']:.4g}, in {meshes}"
    if "stop_reason" in figures:
        rows["stopped"] = f"{figures['stop_reason']}"
        rows["time"] = f"{figures['seconds']['total']:.2f} s"
    _show(rows)


def _adaptation(figures: Mapping[str, Any]) -> dict[str, str]:
    """Rows on the error of a solution before and after, as far as it is known."""
    true = ""
    if figures.get("effectivity") is not None:
        true = f", {figures['effectivity']:.3f} times the true one of {figures['true_error']:.4g}"
    kept = f"{figures['unchanged']:.0%} of the nodes are where sizes stay"
    start = "they are the start" if figures["start"] == "present nodes" else "the start is a new one"
    return {
        "solution": f"{figures['field']} on {figures['nodes_before']} nodes, estimated error {figures['error']:.4g}, "
        f"{figures['relative_error']:.2%}{true}",
        "adapted": f"to an expected error of {figures['expected_relative_error']:.2%}; {kept}: {start}",
    }


def show_files(folder: str, files: Sequence[str]) -> None:
    """Show which files were written."""
    _show({"files": ", ".join(files) + ("" if folder in (".", "") else f" in {folder}")})


def _show(rows: Mapping[str, str]) -> None:
    for name, value in rows.items():
        console.terminal.print(Text.assemble((f"{name:11}", "bold"), value))


def _place(point: Sequence[float], size: float = 0.0) -> str:
    """A point; what is nothing but rounding in a domain of some size is zero."""
    x, y = (0.0 if abs(value) < ROUNDING * size else value for value in point)
    return f"({x:.4g}, {y:.4g})"
