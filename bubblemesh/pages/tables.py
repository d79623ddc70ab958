"""Tables of pages."""

from collections.abc import Sequence

from bubblemesh.pages.markup import Markup, joined, tag


def head(name: str, *, text: bool = False) -> Markup:
    """Head of a column of numbers, or of text."""
    return tag("th", name, scope="col", class_="text" if text else None)


def cell(content: Markup | str, *, text: bool = False) -> Markup:
    """Cell with a number, or with text."""
    return tag("td", content, class_="text" if text else None)


def table(caption: str, heads: Sequence[Markup], rows: Sequence[Sequence[Markup]]) -> Markup:
    """A table of cells."""
    body = joined(*(tag("tr", *row) for row in rows))
    return tag("table", tag("caption", caption), tag("thead", tag("tr", *heads)), tag("tbody", body))
