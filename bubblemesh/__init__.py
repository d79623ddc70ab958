"""Triangle meshes by bubble packing."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bubblemesh.api import Case, Domain, Mesh, MeshWarning, Result, Solution, adapt, load_case, mesh, mesh_case

__all__ = [
    "Case",
    "Domain",
    "Mesh",
    "MeshWarning",
    "Result",
    "Solution",
    "__version__",
    "adapt",
    "load_case",
    "mesh",
    "mesh_case",
]

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """Load the programming interface, or the errors, when they are first used: the command line starts faster so."""
    if name == "errors":
        return import_module("bubblemesh.errors")
    if name in __all__:
        return getattr(import_module("bubblemesh.api"), name)
    raise AttributeError(f"module 'bubblemesh' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "errors"})
