"""Batches in parts."""

from pathlib import Path

import pytest
from batch_cases import names, write
from batches import (
    SMALL,
    events_of,
    finished,
    lines_of,
    results_in,
    rows_of,
)

from bubblemesh.batch import BatchOptions, parse_shard
from bubblemesh.errors import CaseError


@pytest.mark.parametrize("text", ["0/4", "5/4", "1", "1/0", "a/b", "1/2/3", "-1/2", ""])
def test_a_shard_is_a_part_and_a_number_of_parts(text):
    with pytest.raises(CaseError, match=r"--shard .*from 1/N to N/N"):
        parse_shard(text)


def test_shards_are_disjoint_and_together_everything():
    parts = [BatchOptions(shard=parse_shard(f"{k}/4")).part_of(range(10)) for k in range(1, 5)]
    assert sorted(entry for part in parts for entry in part) == list(range(10))
    assert {len(part) for part in parts} == {2, 3}
    assert BatchOptions(shard=parse_shard("1/1")).part_of(range(3)) == [0, 1, 2]


def test_each_shard_has_a_summary_of_its_own(here):
    write(here, **{name: SMALL for name in "abcde"})
    rows_of(".", folder="whole")
    for index in range(1, 4):
        rows_of(*[path for path in names(here) if path.endswith("yaml")], folder="out", shard=(index, 3))
    assert results_in(here / "out") == results_in(here / "whole")
    cases = {
        index: [line["case"] for line in lines_of(here / f"out/summary-{index}-of-3.jsonl")] for index in (1, 2, 3)
    }
    assert {index: sorted(found) for index, found in cases.items()} == {1: ["a", "d"], 2: ["b", "e"], 3: ["c"]}
    assert not Path("out/summary.jsonl").exists()
    ends = finished(".", folder="out", resume=True)
    assert [(end.row.case, end.unchanged) for end in ends] == [(name, True) for name in "abcde"]
    assert sorted(line["case"] for line in lines_of(Path("out/summary.jsonl"))) == list("abcde")


def test_shards_are_numbered_so_that_their_files_sort():
    assert BatchOptions(shard=(3, 16)).suffix == "-03-of-16"
    assert BatchOptions(shard=(1, 1)).suffix == ""


def test_a_collision_is_found_whichever_shard_the_cases_are_in(here):
    write(here, a__x=SMALL, b__x=SMALL)
    with pytest.raises(CaseError, match="would both write"):
        events_of("a", "b", folder="out", shard=(1, 2))


def test_a_shard_may_be_empty(here):
    write(here, a=SMALL)
    assert rows_of(".", folder="out", shard=(2, 2), workers=lambda count: pytest.fail("nothing to do")) == []
    assert lines_of(Path("out/summary-2-of-2.jsonl")) == []
