"""The picture of docs/layers.md: ``python -m benchmarks.layers_figure`` makes it anew of the case on that page."""

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.light import save
from bubblemesh.case import load_case
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.pictures.plots import draw_into
from bubblemesh.pictures.styles import PlotOptions, View
from bubblemesh.run.pipeline import mesh_case

PAGE = Path(__file__).parent.parent / "docs" / "layers.md"
FIGURE = PAGE.parent / "figures" / "layers.png"
STEP, OUTLET = (1.2, -0.01, 2.0, 0.55), (2.5, -0.01, 3.02, 0.35)
PANELS: dict[tuple[str, str], View] = {
    ("corners: fans", "corners: fans"): STEP,
    ("corners: fans", "corners: plain"): STEP,
    ("ends: follow", "ends: follow"): OUTLET,
    ("ends: follow", "ends: taper"): OUTLET,
}


def main() -> None:
    """Make the picture."""
    figure = Figure(figsize=(9, 6.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2)
    for place, ((old, new), view) in zip(axes.flat, PANELS.items(), strict=True):
        draw_into(place, step(old, new), PlotOptions(color="none", view=view, labels=False, axes=False))
        place.set_title(new, fontsize=11)
    save(figure, FIGURE, dpi=90)


def step(old: str, new: str) -> Mesh:
    """The mesh of the step, with one key changed."""
    case = PAGE.read_text(encoding="utf-8").partition("# step.yaml\n")[2].partition("```")[0]
    assert old in case
    return mesh_case(load_case("step.yaml", text=case.replace(old, new))).mesh


if __name__ == "__main__":
    main()
