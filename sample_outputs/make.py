"""Meshes every case of ``configs/`` into this folder: ``python sample_outputs/make.py``."""

from pathlib import Path

from bubblemesh.case import load_case
from bubblemesh.meshfiles.writing import write_files
from bubblemesh.pictures.plots import draw_mesh
from bubblemesh.run.pipeline import mesh_case

HERE = Path(__file__).parent
CONFIGS = HERE.parent / "configs"
CASES = [
    CONFIGS / "quickstart.yaml",
    *sorted((CONFIGS / "paper").glob("example-*.yaml")),
    CONFIGS / "paper" / "dense.yaml",
    *sorted((CONFIGS / "gallery").glob("*.yaml")),
]
HEAD = """# Sample outputs

All files of this folder are made by `python sample_outputs/make.py`, this page included.

| case | nodes | of the ideal number | mean q | least q | edges l/d | picture |
|---|---|---|---|---|---|---|
"""
ROW = (
    "| [{path}](../{path}) | {nodes} | {ratio:.2f} | {mean:.4f} | {least:.3f} | {fit:.3f} ± {spread:.3f} "
    '| <img src="{name}.png" width="320" alt="mesh of {name}"> |\n'
)


def main() -> None:
    """Mesh and draw the cases, and write the page that lists them."""
    page = HEAD
    for path in CASES:
        case = load_case(path)
        result = mesh_case(case)
        name = str(case.name)
        report = write_files(result.mesh, result.fields, result.report, HERE, name, ["msh", "vtu"])
        draw_mesh(result.mesh, HERE / f"{name}.png")
        page += ROW.format(
            path=path.relative_to(HERE.parent),
            name=name,
            nodes=report["nodes"],
            ratio=report["nodes"] / report["ideal_nodes"],
            mean=report["quality"]["mean"],
            least=report["quality"]["min"],
            fit=report["spacing"]["mean"],
            spread=report["spacing"]["std"],
        )
    (HERE / "README.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
