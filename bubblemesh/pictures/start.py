"""A quicker start of matplotlib, for a command that draws one picture and ends."""


def load_without_help() -> None:
    """Load matplotlib without the lists of properties for its help, which take a tenth of the time.

    Modules that are loaded before or after stay as they are.
    """
    from matplotlib import artist

    name = "_update_set_signature_and_docstring"  # of each class of artists, in most versions of matplotlib
    listing, signing = artist.kwdoc, vars(artist.Artist).get(name)
    artist.kwdoc = lambda artist: ""
    if signing is not None:
        setattr(artist.Artist, name, classmethod(lambda cls: None))
    try:
        import matplotlib.figure  # noqa: F401  it makes all classes of artists
    finally:
        artist.kwdoc = listing
        if signing is not None:
            setattr(artist.Artist, name, signing)
