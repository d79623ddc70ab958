"""HTML that is escaped by construction: text becomes part of a page only through these functions."""

from collections.abc import Sequence
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
    return Markup(f"<{name}{text}>{html(*content)}</{name}>")


def html(*content: Markup | str | int | None) -> Markup:
    """HTML of pieces one after the other; text is escaped."""
    return Markup(
        "".join(piece if isinstance(piece, Markup) else escape(str(piece)) for piece in content if piece is not None)
    )


def from_template(name: str, /, **parts: Markup | str) -> Markup:
    """A template of the package with its ``$names`` replaced; text is escaped."""
    return Markup(Template(package_text(name)).substitute({key: html(part) for key, part in parts.items()}))


def head(name: str, *, text: bool = False) -> Markup:
    """Head of a column of numbers, or of text."""
    return tag("th", name, scope="col", class_="text" if text else None)


def cell(content: Markup | str, *, text: bool = False) -> Markup:
    """Cell with a number, or with text."""
    return tag("td", content, class_="text" if text else None)


def table(caption: str, heads: Sequence[Markup], rows: Sequence[Sequence[Markup]]) -> Markup:
    """A table of cells."""
    body = html(*(tag("tr", *row) for row in rows))
    return tag("table", tag("caption", caption), tag("thead", tag("tr", *heads)), tag("tbody", body))


def package_text(name: str) -> str:
    """Text of one of the package's templates, scripts and styles."""
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
