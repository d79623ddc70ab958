"""What the user sees on the terminal; all of it goes to the error stream, which leaves the output to data."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

if TYPE_CHECKING:  # an error must be shown even where NumPy cannot be loaded
    from bubblemesh.problem.problem import Problem
    from bubblemesh.spacing.survey import Extremes, Survey

__all__ = ["counted", "fail", "show_files", "show_problem", "show_quality", "warn"]

ROUNDING = 1e-9  # of a domain's size

terminal = Console(stderr=True, highlight=False, soft_wrap=True)


def show_problem(problem: "Problem") -> None:
    """What a case asks for, before any packing."""
    domain, survey = problem.domain, problem.survey
    x0, y0, x1, y1 = domain.bounds
    rows = {
        "domain": f"[{x0:.6g}, {x1:.6g}] x [{y0:.6g}, {y1:.6g}], area {domain.polygon.area:.6g}, "
        f"{counted(domain.hole_count, 'hole')}",
        "labels": ", ".join(domain.boundary.labels),
        "spacing": _extremes(survey, domain.size),
        **_rules(problem),
        **({"packed": _extremes(problem.packed, domain.size)} if problem.refined else {}),
        "nodes": f"about {problem.expected_nodes:.0f}" + _scale(problem),
        "method": problem.task.method_name,
    }
    _show(rows)


def _extremes(found: "Survey | Extremes", size: float) -> str:
    least, largest = _place(found.minimum_at, size), _place(found.maximum_at, size)
    return f"{found.minimum:.4g} at {least} to {found.maximum:.4g} at {largest}"


def _rules(problem: "Problem") -> dict[str, str]:
    """What the rules of the spacing and its periodic sides changed."""
    rows = {}
    for name, changed in problem.changes.items():
        than = "the terms" if name == "rules" else "one side alone"
        where = "" if changed.ratio_at is None else f" at {_place(changed.ratio_at, problem.domain.size)}"
        area = f"finer than {than} on {changed.share:.1%} of the area"
        rows[name] = f"{area}, at most {changed.ratio:.3g} times{where}"
    return rows


def _scale(problem: "Problem") -> str:
    return "" if problem.node_target is None else f", with the spacing times {problem.node_target.scale:.4g}"


def show_quality(figures: Mapping[str, Any]) -> None:
    """The quality of a mesh; ``figures`` are those of a report, with or without spacing and time."""
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
    """What is known of the error of a solution, before and after."""
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
    """The files that were written."""
    _show({"files": ", ".join(files) + ("" if folder in (".", "") else f" in {folder}")})


def warn(messages: Sequence[str]) -> None:
    """Compromises that the user should know of."""
    for message in messages:
        terminal.print(Text.assemble(("warning: ", "yellow"), message))


def fail(message: str) -> None:
    """Why the command ends without what it was asked for."""
    terminal.print(Text.assemble(("error: ", "bold red"), message))


def _show(rows: Mapping[str, str]) -> None:
    for name, value in rows.items():
        terminal.print(Text.assemble((f"{name:11}", "bold"), value))


def _place(point: Sequence[float], size: float = 0.0) -> str:
    """A point; what is nothing but rounding in a domain of some size is zero."""
    x, y = (0.0 if abs(value) < ROUNDING * size else value for value in point)
    return f"({x:.4g}, {y:.4g})"


def counted(number: int, noun: str) -> str:
    """A count with its noun: no holes, 1 hole, 2 holes."""
    return f"{number} {noun}" if number == 1 else f"{number or 'no'} {noun}s"
