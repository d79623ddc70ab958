"""Which names boundaries, regions and points may have, so that every mesh file can hold them."""

LONGEST_NAME = 127  # characters
MOST_NAME_BYTES = 253  # that Gmsh reads
FORBIDDEN = "quotes, backslashes, line breaks and other control characters"


def is_writable(name: str) -> bool:
    """Whether it fits; XML has no form for control characters, and a quote ends a name in a msh file."""
    fits = 0 < len(name) <= LONGEST_NAME and len(name.encode()) <= MOST_NAME_BYTES
    return fits and name.isprintable() and not {*name} & {*'"\\'}
