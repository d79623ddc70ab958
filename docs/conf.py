"""The site, from the pages of this folder: ``sphinx-build -W docs build/site``."""

import re
import sys
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
sys.path.insert(0, str(ROOT))  # the generators of pages are no part of the installed package

from bubblemesh import __version__  # noqa: E402
from docs.make_case_keys import case_keys  # noqa: E402
from docs.make_command_options import command_options  # noqa: E402
from docs.make_gallery import on_site  # noqa: E402

project = "bubblemesh"
author = "the bubblemesh authors"
copyright = "2026, the bubblemesh authors"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_design"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build", "**/README.md"]
html_theme = "furo"
html_title = f"bubblemesh {__version__}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
pygments_style = "default"
pygments_dark_style = "monokai"

myst_enable_extensions = ["colon_fence", "html_image"]
myst_heading_anchors = 3
suppress_warnings = ["misc.highlighting_failure"]  # input files of solvers are shown plainly

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings give types and shapes
napoleon_google_docstring = False
napoleon_use_rtype = False

MADE = {  # by page: what it becomes
    "case": lambda text: f"{text}\n{case_keys()}",
    "commands": lambda text: f"{text}\n{command_options()}",
    "gallery": on_site,
}
IN_GALLERY = re.compile(r"\]\((?:\.\./)?gallery\.md(#gallery-[\w-]+)\)")  # Sphinx knows a case by its name alone
LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([\w./-]+)\)")  # to a page or a file, not into a page


def made(_app: Any, page: str, source: list[str]) -> None:
    """Add to a page what is made of the program; links get titles of pages, and none leads out of the site."""
    folder = (DOCS / page).parent
    text = LINK.sub(lambda link: _link(folder, *link.groups()), IN_GALLERY.sub(r"](\1)", source[0]))
    source[0] = MADE[page](text) if page in MADE else text


def _link(folder: Path, text: str, target: str) -> str:
    """A link as the site can offer it: to a page or a picture; else the name of the file in the repository."""
    path = (folder / target).resolve()
    if path == ROOT / "README.md":
        return f"[{text}](/index.md)"
    if path.is_relative_to(DOCS) or path.is_relative_to(ROOT / "sample_outputs"):
        return f"[]({target})" if text == target else f"[{text}]({target})"
    name = path.relative_to(ROOT).as_posix()
    return f"`{name}`" if text.strip("`") == name else f"{text} (`{name}`)"


def setup(app: Any) -> None:
    """Register what is done to pages; those that are made of the program are never taken from an older build."""
    app.connect("source-read", made)
    app.connect("env-get-outdated", lambda *_: list(MADE))
