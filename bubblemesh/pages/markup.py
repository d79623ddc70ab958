"""HTML that is escaped by construction: text becomes part of a page only through these functions; a page's frame."""

import base64
import hashlib
import math
import re
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template

from bubblemesh.messages import printable
from bubblemesh.pictures.styles import LABEL_COLOURS, REGION_COLOURS

NUMBER = r"-?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
PLACE = re.compile(rf"\(({NUMBER}), ({NUMBER})\)")
EMPTY = {"img", "input", "wbr"}  # elements that have no end


class Markup(str):
    """Text that is already HTML."""

    __slots__ = ()


def tag(name: str, *content: Markup | str | int | None, **attributes: str | float | bool | None) -> Markup:
    """An element; text in it is escaped, and None is left out.

    In the names of attributes, ``class_`` stands for class and ``data_x`` for data-x. An attribute that is True has no
    value; those that are False or None are left out.
    """
    text = "".join(
        f" {key.rstrip('_').replace('_', '-')}" + ("" if value is True else f'="{_escaped(value)}"')
        for key, value in attributes.items()
        if value is not None and value is not False
    )
    if name in EMPTY:
        return Markup(f"<{name}{text}>")
    return Markup(f"<{name}{text}>{html(*content)}</{name}>")


def html(*content: Markup | str | int | None) -> Markup:
    """HTML of pieces in a row; text is escaped."""
    return Markup(
        "".join(piece if isinstance(piece, Markup) else _escaped(piece) for piece in content if piece is not None)
    )


def _escaped(text: object) -> str:
    return escape(printable(str(text)))


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


def whole(number: int) -> str:
    """A count with its thousands set apart."""
    return f"{number:,}"


def linked_places(message: str) -> Markup:
    """A message in which each place is a button that shows it in the picture of the mesh."""
    parts: list[Markup | str] = []
    end = 0
    for found in PLACE.finditer(message):
        x, y = float(found[1]), float(found[2])
        if math.isfinite(x) and math.isfinite(y):
            at = {"data_x": repr(x), "data_y": repr(y)}
            button = tag("button", found[0], type="button", class_="place", **at, title="Show in the mesh")
            parts += [message[end : found.start()], button]
            end = found.end()
    return html(*parts, message[end:])


def page(title: str, body: Markup, scripts: Sequence[str], *, wide: bool = False) -> str:
    """A whole page: one file that needs no network, and runs no scripts but its own.

    The scripts are names of the package's JavaScript files, which become one module in this order. A ``wide`` page has
    room for tables of many columns.
    """
    style = _palette() + package_text("style.css")
    script = "".join(package_text(name) for name in scripts)
    # Browsers run only scripts with these hashes, whatever else gets into a page.
    policy = (
        f"default-src 'none'; img-src data:; style-src {_hash(style)}; script-src {_hash(script)}; "
        "base-uri 'none'; form-action 'none'"
    )
    safe = {"policy": Markup(policy), "style": Markup(style), "script": Markup(script)}
    return str(from_template("page.html", title=title, width="wide" if wide else "", body=body, **safe))


def _palette() -> str:
    """The colours that pages and pictures share, for the style sheet."""
    labels = "".join(f"--label-{k}: {color}; " for k, color in enumerate(LABEL_COLOURS))
    regions = "".join(f"svg .region-{k} {{ fill: {color}; }}\n" for k, color in enumerate(REGION_COLOURS))
    lines = "".join(f"svg .label-{k} {{ stroke: var(--label-{k}); }}\n" for k in range(len(LABEL_COLOURS)))
    return f"\n:root {{ {labels}}}\n{regions}{lines}"


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def package_text(name: str) -> str:
    """Text of one of the package's templates, scripts and styles."""
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
