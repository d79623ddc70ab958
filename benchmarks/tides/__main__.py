"""``python -m benchmarks.tides`` draws two archipelagos, meshes them, lets the tide in, and renews docs/coasts.md.

The shallow-water model of `model` runs on ``fort.14`` as it is read back, in the plane of the mesh. The table has
figures of the meshes, and what is known of the model beforehand: water at rest stays so; between walls its volume stays
the same while waves go about; with the tide it changes by what comes in through the open boundary.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.ablation import ROOT, renewed
from benchmarks.tides.archipelago import draw
from benchmarks.tides.beside import table
from benchmarks.tides.model import Grid, State, advanced
from bubblemesh.cli import app
from bubblemesh.meshfiles.read import read_mesh

PAGE = ROOT / "docs" / "coasts.md"
BEGIN, END = "<!-- tides: begin -->", "<!-- tides: end -->"
PEERS_BEGIN, PEERS_END = "<!-- coast of peers: begin -->", "<!-- coast of peers: end -->"
PERIOD, HEIGHT = 12.42 * 3600, 1.0  # seconds and metres of the tide
SHARE = 0.2  # of the report's time step: triangles are lower than their edges are long, and water flows
TRIAL = 500  # steps at rest, and with closed boundaries
CASE = """
domain:
  box: [-4, 50, 0, 52]
  shoreline: {{file: shore.geojson, smallest: 4 km2, detail: auto{narrowest}}}
crs: {{from: EPSG:4326, to: auto}}
spacing:
  value: 15 km
  near: [{{label: shore, size: 2 km, growth: 0.15}}]
  raster: {{file: depth.asc, name: depth}}
  waves: {{depth: depth, period: 12.42 h, per_length: 150}}
  slope: {{depth: depth, per_slope: 20, filter: 10 km}}
  courant: {{depth: depth, dt: 20 s, largest: 0.7}}
output: {{for: adcirc}}
{more}"""
LARGER = CASE.format(narrowest="", more="").replace("value: 15 km", "value: 15 km\n  scale: 0.5")
FIT = "overconstrained: split\nrequire: {valence_max: 8}\n"
CASES = {  # seed of the drawing, and the case
    "islands": (3, CASE.format(narrowest="", more="")),
    "fit for tides": (8, CASE.format(narrowest=", narrowest: 3", more=FIT)),
}


@dataclass(frozen=True)
class Run:
    """A mesh with its report, as volumes of the model."""

    report: dict[str, Any]
    grid: Grid
    seconds: float  # of the mesh, by the processor

    @property
    def step(self) -> float:
        """Time step of the model in seconds."""
        return SHARE * self.report["water"]["time_step"]


def main() -> None:
    """Mesh, run, print, and put the table on the page."""
    parser = argparse.ArgumentParser("python -m benchmarks.tides", description=__doc__)
    parser.add_argument("--peers", action="store_true", help="mesh one coast by several tools, and renew that table")
    if parser.parse_args().peers:
        beside = table(LARGER)
        print(beside)
        renew(beside, PEERS_BEGIN, PEERS_END)
        return
    columns = {name: dict(rows(meshed(*case))) for name, case in CASES.items()}
    lines = ["| | " + " | ".join(columns) + " |", "|---" * (1 + len(columns)) + "|"]
    for row in next(iter(columns.values())):
        lines.append(f"| {row} | " + " | ".join(column[row] for column in columns.values()) + " |")
    both = "\n".join(lines) + "\n"
    print(both)
    renew(both, BEGIN, END)


def renew(text: str, begin: str, end: str) -> None:
    """Put a table on the page."""
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8"), text, begin, end), encoding="utf-8")


def meshed(seed: int, text: str) -> Run:
    """The mesh of a drawn archipelago, by the command line, as it is read back from ``fort.14``."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        draw(folder, seed)
        (folder / "tide.yaml").write_text(text)
        begin = time.process_time()
        code = app(["run", f"{folder}/tide.yaml", "-o", f"{folder}/fort.14", "--report", "-q"], standalone_mode=False)
        seconds = time.process_time() - begin
        if code:
            raise SystemExit(code)
        read = read_mesh(folder / "fort.14")
        report = json.loads((folder / "fort.report.json").read_text())
    return Run(report, Grid.of(read.mesh, read.point_data["depth"], "open"), seconds)


def rows(run: Run) -> Iterable[tuple[str, str]]:
    """Figures of the mesh and checks of the model, by what they are."""
    quality, water = run.report["quality"], run.report["water"]
    yield "nodes", f"{run.report['nodes']}"
    yield "mean q", f"{quality['mean']:.4f}"
    yield "least q", f"{quality['min']:.3f}"
    yield "least angle", f"{quality['angle_min']:.1f}°"
    yield "most neighbours", f"{water['most_neighbours']}"
    yield "triangles with all nodes on closed boundaries", f"{water['land_triangles']}"
    yield "processor time of the mesh", f"{run.seconds:.1f} s"
    yield "time step", f"{run.step:.1f} s"
    yield f"at rest: largest level, discharge after {TRIAL} steps", "{:.1e} m, {:.1e} m²/s".format(*rest(run))
    yield "between walls: change of the volume, of that in waves", f"{closed(run):.1e}"
    yield from tide(run)


def rest(run: Run) -> tuple[float, float]:
    """Largest level and discharge that arise in still water."""
    state = run.grid.at_rest()
    for _ in range(TRIAL):
        state, _ = advanced(run.grid, state, run.step, 0.0)
    return float(np.abs(state.level).max()), float(np.abs(state.discharge).max())


def closed(run: Run) -> float:
    """Change of the volume, in terms of what is moved, while a hump of a metre runs out between walls."""
    grid = run.grid
    middle = grid.middles[np.argmax(grid.depth)]
    hump = np.exp(-((grid.middles - middle) ** 2).sum(axis=1) / 20e3**2)
    begin = state = State(hump, grid.at_rest().discharge)
    for _ in range(TRIAL):
        state, _ = advanced(grid, state, run.step, None)
    return (grid.volume(state) - grid.volume(begin)) / float(grid.areas @ np.abs(state.level))


def tide(run: Run) -> Iterable[tuple[str, str]]:
    """What a period of the tide does, which begins at still water."""
    grid, state, entered, highest, fastest = run.grid, run.grid.at_rest(), 0.0, -np.inf, 0.0
    steps = int(np.ceil(PERIOD / run.step))
    volumes, courant = [], 0.0
    for count in range(steps):
        state, inflow = advanced(grid, state, run.step, HEIGHT * np.sin(2 * np.pi * (count + 1) * run.step / PERIOD))
        entered += inflow
        if count % 50 == 0 or count == steps - 1:
            volumes.append(grid.volume(state))
            courant = max(courant, grid.courant(state, run.step))
            highest = max(highest, state.level.max())
            fastest = max(fastest, (np.hypot(*state.discharge.T) / (grid.depth + state.level)).max())
    prism = np.ptp(volumes)
    yield "tide: volume between high and low water", f"{prism / 1e9:.2f} km³"
    yield (
        "tide: change of the volume less what came in, in terms of that",
        f"{(grid.volume(state) - entered) / prism:.1e}",
    )
    yield "tide: highest level, fastest flow", f"{highest:.2f} m, {fastest:.2f} m/s"
    yield "tide: largest Courant number of the scheme", f"{courant:.2f}"


if __name__ == "__main__":
    main()
