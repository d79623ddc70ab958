"""Options that several commands share, and the case that they name."""

from collections.abc import Callable, Sequence
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bubblemesh.cli.completion import formats, methods, solvers
from bubblemesh.cli.stdio import read_input

if TYPE_CHECKING:
    from bubblemesh.case import Case, Override

CaseFile = Annotated[str, typer.Argument(metavar="CASE", help="Case file, or - for the standard input.")]
MeshPath = Annotated[
    Path,
    # As for all paths: a check by Typer whether they can be read would have another message and exit code than ours.
    typer.Argument(metavar="MESH", help="Mesh file of any format that bubblemesh or meshio reads.", readable=False),
]
MetricField = Annotated[
    str | None,
    typer.Option("--field", metavar="NAME", help="Name of the metric at the nodes, if the file has more data."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print the report as JSON on the standard output.")]
Output = Annotated[
    str | None,
    typer.Option("--output", "-o", metavar="PATH", help="A folder, a mesh file, or - for the standard output."),
]
FormatsNamed = Annotated[
    list[str] | None,
    typer.Option(
        "--format",
        help="Write this format only, or each that is named so: msh, vtu, xdmf, mesh, inp, su2 ...",
        autocompletion=formats,
    ),
]
SolversNamed = Annotated[
    list[str] | None,
    typer.Option(
        "--for",
        metavar="SOLVER",
        help="Write what a solver reads, or each that is named so: fenicsx ...",
        autocompletion=solvers,
    ),
]
Picture = Annotated[
    Path | None,
    typer.Option("--plot", metavar="FILE", help="Draw the spacing: .png, .svg or .pdf.", readable=False),
]
Untrusted = Annotated[
    bool,
    typer.Option("--untrusted", help="The case is a stranger's: only files below its folder, and limits by default."),
]
Jobs = Annotated[
    int | None, typer.Option("--jobs", "-j", metavar="N", min=1, help="Worker processes; else one for each core.")
]
Cluster = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="Dask scheduler whose workers do the meshing.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show warnings and errors only.")]


def count_or_word(text: str) -> int | str:
    """The number in a text if it is one, else the text."""
    digits = text.removeprefix("-")
    return int(text) if digits.isascii() and digits.isdigit() else text


# Options that set keys of the case. The key of each is in case/overrides.py, under the same name.
CASE_OPTIONS: dict[str, Any] = {
    "set": Annotated[list[str] | None, typer.Option(metavar="KEY=VALUE", help="Change the case, e.g. packing.w2=0.7.")],
    "method": Annotated[str | None, typer.Option(help="Packing method, over the case's.", autocompletion=methods)],
    "seed": Annotated[int | None, typer.Option(help="Seed of the random numbers, over the case's.")],
    "repair": Annotated[
        bool | None, typer.Option("--repair", help="Mend rings that cross or touch themselves or each other, and gaps.")
    ],
    "angle_min": Annotated[
        float | None, typer.Option(metavar="DEGREES", help="Least angle, up to 30: nodes are added for it.")
    ],
    "parts": Annotated[
        str | None,
        typer.Option(metavar="N", help="Pack in so many parts, or auto.", parser=count_or_word),
    ],
    "time_limit": Annotated[
        float | None, typer.Option(metavar="SECONDS", help="End then, with the mesh as it is once there is one.")
    ],
    "partition": Annotated[
        int | None, typer.Option(metavar="N", help="Divide the mesh into N parts, for a parallel solver.")
    ],
}

Overrides = Sequence["Override"]
Command = Callable[..., None]


def with_overrides(command: Command) -> Command:
    """The command with the `CASE_OPTIONS`, from which its parameter ``overrides`` is made."""
    added = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=kind) for name, kind in CASE_OPTIONS.items()
    ]

    @wraps(command)
    def with_options(**arguments: Any) -> None:
        from bubblemesh.case import overrides_of

        given = {name: arguments.pop(name) for name in CASE_OPTIONS}
        settings = given.pop("set") or ()
        command(**arguments, overrides=overrides_of(settings, of_command=True, **given))

    own = signature(command).parameters
    parameters = [
        each
        for name, parameter in own.items()
        for each in (added if name == "overrides" else [parameter.replace(kind=Parameter.KEYWORD_ONLY)])
    ]
    with_options.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    vars(with_options)["__signature__"] = Signature(parameters)
    return with_options


def case_at(case: str, overrides: Overrides, untrusted: bool, text: str | None = None) -> "Case":
    """Case of a file, or of the standard input for ``-`` unless its text is given, with the options over it."""
    from bubblemesh.case import load_case

    text = read_input() if case == "-" and text is None else text
    return load_case(case, overrides=overrides, untrusted=untrusted, text=text)
