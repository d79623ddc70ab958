"""Which names boundaries, regions and points may have, so that every mesh file can hold them."""

LONGEST = 127  # characters
LARGEST = 253  # bytes that Gmsh reads of a name
FORBIDDEN = "quotes, backslashes, line breaks and other control characters"


def is_writable(name: str) -> bool:
    """Whether it fits; XML has no form for control characters, and a quote ends a name in a msh file."""
    fits = 0 < len(name) <= LONGEST and len(name.encode()) <= LARGEST
    return fits and name.isprintable() and not {*name} & {*'"\\'}
