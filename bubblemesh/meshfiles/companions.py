"""Files to which a mesh file refers: they have to be copied with it, and are inputs of a case, too."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path

from bubblemesh.errors import BubblemeshError
from bubblemesh.meshfiles.containment import files_of_xdmf


def files_beside(path: Path) -> list[Path]:
    """Existing files to which a mesh file refers, directly or through lists.

    The result is empty for a file that cannot be read: its reader reports the error.
    """
    if path.suffix.lower() not in BESIDE:
        return []
    with suppress(BubblemeshError, OSError, SyntaxError, ValueError):  # SyntaxError: broken XML
        others = dict.fromkeys(BESIDE[path.suffix.lower()](path))
        return [other for other in others if other != path and other.exists()]
    return []


def _in_list(path: Path) -> Iterable[Path]:
    from bubblemesh.meshfiles.sources.vtk_lists import files_of_pvd

    for file in files_of_pvd(path):
        yield file
        if file.suffix.lower() == ".pvtu":
            yield from _pieces(file)


def _pieces(path: Path) -> Iterable[Path]:
    from bubblemesh.meshfiles.sources.vtk_lists import files_of_pvtu

    return files_of_pvtu(path)


def _same_name(*endings: str) -> Callable[[Path], Iterable[Path]]:
    return lambda path: [path.with_suffix(ending) for ending in endings]


BESIDE: Mapping[str, Callable[[Path], Iterable[Path]]] = {
    ".pvd": _in_list,
    ".pvtu": _pieces,
    **dict.fromkeys((".xdmf", ".xmf"), files_of_xdmf),
    **dict.fromkeys((".node", ".ele"), _same_name(".node", ".ele")),
    **dict.fromkeys((".mesh", ".meshb", ".sol"), _same_name(".sol", ".mesh", ".meshb")),
    ".slf": _same_name(".cli"),
    ".xml": lambda path: path.parent.glob(f"{path.stem}_*.xml"),
}
