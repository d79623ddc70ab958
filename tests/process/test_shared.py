"""Threads that change what the whole process has, and leave it as it was."""

import warnings
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, Event

import matplotlib as mpl
from squares import holed_square

from bubblemesh.pictures.plots import STANDARD, small_png
from bubblemesh.process.shared import warnings_are
from bubblemesh.spacing.expression import Expression


def test_a_thread_that_enters_while_another_is_inside_waits_and_the_filters_come_back():
    before, inside = list(warnings.filters), Event()

    def first():
        with warnings_are("ignore"):
            inside.set()
            assert not entered.wait(0.2)

    def second():
        inside.wait()
        with warnings_are("error"):
            entered.set()

    entered = Event()
    with ThreadPoolExecutor(2) as pool:
        for done in [pool.submit(first), pool.submit(second)]:
            done.result()
    assert entered.is_set()
    assert warnings.filters == before


def test_threads_that_draw_and_read_expressions_leave_no_setting_behind():
    filters, settings = list(warnings.filters), dict(mpl.rcParams)
    mesh, together = holed_square(), Barrier(2)

    def draw(number):
        together.wait()
        Expression.parse(f"0.1 + {number}*x")
        return small_png(mesh, STANDARD)

    with ThreadPoolExecutor(2) as pool:
        pictures = set(pool.map(draw, range(2)))
    assert len(pictures) == 1
    assert warnings.filters == filters
    assert dict(mpl.rcParams) == settings
