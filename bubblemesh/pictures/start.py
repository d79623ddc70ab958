"""A quicker start of matplotlib, for a command that draws one picture and ends."""


def load_without_help() -> None:
    """Load matplotlib without the lists of properties that it makes for readers of its help, a tenth of the time.

    What is loaded already stays as it is, and so does what is loaded later.
    """
    from matplotlib import artist

    name = "_update_set_signature_and_docstring"  # of each class of artists, where this version of matplotlib has it
    listing, signing = artist.kwdoc, vars(artist.Artist).get(name)
    artist.kwdoc = lambda artist: ""
    if signing is not None:
        setattr(artist.Artist, name, classmethod(lambda cls: None))
    try:
        import matplotlib.figure  # noqa: F401  which makes all classes of artists
    finally:
        artist.kwdoc = listing
        if signing is not None:
            setattr(artist.Artist, name, signing)
