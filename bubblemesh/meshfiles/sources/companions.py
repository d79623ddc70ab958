"""Files to which mesh files refer, by their formats."""

from collections.abc import Callable, Iterable
from pathlib import Path


def files_of_list(path: Path) -> Iterable[Path]:
    """The files of a list over time of ParaView, and the pieces of these."""
    from bubblemesh.meshfiles.sources.vtk_lists import files_of_pvd

    for file in files_of_pvd(path):
        yield file
        if file.suffix.lower() == ".pvtu":
            yield from pieces(file)


def pieces(path: Path) -> Iterable[Path]:
    """The files of the pieces of a mesh in parts of VTK."""
    from bubblemesh.meshfiles.sources.vtk_lists import files_of_pvtu

    return files_of_pvtu(path)


def same_name(*endings: str) -> Callable[[Path], Iterable[Path]]:
    """The function of a path that gives the files of its name with these endings."""
    return lambda path: [path.with_suffix(ending) for ending in endings]


def functions(path: Path) -> Iterable[Path]:
    """The files with functions on a mesh of DOLFIN: NAME_WORD.xml beside NAME.xml."""
    return (other for other in path.parent.iterdir() if other.name.startswith(f"{path.stem}_") and ".xml" in other.name)
