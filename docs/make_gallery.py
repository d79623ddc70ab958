"""The gallery as Markdown, made of the samples' table: pictures to choose from, then each mesh with its whole case."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
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


def gallery() -> str:
    """Cards of all samples, and a section for each."""
    samples = [_sample(row) for row in ROW.finditer((ROOT / "sample_outputs/README.md").read_text(encoding="utf-8"))]
    cards = "".join(CARD.format(**sample) for sample in samples)
    grid = f"::::{{grid}} 2 3 3 4\n:gutter: 2\n\n{cards}::::\n"
    return "\n".join([grid, "## The cases", "", *(SECTION.format(**sample) for sample in samples)])


def _sample(row: re.Match[str]) -> dict[str, str]:
    nodes, _, mean, least, *_ = row["figures"].split(" | ")
    name = Path(row["picture"]).stem
    return {"name": name, "case": row["case"], "picture": row["picture"], "nodes": nodes, "mean": mean, "least": least}
