"""Mesh the collection: ``python -m benchmarks.intake --files FOLDER --rows FILE``.

Files are drawn into the folder unless it has them. Each is meshed in a process with a cap on time and memory, first as
``domain: {file: ...}`` with a spacing of a thirtieth of its size, then, if it is refused, once with the key that the
message names. A run that is begun again goes on after the last row; ``--page`` writes docs/intake.md from the rows.
"""

import argparse
from pathlib import Path

from benchmarks.intake.collection import draw_all
from benchmarks.intake.page import PAGE, page
from benchmarks.intake.trial import mesh_one, row_of
from benchmarks.robustness.trials import completed, counted_outcomes


def main() -> None:
    """Mesh what is not meshed yet, tell the outcomes, and what stops the rest."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.intake", description=__doc__)
    parser.add_argument("--files", type=Path, required=True, help="folder of the files")
    parser.add_argument("--rows", type=Path, required=True, help="file of the rows")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=120, help="time for each file")
    parser.add_argument("--megabytes", type=int, default=4000, help="memory for each process")
    parser.add_argument("--most", type=int, help="how many of all files to mesh")
    parser.add_argument("--kind", default="", help="what the kinds begin with")
    parser.add_argument("--read", action="store_true", help="read and check the files only")
    parser.add_argument("--meshes", type=Path, help="folder to write the meshes to")
    parser.add_argument("--page", action="store_true", help="write the page of the rows that there are, and no more")
    options = parser.parse_args()
    common = {
        "folder": str(options.files.resolve()),
        "read": options.read,
        "meshes": options.meshes and str(options.meshes),
    }
    tasks = [row | common for row in draw_all(options.files) if row["kind"].startswith(options.kind)][: options.most]
    rows = completed(mesh_one, row_of, [] if options.page else tasks, options)
    if options.page:
        PAGE.write_text(page(options.rows))
        return
    print(*counted_outcomes(rows), sep="\n")
    for row in rows:
        if row["wrong"] or row["outcome"] not in ("at once", "with the key"):
            print(f"{row['name']}: {row['outcome']}: {'; '.join(row['wrong']) or row['why'].splitlines()[-1]}")


if __name__ == "__main__":
    main()
