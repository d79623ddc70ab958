"""A quicker start of matplotlib, for a command that draws one picture and ends."""


def load_without_help() -> None:
    """Load matplotlib without the lists of properties that it puts into docstrings, a tenth of the time it takes.

    What is loaded already stays as it is, and so does what is loaded later.
    """
    import matplotlib.artist

    listing = matplotlib.artist.kwdoc
    matplotlib.artist.kwdoc = lambda artist: ""
    try:
        import matplotlib.figure  # which makes all classes of artists
    finally:
        matplotlib.artist.kwdoc = listing
