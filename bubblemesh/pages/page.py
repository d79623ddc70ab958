"""The frame of every page: one file that asks nothing of the network, and runs no script but its own."""

import base64
import hashlib
from collections.abc import Sequence

from bubblemesh.pages.markup import Markup, from_template, package_text
from bubblemesh.pictures.styles import LABEL_COLOURS, REGION_COLOURS


def page(title: str, body: Markup, scripts: Sequence[str], *, wide: bool = False) -> str:
    """A whole page.

    Parameters
    ----------
    title : str
    body : Markup
    scripts : sequence of str
        Names of the package's JavaScript files, which become one module in this order.
    wide : bool
        Whether it may be as wide as a table of many columns.
    """
    style = _palette() + package_text("style.css")
    script = "".join(package_text(name) for name in scripts)
    # Browsers run only what has these hashes, whatever else a page may have come to hold.
    policy = (
        f"default-src 'none'; img-src data:; style-src {_hash(style)}; script-src {_hash(script)}; "
        "base-uri 'none'; form-action 'none'"
    )
    return str(
        from_template(
            "page.html",
            title=title,
            policy=Markup(policy),
            style=Markup(style),
            width="wide" if wide else "",
            body=body,
            script=Markup(script),
        )
    )


def _palette() -> str:
    """The colours that pages and pictures share, for the style sheet."""
    labels = "".join(f"--label-{k}: {color}; " for k, color in enumerate(LABEL_COLOURS))
    regions = "".join(f"svg .region-{k} {{ fill: {color}; }}\n" for k, color in enumerate(REGION_COLOURS))
    lines = "".join(f"svg .label-{k} {{ stroke: var(--label-{k}); }}\n" for k in range(len(LABEL_COLOURS)))
    return f"\n:root {{ {labels}}}\n{regions}{lines}"


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
