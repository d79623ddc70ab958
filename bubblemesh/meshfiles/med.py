"""Features of MED files that meshio lacks: a kind of cells, families without groups, names in UTF-8."""

from collections.abc import Mapping
from typing import Any


def teach_med() -> None:
    """Extend meshio to write and read quadrilaterals of nine nodes in MED files, and to read all families."""
    from meshio.med import _med

    _med.meshio_to_med_type.setdefault("quad9", "QU9")
    _med.med_to_meshio_type.setdefault("QU9", "quad9")
    _med._read_families = families


def families(stored: Mapping[str, Any]) -> dict[int, list[str]]:
    """Names of the groups of each family in a file, by the number of the family."""
    return {family.attrs["NUM"]: _groups(family) for family in stored.values()}


def _groups(family: Mapping[str, Any]) -> list[str]:
    """Names of the groups of a family: a row of bytes each, which Gmsh leaves out if there is none."""
    rows = family["GRO"]["NOM"][()] if "GRO" in family else ()
    return [_decoded(bytes(row.tobytes()).rstrip(b"\0 ")).strip() for row in rows]


def _decoded(name: bytes) -> str:
    try:
        return name.decode()
    except UnicodeDecodeError:
        return name.decode("latin-1")
