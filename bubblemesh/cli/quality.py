"""The command `quality`: to measure a mesh file, or two side by side."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bubblemesh.cli.options import AsJson, MeshPath, MetricField
from bubblemesh.cli.stdio import write_json
from bubblemesh.errors import CaseError, located, prefixed

if TYPE_CHECKING:
    from bubblemesh.meshes.quality import SpacingBetween


def quality(
    mesh: MeshPath,
    other: Annotated[
        Path | None,
        typer.Argument(metavar="[OTHER]", help="Another mesh, to compare the first with.", readable=False),
    ] = None,
    spacing: Annotated[
        str | None, typer.Option("--spacing", metavar="EXPR", help="Wanted spacing in x and y, to compare edges with.")
    ] = None,
    metric: Annotated[
        bool, typer.Option("--metric", help="Quality and edges in the metric that the file holds, as runs write it.")
    ] = False,
    field: MetricField = None,
    as_json: AsJson = False,
) -> None:
    """Report the quality of a triangle mesh, or compare two."""
    from bubblemesh import console
    from bubblemesh.meshes.quality import mesh_figures
    from bubblemesh.meshfiles.inspection import inspected_triangles

    spacing_between = None if spacing is None else given_spacing(spacing)
    if metric:
        if other is not None or spacing is not None:
            raise CaseError("--metric: it goes with one mesh, and without --spacing")
        show_in_metric(mesh, field, as_json)
        return
    if field is not None:
        raise CaseError("--field: it names a metric: use it with --metric")
    if other is not None:
        show_both(mesh, other, spacing_between, as_json)
        return
    measures, notes = inspected_triangles(mesh)
    console.warn(notes)
    figures = mesh_figures(measures, spacing_between)
    figures["quality"]["obtuse_fraction"] = measures.obtuse_fraction
    show(figures, notes, as_json)


def given_spacing(text: str) -> "SpacingBetween":
    """Spacing by an expression in x and y; its errors, now and when it is evaluated, name the option."""
    from bubblemesh.spacing.expression import Expression
    from bubblemesh.spacing.spacing import Spacing

    of_option = located("--spacing")
    parsed = of_option(Expression.parse)(text, {})
    return of_option(Spacing(parsed).between)


def show_in_metric(mesh: Path, field: str | None, as_json: bool) -> None:
    """Print the quality of a mesh, without its boundary layers, in a metric that its file holds."""
    from bubblemesh import console
    from bubblemesh.meshes.metric import figures_in_metric
    from bubblemesh.meshfiles.inspection import inspected_mesh, measures_in_metric, named_notes

    read, notes = inspected_mesh(mesh)
    with prefixed(f"--metric: {mesh}"):
        measures, on_layers = measures_in_metric(read, field)
    notes += named_notes(mesh, on_layers)
    console.warn(notes)
    show(figures_in_metric(measures), notes, as_json)


def show(figures: Mapping[str, Any], notes: Sequence[str], as_json: bool) -> None:
    """Print the figures of a mesh; as JSON with the notes on it."""
    from bubblemesh import console
    from bubblemesh.console.report import show_quality

    if as_json:
        write_json({**figures, "warnings": notes})
    else:
        show_quality(figures, console.output)


def show_both(first: Path, second: Path, spacing_between: "SpacingBetween | None", as_json: bool) -> None:
    """Print two meshes side by side."""
    from bubblemesh import console
    from bubblemesh.console.report import show_comparison
    from bubblemesh.meshes import comparison
    from bubblemesh.meshfiles.inspection import inspected_mesh

    inspected = [inspected_mesh(path) for path in (first, second)]
    for _, notes in inspected:
        console.warn(notes)
    a, b = (
        comparison.compared(path, read.mesh, read.cell_data, spacing_between)
        for path, (read, _) in zip((first, second), inspected, strict=True)
    )
    if as_json:
        write_json(comparison.report(a, b))
    else:
        rows = comparison.rows(a.figures, b.figures)
        show_comparison((str(first), str(second)), rows, comparison.histograms(a, b))
