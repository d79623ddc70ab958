"""The terminal display, on a terminal that is a string."""

import dataclasses
import io
import re
from dataclasses import replace
from pathlib import Path

import pytest

from bubblemesh import console
from bubblemesh.batch import Entry, Row
from bubblemesh.batch.row import FIGURES
from bubblemesh.case import load_case
from bubblemesh.console import run as packing
from bubblemesh.console.batch import BatchProgress
from bubblemesh.console.report import _adaptation, show_estimate, show_quality
from bubblemesh.console.run import PackingProgress
from bubblemesh.problem.prepare import prepare
from bubblemesh.run.estimate import estimate
from bubblemesh.run.report import RoundRow

ROW = RoundRow(1, 250, 826, 709, 120, 3, 1.5e-4, 0.9512, 0.61, 400_000, 0.25)


def terminal(monkeypatch, *, live, width=120, height=25):
    stream = io.StringIO()
    size = {"width": width, "height": height}
    fake = console.Terminal(file=stream, force_terminal=live, **size, _environ={})
    monkeypatch.setattr(console, "terminal", fake)
    return stream


@pytest.mark.parametrize("live", [True, False])
def test_a_round_is_shown_with_all_its_figures(live, monkeypatch):
    stream = terminal(monkeypatch, live=live)
    with PackingProgress("packing plate", quiet=False) as progress:
        progress.show(ROW)
        progress.show(ROW)
    shown = stream.getvalue()
    for text in ("mean speed", "709", "120", "0.9512", "0.610", "1.50e-04", "0.25 s"):
        assert text in shown
    assert ("\x1b[" in shown) == live


@pytest.mark.parametrize("by_direction", [True, False])
def test_what_directions_gain_is_not_in_the_error_that_is_expected(by_direction):
    figures = {"unchanged": 0.0, "start": "method", "field": "u", "nodes_before": 9, "error": 1.0}
    figures |= {"relative_error": 0.5, "expected_relative_error": 0.4}
    told = _adaptation({**figures, "anisotropic": True} if by_direction else figures)["adapted"]
    assert told.startswith("to an expected error of 40.00%")
    assert ("by the number of nodes alone" in told) == by_direction


@pytest.mark.parametrize("live", [True, False])
def test_quiet_shows_nothing(live, monkeypatch):
    stream = terminal(monkeypatch, live=live)
    with PackingProgress("packing plate", quiet=True) as progress:
        progress.show(ROW)
    assert stream.getvalue() == ""


def times(monkeypatch, *seconds):
    clock = iter(seconds)
    monkeypatch.setattr(packing, "monotonic", lambda: next(clock))


def test_progress_tells_the_share_and_the_time_left(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    times(monkeypatch, 100, 101, 131, 132, 191)
    with PackingProgress("packing plate", quiet=False) as progress:
        for share in (0, 0.25, 0.26, 0.9):
            progress.advance(share)
    assert stream.getvalue() == "packing plate: 25%, about 1 min 30 s left\npacking plate: 90%, about 10 s left\n"


def test_the_time_left_is_told_once_it_is_known_and_counts_from_the_first_share(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    times(monkeypatch, 0, 1000, 1011, 1022, 1033, 2000, 2011)
    with PackingProgress("packing plate", quiet=False) as progress:
        for share in (0, 0.005, 0.015, 0.33):
            progress.advance(share)
        for share in (0, 0.5):  # another attempt
            progress.advance(share)
    shares = [line.removeprefix("packing plate: ") for line in stream.getvalue().splitlines()]
    assert shares == ["0%", "0%", "2%", "33%, about 1 min 7 s left", "0%", "50%, about 11 s left"]


def drawn(stream, progress):
    """What a terminal shows of the live picture, without the line's spinner."""
    stream.truncate(0)
    stream.seek(0)
    console.terminal.print(progress.picture())
    return [re.sub(r"\x1b\[[0-9;]*m", "", line).rstrip() for line in stream.getvalue().splitlines()]


@pytest.mark.parametrize(
    ("width", "left_out"),
    [(80, []), (60, ["mean speed"]), (50, ["mean speed", "inserted"]), (40, ["mean speed", "inserted", "deleted"])],
)
def test_the_table_fits_narrow_terminals_and_the_estimate_is_below_it(width, left_out, monkeypatch):
    stream = terminal(monkeypatch, live=True, width=width)
    times(monkeypatch, 0, 0, 30)
    progress = PackingProgress("packing a-case-that-has-a-long-name", quiet=False)
    progress.show(ROW)
    progress.advance(0)
    progress.advance(0.25)
    head, row, line = drawn(stream, progress)
    names = [name for name in packing.COLUMNS if name not in left_out]
    assert head.split() == " ".join(names).split()
    assert len(row.replace("0.25 s", "0.25_s").split()) == len(names)
    assert head.startswith("round    nodes")
    assert line.endswith(": 25%, about 1 min 30 s left")
    assert max(map(len, (head, row, line))) <= width


def test_the_latest_rounds_stay_on_the_terminal_and_all_are_there_at_the_end(monkeypatch):
    stream = terminal(monkeypatch, live=True, height=10)
    progress = PackingProgress("packing plate", quiet=False)
    for number in range(1, 31):
        progress.show(dataclasses.replace(ROW, round=number))
    assert [line.split()[0] for line in drawn(stream, progress)[1:-1]] == [f"{k}" for k in range(24, 31)]
    with progress:
        pass
    assert [line.split()[0] for line in drawn(stream, progress)[1:]] == [f"{k}" for k in range(1, 31)]


def test_brackets_in_messages_are_text_not_markup(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    console.warn(["labels [red]a[/red]"])
    console.fail("domain.outer.polygon[0]: [bold]")
    assert stream.getvalue() == "warning: labels [red]a[/red]\nerror: domain.outer.polygon[0]: [bold]\n"


def test_a_mesh_without_inner_nodes_or_spacing_is_shown(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    worst = [{"quality": 0.8, "at": (0.5, 0.25)}]
    quality = {"mean": 0.9, "p01": 0.8, "min": 0.8, "angle_min": 40.0, "angle_max": 80.0, "worst": worst}
    show_quality(
        {
            "nodes": 4,
            "triangles": 2,
            "area": 1.0,
            "bounds": (0, 0, 1, 1),
            "quality": quality | {"irregular_fraction": None},
        },
        console.terminal,
    )
    assert "0.800 at (0.5, 0.25)" in stream.getvalue()
    assert "irregular" not in stream.getvalue()
    assert "l/d" not in stream.getvalue()


@pytest.mark.parametrize(("count", "rows"), [(1, 0), (2, 2), (9, 9), (10, 8)])
def test_many_regions_are_cut_and_one_alone_is_left_out(count, rows, monkeypatch):
    stream = terminal(monkeypatch, live=False)
    quality = dict.fromkeys(("mean", "p01", "min", "angle_min", "angle_max"), 1.0) | {"worst": []}
    figures = {"nodes": 4, "triangles": 2, "area": 1.0, "bounds": (0, 0, 1, 1)}
    figures["quality"] = quality | {"irregular_fraction": None}
    figures["regions"] = [{"name": f"grain-{k}", "triangles": 1000, "area": 1 / 3} for k in range(count)]
    figures["labels"] = [{"name": "wall", "edges": 1200, "length": 2 / 3}]
    show_quality(figures, console.terminal)
    lines = [re.split("  +", line.strip()) for line in stream.getvalue().splitlines()[5:]]
    assert lines[-2:] == [["label", "edges", "length"], ["wall", "1,200", "0.666667"]]
    shown = [["region", "triangles", "area"], *([f"grain-{k}", "1,000", "0.333333"] for k in range(rows))]
    rest = [["and 2 more", "2,000", "0.666667"]] if count > rows > 0 else []
    assert lines[:-2] == ([*shown, *rest] if rows else [])


FINE = dict.fromkeys(FIGURES, 1.0) | {"nodes": 142, "quality_mean": 0.9612, "quality_min": 0.74, "seconds": 0.25}
PLAIN = Row("plain", "plain.yaml", 0, figures=FINE, warnings=("a [wall] is narrow",))
WRONG = Row("bad", "bad.yaml", 3, error="bad.yaml: domain: no [bold]area")
OLD = Row("old", "old.yaml", 0, figures=FINE, warnings=("told before",))


def begin(progress, *names):
    progress.begin([Entry(k, Row(name, f"{name}.yaml", 0)) for k, name in enumerate(names, 1)], Path("s"))


def test_a_requirement_that_stays_missed_is_counted_as_such(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    with BatchProgress(quiet=False) as progress:
        begin(progress, "old", "strict")
        progress.finish(1, OLD, unchanged=True)
        progress.finish(2, Row("strict", "c.yaml", 4, error="c.yaml: quality_min is 0.1", figures=FINE), unchanged=True)
    assert "2 cases: 1 missed a requirement, 1 unchanged; summary in s" in stream.getvalue()


@pytest.mark.parametrize("quiet", [True, False])
def test_a_batch_is_told_in_plain_lines(quiet, monkeypatch):
    stream = terminal(monkeypatch, live=False)
    with BatchProgress(quiet=quiet) as progress:
        begin(progress, "plain", "bad", "slow", "old")
        progress.note(1, 2, 100)
        progress.finish(1, PLAIN)
        progress.finish(2, WRONG)
        progress.finish(4, OLD, unchanged=True)
        progress.note(1, 3, 100)
    told = [
        "[1/4] plain: 142 nodes, q 0.9612, least 0.740, 250 ms",
        "warning: plain: a [wall] is narrow",
        "error: [2/4] bad.yaml: domain: no [bold]area",
        "[3/4] old: 142 nodes, q 0.9612, least 0.740, unchanged",
        "4 cases: 1 done, 1 failed, 1 unchanged, 1 left for --resume; summary in s",
    ]
    grave = [line for line in told if line.startswith(("warning", "error"))]
    assert stream.getvalue().splitlines() == (grave if quiet else told)


def test_errors_are_counted_and_name_their_case_once(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    rows = (
        Row("alone", "a.yaml", 2, error="a.yaml:1: domain: is missing"),
        Row("b-h=1", "b.yaml", 3, sweep={"h": 1}, error="b.yaml: domain: no area"),
        Row("strict", "c.yaml", 4, error="c.yaml: quality_min is 0.1", figures=FINE),
    )
    with BatchProgress(quiet=False) as progress:
        begin(progress, "alone", "b-h=1", "strict")
        for number, row in enumerate(rows, 1):
            progress.finish(number, row)
    assert stream.getvalue().splitlines() == [
        "error: [1/3] a.yaml:1: domain: is missing",
        "error: [2/3] b-h=1: b.yaml: domain: no area",
        "error: [3/3] c.yaml: quality_min is 0.1",
        "3 cases: 1 missed a requirement, 2 failed; summary in s",
    ]


def test_a_batch_on_a_terminal_is_a_bar_and_a_line_for_each_running_case(monkeypatch):
    stream = terminal(monkeypatch, live=True)
    progress = BatchProgress(quiet=False)
    with progress:
        begin(progress, "plain", "bad", "slow", "old")
        for note in ((3, 0, 0), (1, 2, 100), (3, 4, 77)):
            progress.note(*note)
        progress.finish(2, WRONG)
        progress.finish(4, OLD, unchanged=True)
        console.terminal.print(progress.picture())
        shown = stream.getvalue().splitlines()
        progress.finish(1, PLAIN)
        progress.note(1, 3, 100)  # too late
        assert [cells for cells in progress.running] == [3]
    (slow,) = [line.split() for line in shown if line.startswith("slow")][-1:]
    assert slow[1:3] == ["4", "77"]
    (plain,) = [line.split() for line in shown if line.startswith("plain")][-1:]
    assert plain[1:3] == ["2", "100"]
    assert "2/4" in shown[-1]
    assert "cases" in shown[-1]
    assert "4 cases: 1 done, 1 failed, 1 unchanged, 1 left" in stream.getvalue()


def test_no_more_lines_than_the_terminal_has_are_shown(monkeypatch):
    stream = terminal(monkeypatch, live=True)
    monkeypatch.setattr(console.Terminal, "height", 10)
    progress = BatchProgress(quiet=False)
    begin(progress, *(f"case-{k}" for k in range(40)))
    for k in range(40):
        progress.note(k + 1, 1, 5)
    console.terminal.print(progress.picture())
    assert sum(line.startswith("case-") for line in stream.getvalue().splitlines()) == 6


def test_places_are_told_without_their_rounding(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    problem = prepare(load_case("a.yaml", text="domain: {outer: {rectangle: [-1, -1, 1, 1]}}\nspacing: 0.2\n"))
    extremes = problem.survey.extremes._replace(minimum_at=(8.3e-17, -1e-16), maximum_at=(-1.0, 1e-5))
    survey = replace(problem.survey, extremes=extremes)
    show_estimate(estimate(replace(problem, survey=survey)), console.terminal)
    assert "spacing    0.2 at (0, 0) to 0.2 at (-1, 0.00001)" in stream.getvalue()


def test_motions_of_periodic_sides_are_told(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    text = (
        "domain: {outer: {rectangle: [0, 0, 1, 1], labels: [b, r, t, l]}, periodic: [[l, r], [t, b]]}\nspacing: 0.2\n"
    )
    show_estimate(estimate(prepare(load_case("a.yaml", text=text))), console.terminal)
    assert "sides      l to r: moved by (1, 0); t to b: moved by (0, -1)\n" in stream.getvalue()


NASTY = "plate\x1b]0;title\x07\x1b[31m\x9b2J\r\u202e\udcff"


def test_no_text_steers_the_terminal(monkeypatch):
    stream = terminal(monkeypatch, live=False)
    console.fail(f"{NASTY}: is no case\nsecond problem")
    console.warn([NASTY])
    console.tell(NASTY)
    table = console.new_table()
    table.add_column(NASTY)
    table.add_row(NASTY)
    console.terminal.print(table)
    with BatchProgress(quiet=False) as progress:
        row = Row(NASTY, f"{NASTY}\nerror: all files are gone", 0)
        progress.begin([Entry(1, row)], Path(NASTY))
        progress.finish(1, row.failed(5, f"{row.source}: no such file"))
    shown = stream.getvalue()
    assert shown.replace("\n", "").isprintable()
    assert r"plate\x1b]0;title\x1b[31m\x9b2J\u202e\udcff" in shown  # Rich leaves out what rings and returns
    assert "\n  second problem" in shown
    assert "\nerror: all" not in shown


@pytest.mark.parametrize("live", [True, False])
@pytest.mark.parametrize("name", ["[/wall]", "steel [left]", "[red]wall", ":warning:", "a\\[b]"])
def test_texts_are_shown_as_they_are(name, live, monkeypatch):
    stream = terminal(monkeypatch, live=live)
    table = console.new_table(title=name)
    table.add_column(name)
    table.add_row(name)
    console.terminal.print(table)
    console.terminal.print(name)
    progress = BatchProgress(quiet=False)
    begin(progress, name)
    progress.note(1, 2, 100)
    console.terminal.print(progress.picture())
    shown = re.sub(r"\x1b\[[0-9;]*m", "", stream.getvalue())
    assert shown.count(name) == 5


def test_a_live_picture_has_the_styles_of_the_console_only(monkeypatch):
    stream = terminal(monkeypatch, live=True)
    with PackingProgress(f"packing {NASTY}", quiet=False) as progress:
        progress.show(ROW)
    shown = stream.getvalue()
    assert "\x1b[" in shown
    assert not any(part in shown for part in ("\x07", "\x9b", "\x1b]0", "\u202e"))
