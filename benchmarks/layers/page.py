"""The page docs/layer-figures.md."""

from collections.abc import Iterator, Mapping, Sequence
from math import isnan, nan, sqrt
from statistics import median

from benchmarks.layers.gradients import CLOSE, FLOWS, Flow, Needed
from benchmarks.layers.runs import Run
from benchmarks.layers.section import Section
from benchmarks.layers.tools import FANS, OURS, PLAIN
from benchmarks.peers.machine import machine
from benchmarks.peers.runs import ROOT

PAGE = ROOT / "docs" / "layer-figures.md"
SLOWEST = 1.5  # goal: processor time over Gmsh's
FEWEST = 5  # goal: nodes of an isotropic mesh over those of one with layers
HEAD = """# Boundary layers in figures

[Boundary layers](layers.md), made by `python -m benchmarks.layers` on {machine}:
{versions}.

## Beside Gmsh

Gmsh runs as a program of its own, with its field `BoundaryLayer` for the same first height, growth and thickness, the
same spacing elsewhere, and Frontal-Delaunay. It is given a fan at each convex corner of the walls above 220 degrees or,
where no valid mesh comes of that, none. Every mesh is checked by code of its own: triangles counter-clockwise, no node
unused or double, boundary edges are the free edges and do not cross, the area is right to 1e-12, walls are edges of the
mesh, nodes on periodic sides match. Figures are taken from nodes and triangles alone:

- *First height* of the edges of the walls over the wanted one, least, mean and largest; *kept*: on which share of the
  walls' length it is within 5 %.
- *Growth*: median ratio of successive heights, where 1.2 is asked for; *steady*: share of the ratios within 5 % of it.
- *Upright*: angle between the wall and the first layer's columns, mean and least; at a convex corner without a fan and
  at a concave one it is less than a right angle for any tool.
- *Aspect*: largest ratio of a wall's edge to the height above.
- *Time*: processor seconds of the second run in one process, median of {repeats}, both tools in turns. That of
  bubblemesh is from the case to the mesh with its report, that of Gmsh its `generate`. *Layers*: by how much that is
  more than for the same shape without layers. *Program*: the same of whole programs, from their start to a file in
  Gmsh's format: `bubblemesh run`, and a Python script that draws the shape for Gmsh.
"""
SHAPES = (
    "shape",
    "tool",
    "nodes",
    "first height",
    "kept",
    "growth",
    "steady",
    "upright",
    "aspect",
    "time",
    "layers",
    "program",
)
FLOW = ("flow", "nodes with layers", "first height", "error", "nodes, isotropic", "size there", "error", "ratio")
SECTION = ("cells", "nodes", "cells for SU2", "markers", "area", "checkMesh", "not orthogonal", "skewness", "aspect")
GRADIENTS = """## The gradient at the wall

Nodes of the first mesh in which the gradient of the velocity is right to {close:.0%} on every edge of the wall, solved
in scikit-fem, in a series that is finer there by a fifth each time. The channel has the parabola of laminar flow. The
plate has the asymptotic suction profile 1 - exp(-y/d), an exact solution of the equations of Navier and Stokes, with d
a hundredth of the domain's height. Layers are `until: isotropic` with growth 1.2; the isotropic mesh has its size at
the wall and grows by 0.2. *Uniform*: nodes of a mesh that is as fine everywhere, not solved.
"""
SECTIONS = """## A profile for SU2 and OpenFOAM

NACA 0012 with layers of first height 1e-5, written for both solvers. The file for SU2 is read by the format's published
description; *area* tells by how much that of its cells is off. The file for OpenFOAM goes through `gmshToFoam` and
`checkMesh`. *Not orthogonal*: largest and mean angle between a face's normal and the line between the middles of its
two cells. It is large between flat triangles: finite volumes take `cells: quads`.
"""


def page(
    runs: Mapping[str, Mapping[str, Run]],
    gradients: Mapping[str, Sequence[Needed]],
    sections: Mapping[str, Section],
    versions: str,
    repeats: int,
) -> str:
    """The whole page."""
    text = HEAD.format(machine=machine(), versions=versions, repeats=repeats)
    beside = "\n".join([*_table(SHAPES, _beside(runs)), "", _verdict(runs)])
    return f"{text}\n{beside}\n\n{_gradients(gradients)}\n\n{_sections(sections)}\n"


def best_of_gmsh(runs: Mapping[str, Run]) -> Run:
    """The run with fans, or the one without if that alone made a valid mesh."""
    return runs[PLAIN] if runs[FANS].failure and not runs[PLAIN].failure else runs[FANS]


def _table(head: Sequence[str], rows: Iterator[str]) -> list[str]:
    return [f"| {' | '.join(head)} |", "|---" * len(head) + "|", *rows]


def _beside(runs: Mapping[str, Mapping[str, Run]]) -> Iterator[str]:
    for name, tools in runs.items():
        yield f"| {name} | bubblemesh | {_cells(tools[OURS])} |"
        yield f"| | Gmsh | {_cells(best_of_gmsh(tools))} |"


def _cells(run: Run) -> str:
    found = run.figures
    if found is None:
        return f"**none**: {run.failure} | | | | | | | | |"
    return " | ".join(
        [
            f"{found.nodes}",
            f"{found.least:.3f} / {found.mean:.3f} / {found.largest:.3f}",
            f"{found.kept:.1%}",
            f"{found.growth:.3f}",
            f"{found.steady:.1%}",
            f"{found.upright:.1f}° / {found.least_upright:.1f}°",
            f"{found.aspect:.3g}",
            f"{run.seconds:.3f} s",
            f"{run.seconds - run.bare:.3f} s",
            f"{run.program:.2f} s" if not isnan(run.program) else "",
        ]
    )


def _verdict(runs: Mapping[str, Mapping[str, Run]]) -> str:
    pairs = {name: (tools[OURS], best_of_gmsh(tools)) for name, tools in runs.items()}
    ours, theirs = (sum(not pair[k].failure for pair in pairs.values()) for k in (0, 1))
    both = [pair for pair in pairs.values() if not (pair[0].failure or pair[1].failure)]
    valid = f"Valid meshes: bubblemesh {ours} of {len(runs)}, Gmsh {theirs}."
    if not both:
        return valid
    ratios = [a.seconds / b.seconds for a, b in both]
    programs = [a.program / b.program for a, b in both if not isnan(b.program)] or [nan]
    a, b = zip(*both, strict=True)
    added = sum(one.seconds - one.bare for one in a) / sum(one.seconds - one.bare for one in b)
    return (
        f"{valid} Where both have one, bubblemesh takes {median(ratios):.1f} times the time of Gmsh (median; "
        f"{min(ratios):.1f} to {max(ratios):.1f}): the goal of {SLOWEST} times is {_reached(max(ratios) <= SLOWEST)}. "
        f"Of whole programs that is {median(programs):.1f} times ({min(programs):.1f} to {max(programs):.1f}). "
        f"What layers add to the time, over all of these shapes, is {added:.1f} times that of Gmsh."
    )


def _reached(well: bool) -> str:
    return "reached" if well else "**not reached**"


def _gradients(found: Mapping[str, Sequence[Needed]]) -> str:
    flows = {flow.name: flow for flow in FLOWS}
    rows = (_needed(flows[name], *pair) for name, pair in found.items())
    least = min(isotropic.nodes / layered.nodes for layered, isotropic in found.values())
    goal = f"The goal of {FEWEST} times fewer nodes is {_reached(least >= FEWEST)}: at least {least:.1f} times."
    return "\n".join([GRADIENTS.format(close=CLOSE), *_table((*FLOW, "uniform"), rows), "", goal])


def _needed(flow: Flow, layered: Needed, isotropic: Needed) -> str:
    uniform = flow.length * flow.height / (isotropic.size**2 * sqrt(3) / 2)
    columns = [
        flow.name,
        *(f"{found.nodes} | {found.size:.2g} | {found.error:.2%}" for found in (layered, isotropic)),
        f"{isotropic.nodes / layered.nodes:.1f}",
        f"{uniform:,.0f}",
    ]
    return f"| {' | '.join(columns)} |"


def _sections(found: Mapping[str, Section]) -> str:
    return "\n".join([SECTIONS, *_table(SECTION, (_section(cells, one) for cells, one in found.items()))])


def _section(cells: str, one: Section) -> str:
    markers = ", ".join(f"{label}: {count}" for label, count in one.su2.markers.items())
    area = f"{abs(one.su2.area / one.area - 1):.0e}"
    foam = one.openfoam
    if foam is None:
        verdict = "not installed here | | | "
    else:
        angle = f"{foam.orthogonality:.0f}° / {foam.mean_orthogonality:.0f}°"
        verdict = f"{foam.verdict} | {angle} | {foam.skewness:.2f} | {foam.aspect:.3g}"
    return f"| {cells} | {one.nodes} | {one.su2.cells} | {markers} | {area} | {verdict} |"
