"""The command `check`, and the previews that it shares with dry runs."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from bubblemesh.cli.options import AsJson, CaseFile, Overrides, Picture, Quiet, Untrusted, case_at, with_overrides
from bubblemesh.cli.stdio import read_input, write_json
from bubblemesh.errors import CaseError

if TYPE_CHECKING:
    from bubblemesh.batch import Entry
    from bubblemesh.case import Case


@with_overrides
def check(
    case: CaseFile,
    overrides: Overrides = (),
    untrusted: Untrusted = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
    picture: Picture = None,
) -> None:
    """Check a case, or all cases of its sweep: geometry, spacing, and how many nodes it needs."""
    from bubblemesh.case import SweepError, case_variants

    text = read_input() if case == "-" else None
    try:
        loaded = case_at(case, overrides, untrusted, text)
    except SweepError:
        if picture is not None:
            raise CaseError("--plot: draws one case, and this file has a sweep: add --set sweep=null") from None
        from bubblemesh import batch as many

        variants = case_variants(case, overrides=overrides, text=text, untrusted=untrusted)
        entries = many.planned(case, variants, many.BatchOptions(overrides, untrusted=untrusted), text=text)
        show_previews(entries, as_json, quiet)
    else:
        show_preview(loaded, case, picture, as_json, quiet)


def show_preview(case: "Case", source: str, picture: Path | None, as_json: bool, quiet: bool) -> None:
    """Print what meshing the case would take, and draw its spacing if a picture is named."""
    from bubblemesh import console
    from bubblemesh.console import report
    from bubblemesh.run.preview import preview

    figures = preview(case, source, picture, complete=as_json)
    if as_json:
        write_json(figures | ({} if picture is None else {"plot": picture}))
    if not quiet:
        report.show_estimate(figures, console.terminal if as_json else console.output)
        if picture is not None:
            report.show_files(str(picture.parent), [picture.name])
    console.warn(figures["warnings"])


def show_previews(entries: "Sequence[Entry]", as_json: bool, quiet: bool) -> None:
    """Print what meshing each of many cases would take; nothing is written. The exit code is the largest of theirs."""
    from bubblemesh import batch as many
    from bubblemesh import console
    from bubblemesh.console.batch import PreviewLines

    lines = PreviewLines(len(entries), quiet, console.terminal if as_json else console.output)
    previews = []
    for entry in entries:
        previews.append(many.preview_of(entry))
        lines.show(previews[-1])
    totals = many.totals_of(previews)
    lines.end(totals)
    if as_json:
        write_json(totals)
    raise typer.Exit(totals["exit_code"])
