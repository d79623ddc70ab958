"""Files that a mesh file leads to: they have to travel with it, and are inputs of a case as it is."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path

from bubblemesh.errors import BubblemeshError
from bubblemesh.meshfiles.contained import files_of_xdmf


def files_beside(path: Path) -> list[Path]:
    """Files that are there and that a mesh file leads to, those of lists in it among them.

    Of one that cannot be read there are none: its reader tells why.
    """
    if path.suffix.lower() not in BESIDE:
        return []
    with suppress(BubblemeshError, OSError, SyntaxError, ValueError):  # broken XML is wrong syntax
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
