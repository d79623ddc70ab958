"""Geometry from files of other programs; modules are loaded when they are first used."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bubblemesh.readers.formats import files_of, is_of_maps, read_areas, read_content, read_regions, read_shapes
    from bubblemesh.readers.lines_and_points import read_inner_lines, read_lines, read_points
    from bubblemesh.readers.regions import is_straight, united

__all__ = [
    "files_of",
    "is_of_maps",
    "is_straight",
    "read_areas",
    "read_content",
    "read_inner_lines",
    "read_lines",
    "read_points",
    "read_regions",
    "read_shapes",
    "united",
]

HOMES = {
    **dict.fromkeys(("read_inner_lines", "read_lines", "read_points"), "lines_and_points"),
    **dict.fromkeys(("files_of", "is_of_maps", "read_areas", "read_content", "read_regions", "read_shapes"), "formats"),
    **dict.fromkeys(("is_straight", "united"), "regions"),
}


def __getattr__(name: str) -> Any:
    """Load the module that has the name, so that cases without files do not wait for it."""
    if name in HOMES:
        return getattr(import_module(f"{__name__}.{HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
