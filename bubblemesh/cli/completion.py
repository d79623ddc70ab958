"""Words with which shells complete the values of options, from the tables of methods, formats and solvers."""

from collections.abc import Callable, Iterable

Complete = Callable[[str], list[str]]


def _beginning(words: Callable[[], Iterable[str]]) -> Complete:
    """Function that returns the words which begin with what was typed."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in words() if word.startswith(incomplete)]

    return complete


def _formats() -> Iterable[str]:
    from bubblemesh.meshfiles.formats import FORMATS

    return FORMATS


def _solvers() -> Iterable[str]:
    from bubblemesh.meshfiles.formats import FORMATS_FOR

    return FORMATS_FOR


def _methods() -> Iterable[str]:
    from bubblemesh.packing.methods import METHODS

    return METHODS


def _quantities() -> Iterable[str]:
    from bubblemesh.pictures.styles import QUANTITIES

    return QUANTITIES


def _styles() -> Iterable[str]:
    from bubblemesh.pictures.styles import STYLES

    return STYLES


formats, solvers, methods = map(_beginning, (_formats, _solvers, _methods))
quantities, styles = map(_beginning, (_quantities, _styles))
