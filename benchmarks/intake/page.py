"""The page of what the collection's files have come to: ``docs/intake.md``."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from statistics import median

from benchmarks.intake.collection import KINDS
from benchmarks.intake.trial import AT_ONCE, WITH_KEY
from benchmarks.robustness.trials import Row, read_rows

PAGE = Path(__file__).parents[2] / "docs" / "intake.md"
MESHED = (AT_ONCE, WITH_KEY)
MOST_WORDS = 110  # characters of a message in the list of what stops files
PER = 10_000  # nodes, for times
FEWEST = 500  # nodes of a mesh whose time counts

HEAD = """# Intake: which files get in

Made by `python -m benchmarks.intake --files FOLDER --rows FILE`, then once more with `--page`. The collection is drawn
by scripts in `benchmarks/intake`, modelled on how such files look and what they hold, with the slips that they have;
nothing in it was changed to suit the readers. Each file is meshed as `domain: {file: ...}` with a spacing of a
thirtieth of its size. *At once*: that alone makes a mesh. *With the key*: it is refused with a message that names a key
to add, such as `part: largest` or `join: 0.01`, and with this key, taken from the text of the message, it is meshed.
Every mesh is checked by code of its own (triangles counter-clockwise, no node unused or double, boundary edges are the
free edges and do not cross), and its area is compared with that of what was drawn, where one part or all of them were
asked for. Times are seconds of the processor from the case to the mesh, on a computer that was busy with other runs,
for meshes of at least 500 nodes.

"""


def page(rows_path: Path) -> str:
    """The page as text."""
    rows = read_rows(rows_path)
    hold = [row for row in rows if row["holds_area"]]
    meshed = [row for row in hold if row["outcome"] in MESHED]
    wrong = [row for row in rows if row["wrong"]]
    crashes = sum(row["outcome"] in ("crash", "no end") for row in rows)
    share = (
        f"Of {len(rows)} files of {len({row['kind'] for row in rows})} kinds {len(hold)} hold an area; of those "
        f"{len(meshed)} mesh, which is {len(meshed) / max(len(hold), 1):.1%}. "
        f"{crashes} ended in a crash or not at all, and {len(wrong)} meshes have something wrong.\n\n"
    )
    return HEAD + share + "\n".join([*_table(rows), "", *_stopped(rows), *_wrong(wrong)]) + "\n"


def _table(rows: Iterable[Row]) -> Iterator[str]:
    yield "| kind | what | files | at once | with the key | refused | s per 10,000 nodes, median | least q |"
    yield "|---|---|---|---|---|---|---|---|"
    for name, kind in KINDS.items():
        own = [row for row in rows if row["kind"] == name]
        count = Counter(row["outcome"] for row in own)
        done = [row for row in own if row.get("nodes")]
        times = [PER * row["cpu"] / row["nodes"] for row in done if row["nodes"] >= FEWEST]
        cells = [
            name,
            kind.about,
            len(own),
            count[AT_ONCE],
            count[WITH_KEY],
            len(own) - count[AT_ONCE] - count[WITH_KEY],
        ]
        cells += [f"{median(times):.1f}" if times else "", f"{min(row['least'] for row in done):.2f}" if done else ""]
        yield f"| {' | '.join(map(str, cells))} |"


def reason(row: Row) -> str:
    """What stops a file, without names, places and numbers: files stopped by one thing have the same."""
    text = (row.get("why then") or row["why"]).splitlines()[-1]
    text = text.partition(f"{row['name']}: ")[2] or text
    text = re.sub(r"\([^()]*\)", "(...)", text)
    text = re.sub(r"-?\d[\d.,e+-]*\d|\d", "N", text)
    return text if len(text) <= MOST_WORDS else text[: MOST_WORDS - 3] + "..."


def _stopped(rows: Iterable[Row]) -> Iterator[str]:
    stopped = [row for row in rows if row["outcome"] not in MESHED]
    if not stopped:
        return
    yield "## What stops the rest\n"
    yield "| files | holds an area | message, N for numbers | such as |"
    yield "|---|---|---|---|"
    kinds = Counter((reason(row), row["holds_area"]) for row in stopped)
    for (text, holds), count in sorted(kinds.items(), key=lambda item: (-item[1], item[0])):
        first = next(row["name"] for row in stopped if (reason(row), row["holds_area"]) == (text, holds))
        yield f"| {count} | {'yes' if holds else 'no'} | {text.replace('|', '/')} | {first} |"


def _wrong(rows: Iterable[Row]) -> Iterator[str]:
    lines = [f"- {row['name']}: {'; '.join(row['wrong'])}" for row in rows]
    if lines:
        yield "\n## What is wrong with meshes\n"
        yield from lines
