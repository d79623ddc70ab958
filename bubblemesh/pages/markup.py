"""HTML that is escaped by construction: text becomes part of a page only through these functions."""

from html import escape
from importlib.resources import files
from string import Template

EMPTY = {"img", "input"}  # elements that have no end


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def tag(name: str, *content: Markup | str | int | None, **attributes: str | float | bool | None) -> Markup:
    """An element.

    Parameters
    ----------
    name : str
    *content : Markup, str, int or None
        Text is escaped, None left out.
    **attributes
        ``class_`` stands for class, ``data_x`` for data-x. True gives the name alone, False and None nothing.
    """
    text = "".join(
        f" {key.rstrip('_').replace('_', '-')}" + ("" if value is True else f'="{escape(str(value))}"')
        for key, value in attributes.items()
        if value is not None and value is not False
    )
    if name in EMPTY:
        return Markup(f"<{name}{text}>")
    return Markup(f"<{name}{text}>{joined(*content)}</{name}>")


def joined(*content: Markup | str | int | None) -> Markup:
    """Pieces one after the other; text is escaped."""
    return Markup(
        "".join(piece if isinstance(piece, Markup) else escape(str(piece)) for piece in content if piece is not None)
    )


def filled(template: str, **parts: Markup | str) -> Markup:
    """A template of the package with its ``$names`` replaced; text is escaped."""
    return Markup(Template(package_text(template)).substitute({name: joined(part) for name, part in parts.items()}))


def package_text(name: str) -> str:
    """Text of a file beside this module."""
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
