"""Where the results of a run go, and in which formats: as options of a command say, over the keys of the case."""

from collections.abc import Iterable, Sequence
from os.path import isdir, realpath, split
from pathlib import Path
from typing import BinaryIO

from bubblemesh.case import Case, Output, Override
from bubblemesh.errors import CaseError, FileError, prefixed
from bubblemesh.meshfiles.formats import (
    FORMATS,
    FORMATS_FOR,
    MOST_PIECES,
    FormatName,
    format_named,
    formats_by_ending,
    formats_for,
    require_no_sizes,
    require_order,
    stem_of,
    unknown_ending,
    whole_only,
)
from bubblemesh.meshfiles.sources.table import files_beside
from bubblemesh.meshfiles.transaction import require_room
from bubblemesh.messages import unknown
from bubblemesh.problem.files import files_of_case
from bubblemesh.records import record
from bubblemesh.run.destination import Destination, StreamDestination


@record
class OutputOptions:
    """Options of a command that say over the case what is written, and where."""

    output: str | None = None  # a folder, or a file
    named: Sequence[str] = ()  # formats
    solvers: Sequence[str] = ()  # whose formats are meant
    history: bool = False
    page: bool | None = None
    stream: BinaryIO | None = None  # for the mesh alone, in place of files

    @property
    def formats(self) -> tuple[FormatName, ...]:
        """Formats that the options ask for, if any; an unknown format or solver is a CaseError."""
        if self.named and self.solvers:
            raise CaseError("--format and --for exclude each other: drop one of them")
        for solver in self.solvers:
            if solver not in FORMATS_FOR:
                raise CaseError(f"--for: {unknown('solver', solver, FORMATS_FOR)}")
        with prefixed("--format"):
            for name in self.named:
                format_named(name)
        return formats_for(self.solvers) or tuple(dict.fromkeys(self.named))

    def over(self, case: Case) -> Case:
        """The case with the formats that the options ask for, if any, as its report shows them; errors as `formats`."""
        if not self.formats:
            return case
        output = case.output.model_copy(update={"formats": self.formats, "solver": None})
        return case.model_copy(update={"output": output})

    def over_cases(self) -> list[Override]:
        """Overrides that set the formats of many cases; none if the options ask for none. Errors as `formats`."""
        if not self.formats:
            return []
        source = "--for" if self.solvers else "--format"
        return [Override(("output", "for"), None, source), Override(("output", "formats"), [*self.formats], source)]

    def require_only(self, chosen: FormatName) -> None:
        """Check that a single file in the chosen format is for each solver and format named; else it is a CaseError."""
        others = [f"--for {solver}" for solver in self.solvers if chosen not in FORMATS_FOR[solver]]
        others += [f"--format {name}" for name in self.named if name != chosen]
        if others:
            problem = f"is one file, in the format {chosen}, and {others[0]} asks for another"
            raise CaseError(f"-o {self.output}: {problem}: name a folder")


def place_of(
    case: Case, source: str, options: OutputOptions, solution: Path | None = None, *, in_slices: bool = False
) -> Destination | StreamDestination:
    """The stream of the options if they have one, else the `destination`, with the errors of both."""
    if options.stream is None:
        return destination(case, source, options, solution, in_slices=in_slices)
    place = stream_destination(case.output, options.stream, options)
    require_fitting_coordinates(case, [place.format_name])
    return place


def destination(
    case: Case, source: str, options: OutputOptions, solution: Path | None = None, *, in_slices: bool = False
) -> Destination:
    """Destination that the options and the case name together, with the rules and errors of `destination_beside`.

    Its inputs are the case file, the solution if there is one, and all files that the case names. ``in_slices`` says
    that what is packed in parts may be written part by part. CaseError if an untrusted case names a folder outside
    of its own, or a format does not go with the coordinates of the case.
    """
    # Relative to the case file; with a case of the standard input, or without a name, the present folder.
    directory = case.output.directory
    folder = Path() if directory is None else Path(source).parent / directory
    if case.root is not None and directory is not None and options.output is None:
        _require_below(folder, case.root)
    inputs: list[str | Path] = [*([] if source == "-" else [source]), *files_of_case(case)]
    if solution is not None:
        inputs += [solution, *files_beside(solution)]
    slices = _most_parts(case) if in_slices else 1
    place = destination_beside(inputs, case.output, folder, str(case.name), options, slices)
    require_fitting_coordinates(case, place.formats)
    return place


def require_fitting_coordinates(case: Case, formats: Iterable[FormatName]) -> None:
    """Check that sizes are written in the plane of the packing only; else it is a CaseError."""
    if case.crs is not None and case.crs.to != "auto":
        require_no_sizes(formats)


def _most_parts(case: Case) -> int:
    """Most parts that a case's mesh may be packed in."""
    if case.parts != "auto":
        return case.parts or 1
    # Imported here since few meshes have parts.
    from bubblemesh.parts.pipeline import enough_parts

    return min(enough_parts(case.limits.max_nodes), MOST_PIECES)


def destination_beside(
    inputs: Iterable[str | Path], keys: Output, folder: Path, name: str, options: OutputOptions, slices: int = 1
) -> Destination:
    """Destination that the options name over the keys of a case, with a folder and a name for what they leave open.

    A path that ends in a slash, is a folder, or has no ending is a folder; any other one is a file, whose format is
    that of its ending. A mesh may be written in so many ``slices`` at the most, if all formats can. CaseError if the
    format or the solver is unknown, or the format is not that of the file's ending, has no form for the order of the
    triangles, or would be too many files; FileError if one of the inputs would be overwritten, or
    something that is not a file has a name to write.
    """
    requested, output = options.formats, options.output
    formats = requested or keys.formats
    if output == "":
        raise CaseError("-o: the name is empty: name a folder, a file, or - for the standard output")
    ending = None
    if output is not None:
        folder = Path(output)
        if _is_file(output):
            formats = (_format_of(folder, requested, keys.formats),)
            options.require_only(formats[0])
            file, folder = folder.name, folder.parent
            name = stem_of(file, formats[0])
            ending = file.removeprefix(name)
    require_order(formats, keys.order)
    page = keys.report if options.page is None else options.page
    parts = keys.partition or (1 if whole_only(formats) else slices)
    place = Destination(folder, name, formats, ending, history=options.history, page=page, parts=parts)
    names = place.names
    for path in inputs:
        own, file = split(realpath(path))  # a link that has the name of a file to write is replaced by it
        if file in names and own == realpath(folder):
            raise FileError(f"{path}: the results would overwrite this file: give another name by -o")
    require_room(folder, names)
    return place


def _require_below(folder: Path, root: Path) -> None:
    """Check that the folder of an untrusted case's results lies below the folder of the case."""
    if not Path(realpath(folder)).is_relative_to(root):
        raise CaseError(
            f"output.directory: {folder} leads out of {root}: an untrusted case writes below it, or where -o says"
        )


def stream_destination(keys: Output, stream: BinaryIO, options: OutputOptions) -> StreamDestination:
    """Destination of the option ``-o -``, with the errors of `destination`; CaseError if there are other files."""
    first = (options.formats or keys.formats)[0]
    options.require_only(first)
    for option, asked_for in (("--history", options.history), ("--report", options.page)):
        if asked_for:
            raise CaseError(f"{option}: there is no place for its files with -o -: drop one of them")
    require_order([first], keys.order)
    if FORMATS[first].piece is not None:
        raise CaseError(f"--format {first}: has a file for each part, and -o - is one file: take another format")
    return StreamDestination(stream, first)


def _is_file(output: str) -> bool:
    path = Path(output)
    is_folder = output.endswith("/") or isdir(path)  # noqa: PTH112 - the method of paths fails for too long a name
    return (path.suffix != "" or path.name.startswith(".")) and not is_folder


def _format_of(path: Path, requested: tuple[FormatName, ...], liked: tuple[FormatName, ...]) -> FormatName:
    """The format of a file by its ending: one of those asked for, else one that the case names, else any."""
    fitting = formats_by_ending(path.name)
    if not fitting:
        raise unknown_ending(f"-o {path}", "; the name of a folder ends with a slash")
    if requested:
        both = [name for name in fitting if name in requested]
        if not both:
            option = f"--format or --for asks for {' or '.join(requested)}"
            raise CaseError(f"-o {path}: its ending asks for {fitting[0]}, {option}: drop one of them")
        return both[0]
    return next((name for name in fitting if name in liked), fitting[0])
