"""Data of Gmsh's files (.msh): numbers at nodes and of elements, at one time or at several."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import FileError, prefixed
from bubblemesh.meshfiles.sources.msh_sections import Binary, Form, Numbers, Section, Text, first_line
from bubblemesh.meshfiles.sources.source import Numbering, wholes
from bubblemesh.messages import shown

NODES, ELEMENTS, CORNERS = "NodeData", "ElementData", "ElementNodeData"


class _Step(NamedTuple):
    """Numbers of one section of data."""

    name: str
    time: float
    number: int
    numbers: Integers  # (m,) of nodes or elements
    values: Floats  # (m,) or (m, k)


def data_at(sections: Iterable[Section], form: Form, numbering: Numbering) -> tuple[dict[str, Floats], list[str]]:
    """Data (n,) or (n, k), by name, of nodes or elements with numbers (n,), and notes on what is not read.

    Of several times the last one is read; missing values are NaN. FileError if a section is damaged, or has values for
    nodes or elements that do not exist.
    """
    steps: dict[str, list[_Step]] = {}
    for section in sections:
        step = _step(section, form)
        steps.setdefault(step.name, []).append(step)
    found, notes = {}, []
    for name, all_steps in steps.items():
        last = max(all_steps, key=lambda step: (step.time, step.number))
        if len(all_steps) > 1:
            which = f"step {last.number}" if all_steps[0].time == all_steps[-1].time else f"{last.time:g}"
            notes.append(f"holds {len(all_steps)} times of {name}: the last one, {which}, is read")
        found[name] = np.full((len(numbering), *last.values.shape[1:]), np.nan)
        with prefixed(f"its data {shown(name)}"):
            found[name][numbering.places(last.numbers)] = last.values
    return found, notes


def _step(section: Section, form: Form) -> _Step:
    """Data of a section, which begins with texts, real numbers and whole numbers, each after their count."""
    tags, rest = list[list[bytes]](), section.body
    for what in ("names", "times", "counts"):
        first, rest = first_line(rest)
        lines = list[bytes]()
        for _ in range(int(wholes([first], f"numbers of {what} of data")[0])):
            if not rest:
                raise FileError(f"its section {section.name} ends too early")
            one, rest = first_line(rest)
            lines.append(one)
        tags.append(lines)
    names, times, counts = tags
    if not names or len(counts) < 3:
        raise FileError(f"its section {section.name} has no name, or no number of values")
    number, width, count = wholes(counts[:3], "counts of data").tolist()
    numbers: Numbers = Binary(rest, section.name, form) if form.binary else Text(rest, section.name)
    rows, values = numbers.rows(count, width)
    name = names[0].strip(b'"').decode("utf-8", "replace")
    return _Step(name, _time(times), number, rows, values[:, 0] if width == 1 else values)


def _time(times: list[bytes]) -> float:
    try:
        return float(times[0]) if times else 0.0
    except ValueError:
        return 0.0
