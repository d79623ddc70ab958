"""Makes the samples anew: ``python sample_outputs/make.py`` writes all that is under version control here.

``--meshes`` writes the mesh files and the report of every case as well, which are not.
"""

import argparse
from pathlib import Path
from typing import Any

from bubblemesh import load_case, mesh_case
from bubblemesh.cli import app
from bubblemesh.meshes.mesh import Mesh
from bubblemesh.meshfiles.formats import FORMATS
from bubblemesh.pictures.colouring import MeshData
from bubblemesh.pictures.plots import small_png
from bubblemesh.pictures.styles import PlotOptions, View

HERE = Path(__file__).parent
CONFIGS = HERE.parent / "configs"
QUICKSTART = CONFIGS / "quickstart.yaml"
CASES = [
    QUICKSTART,
    *sorted((CONFIGS / "paper").glob("example-*.yaml")),
    CONFIGS / "paper" / "dense.yaml",
    *sorted((CONFIGS / "gallery").glob("*.yaml")),
]
VIEWS = {"flap": (-0.08, -0.28, 1.4, 0.2)}  # of cases whose whole mesh shows nothing: x0, y0, x1, y1
COARSE = ("--set", "parameters.h=0.15")  # the one mesh that is here in every format
MOST_BYTES = 60_000  # of a picture
DPI = (110, 100, 90, 80, 70, 60, 50, 40)
HEAD = """# Sample outputs

`python sample_outputs/make.py` makes all files of this folder, this page included; with `--meshes` it writes the mesh
files of every case beside them. [files](files) has one small mesh, that of the first case, in every format. Where there
are boundary layers, quality and edges are those of the triangles beside them.

| case | nodes | of the ideal number | mean q | least q | edges l/d | picture |
|---|---|---|---|---|---|---|
"""
ROW = (
    "| [{path}](../{path}) | {nodes} | {ratio} | {mean:.4f} | {least:.3f} | {fit:.3f} ± {spread:.3f} "
    '| <img src="{name}.png" width="320" alt="mesh of {name}"> |\n'
)


def picture(mesh: Mesh, view: View | None, data: MeshData) -> bytes:
    """Picture of a mesh as PNG, as sharp as its largest size in bytes allows."""
    for dpi in DPI:
        content = small_png(mesh, PlotOptions(dpi=dpi, view=view), data)
        if len(content) <= MOST_BYTES:
            return content
    raise SystemExit(f"the picture has {len(content)} bytes, more than {MOST_BYTES}")


def run(case: Path, *options: str) -> None:
    """Call ``bubblemesh run``."""
    app(["run", str(case), "-q", *options], standalone_mode=False)


def sample(case: Path, folder: Path) -> str:
    """Draw the mesh of a case into a folder, and return its row of the page."""
    result = mesh_case(load_case(case))
    report: Any = result.report
    (folder / f"{report['case']}.png").write_bytes(
        picture(result.mesh, VIEWS.get(report["case"]), MeshData(result.fields))
    )
    return ROW.format(
        path=case.relative_to(HERE.parent).as_posix(),
        name=report["case"],
        nodes=report["nodes"],
        ratio="-" if "layers" in report else f"{report['nodes'] / report['ideal_nodes']:.2f}",
        mean=report["quality"]["mean"],
        least=report["quality"]["min"],
        fit=report["spacing"]["mean"],
        spread=report["spacing"]["std"],
    )


def every_format(case: Path, folder: Path) -> None:
    """Write a coarse mesh of a case in every format, and its page."""
    for name, form in FORMATS.items():
        alone = sum(form.files[0] == other.files[0] for other in FORMATS.values()) == 1
        run(case, *COARSE, "-o", f"{folder}/{case.stem}{'' if alone else f'-{name}'}{form.files[0]}", "--format", name)
    for path in folder.glob(f"{case.stem}*.report.json"):
        path.unlink()
    run(case, *COARSE, "-o", f"{folder / case.stem}.vtu", "--report")


def main() -> None:
    """Make the samples."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--meshes", action="store_true", help="write the mesh files of every case as well")
    options = parser.parse_args()
    (HERE / "README.md").write_text(HEAD + "".join(sample(case, HERE) for case in CASES), encoding="utf-8")
    every_format(QUICKSTART, HERE / "files")
    for case in CASES if options.meshes else ():
        run(case, "-o", f"{HERE}/", "--set", "output.formats=[msh, vtu]")


if __name__ == "__main__":
    main()
