"""The gallery as Markdown, made of the samples' table: pictures to choose from, then each mesh with its whole case.

The site shows that; what is in gallery.md in its place, for readers of the file, is written by
``python docs/make_gallery.py``.
"""

import re
from itertools import takewhile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = Path(__file__).with_name("gallery.md")
BEGIN, END = "<!-- cases: begin -->\n", "<!-- cases: end -->\n"
HEAD = """
The pictures and all figures are in [sample_outputs](../sample_outputs/README.md).

| case | shows | |
|---|---|---|
"""
LINE = (
    '| <a id="gallery-{name}"></a>[{name}](../{case}) | {shows} '
    '| <img src="../sample_outputs/{picture}" width="160" alt="mesh of {name}"> |\n'
)
ROW = re.compile(r"^\| \[(?P<case>[\w/.-]+)\]\([^)]*\) \| (?P<figures>.*?) \| <img src=\"(?P<picture>[\w.-]+)\"", re.M)
CARD = """:::{{grid-item-card}} {name}
:img-top: ../sample_outputs/{picture}
:img-alt: mesh of {name}
:link: gallery-{name}
:link-type: ref
:text-align: center
:::
"""
SECTION = """(gallery-{name})=
### {name}

{nodes} nodes, mean quality {mean}, least quality {least}. The case is `{case}`:

```{{literalinclude}} ../{case}
:language: yaml
```

![mesh of {name}](../sample_outputs/{picture})
"""


def on_site(text: str) -> str:
    """The page's text with the gallery in place of the list of cases."""
    return _with(text, gallery())


def made(text: str) -> str:
    """The page's text with its list of cases made anew."""
    lines = (LINE.format(**sample, shows=_first_sentence(ROOT / sample["case"])) for sample in _samples())
    return _with(text, f"{BEGIN}{HEAD}{''.join(lines)}\n{END}")


def _with(text: str, cases: str) -> str:
    return f"{text.partition(BEGIN)[0]}{cases}{text.partition(END)[2]}"


def gallery() -> str:
    """Cards of all samples, and a section for each."""
    samples = _samples()
    cards = "".join(CARD.format(**sample) for sample in samples)
    grid = f"::::{{grid}} 2 3 3 4\n:gutter: 2\n\n{cards}::::\n"
    sections = (SECTION.format(**sample) for sample in samples)
    return "\n".join(["Choose a picture; below it is the whole case.\n", grid, "## The cases", "", *sections])


def _samples() -> list[dict[str, str]]:
    return [_sample(row) for row in ROW.finditer((ROOT / "sample_outputs/README.md").read_text(encoding="utf-8"))]


def _first_sentence(case: Path) -> str:
    """The first sentence of the remark with which a case begins."""
    lines = takewhile(lambda line: line.startswith("# "), case.read_text(encoding="utf-8").splitlines())
    return re.split(r"\.(?= |$)", " ".join(line.removeprefix("# ") for line in lines))[0]


def _sample(row: re.Match[str]) -> dict[str, str]:
    nodes, _, mean, least, *_ = row["figures"].split(" | ")
    name = Path(row["picture"]).stem
    return {"name": name, "case": row["case"], "picture": row["picture"], "nodes": nodes, "mean": mean, "least": least}


if __name__ == "__main__":
    PAGE.write_text(made(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
