"""The command `adapt`: to mesh a case anew as its solution asks for."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from bubblemesh.cli.options import (
    AsJson,
    CaseFile,
    FormatsNamed,
    Output,
    Overrides,
    Quiet,
    SolversNamed,
    Untrusted,
    case_at,
    with_overrides,
)
from bubblemesh.cli.stdio import mesh_stream
from bubblemesh.cli.writing import mesh_and_show


@with_overrides
def adapt(
    case: CaseFile,
    solution: Annotated[
        Path,
        typer.Option(
            "--solution", metavar="FILE", help="Mesh of the case with the solution at its nodes.", readable=False
        ),
    ],
    field: Annotated[
        str | None, typer.Option("--field", metavar="NAME", help="Name of the solution, if the file has more data.")
    ] = None,
    error: Annotated[
        float | None, typer.Option("--error", metavar="E", help="Wanted error of the gradient, relative: 0.05 is 5 %.")
    ] = None,
    nodes: Annotated[
        int | None, typer.Option("--nodes", metavar="N", help="Wanted number of nodes; by default as many as now.")
    ] = None,
    anisotropic: Annotated[
        bool,
        typer.Option("--anisotropic", help="Sizes that depend on the direction, by the solution's second derivatives."),
    ] = False,
    exact: Annotated[
        str | None, typer.Option("--exact", metavar="EXPR", help="Exact solution in x and y, to check the estimate.")
    ] = None,
    output: Output = None,
    formats: FormatsNamed = None,
    solvers: SolversNamed = None,
    overrides: Overrides = (),
    untrusted: Untrusted = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Mesh a case anew as its solution asks for: finer where the estimated error is large, coarser where small."""
    from bubblemesh import console
    from bubblemesh.adaptivity import adapt as adapting
    from bubblemesh.adaptivity.solution import read_solution
    from bubblemesh.adaptivity.target import Target
    from bubblemesh.run.limits import within_limits
    from bubblemesh.run.output import OutputOptions, place_of

    loaded = case_at(case, overrides, untrusted)
    target = Target(error, nodes, anisotropic, mark="--")
    options = OutputOptions(output, formats or (), solvers or (), stream=mesh_stream(output, as_json))
    place = place_of(loaded, case, options, solution)

    def adapted() -> None:
        present, notes = read_solution(solution, field, target.called("field"))
        console.warn(notes)
        meshing = partial(adapting.adapted, options.over(loaded), present, target, exact)
        mesh_and_show(meshing, loaded, case, place, as_json, quiet)

    within_limits(loaded, adapted, f"{case}: ")
