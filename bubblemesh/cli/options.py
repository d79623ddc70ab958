"""Options that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

CaseFile = Annotated[str, typer.Argument(metavar="CASE", help="Case file, or - for the standard input.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change the case, e.g. packing.w2=0.7.")
]
MethodName = Annotated[str | None, typer.Option("--method", help="Packing method, over the case's.")]
Seed = Annotated[int | None, typer.Option("--seed", help="Seed of the random numbers, over the case's.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the report as JSON on the standard output.")]
Output = Annotated[
    str | None,
    typer.Option("--output", "-o", metavar="PATH", help="A folder, a mesh file, or - for the standard output."),
]
FormatNamed = Annotated[
    str | None, typer.Option("--format", help="Write this format only: msh, vtu, xdmf, mesh, inp, su2 ...")
]
SolverNamed = Annotated[
    str | None, typer.Option("--for", metavar="SOLVER", help="Write what a solver reads: fenicsx, calculix ...")
]
Picture = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw the spacing: .png, .svg or .pdf.")]
TimeLimit = Annotated[
    float | None,
    typer.Option("--time-limit", metavar="SECONDS", help="End the packing then, with the mesh as it is."),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show warnings and errors only.")]
