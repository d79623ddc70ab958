"""The trial of files as users have them: its collection, how it follows messages, and what it would notice."""

import json

import numpy as np
import pytest
import shapely

from benchmarks.intake import maps, points
from benchmarks.intake.collection import KINDS, draw_all
from benchmarks.intake.page import page, reason
from benchmarks.intake.shapes import drawn
from benchmarks.intake.trial import advised, mesh_one, row_of
from benchmarks.robustness.capped import Call

ROW = {"name": "a.wkt", "kind": "lake", "holds_area": True, "outcome": "refused", "why": "", "wrong": [], "cpu": 1.0}


def task_of(found, **more):
    row = {"name": found.path.name, "kind": "lake", "folder": str(found.path.parent), "holds_area": True}
    return row | {"size": found.size, "areas": found.areas, "tolerance": found.tolerance} | more


def written(folder, *parts):
    path = folder / "a.wkt"
    path.write_text("\n".join(map(shapely.to_wkt, parts)))
    return drawn(path, parts)


def test_the_collection_is_large_enough():
    assert len(KINDS) >= 10
    assert sum(kind.count for kind in KINDS.values()) >= 300


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_is_the_same_every_time(kind, tmp_path):
    contents = []
    for name in "ab":
        folder = tmp_path / name
        folder.mkdir()
        found = KINDS[kind].draw(folder, 2, np.random.default_rng(5))
        assert found.size > 0
        contents.append(found.path.read_bytes())
    # Drawings and tables of layers hold the time at which they are made.
    assert kind in ("drawing", "counties") or contents[0] == contents[1]


def test_files_are_drawn_once(tmp_path, monkeypatch):
    for name in KINDS:
        monkeypatch.setitem(KINDS, name, KINDS[name]._replace(count=int(name in ("scan", "graph"))))
    rows = draw_all(tmp_path / "files")
    assert {row["name"] for row in rows} == {"scan-00.csv", "graph-00.poly"}
    (tmp_path / "files" / "scan-00.csv").unlink()
    assert draw_all(tmp_path / "files") == rows
    assert not (tmp_path / "files" / "scan-00.csv").exists()


@pytest.mark.parametrize(
    ("message", "key"),
    [
        ("2 areas: choose by part: largest, part: all or part: N, or by feature", {"part": "largest"}),
        ("choose by part: N, or give repair: true", {"repair": True}),
        ("gaps: draw what is missing, or join: 0.0125", {"join": 0.0125}),
        ("layers that close: A, B: choose by layer: A", {"layer": "A"}),
        ("choose by feature: {id: bore}", {"feature": {"id": "bore"}}),
        ("open ends at (1, 2): close the curve", {}),
        ("no key of ours: parts: 3", {}),
    ],
)
def test_the_key_that_a_message_names(message, key):
    assert advised(message) == key


def test_a_file_that_gets_in_at_once(tmp_path):
    row = mesh_one(task_of(written(tmp_path, shapely.box(0, 0, 3, 2)), read=True))
    assert (row["outcome"], row["wrong"], row["area"]) == ("at once", [], 6)


@pytest.mark.long
def test_a_file_that_gets_in_with_the_key(tmp_path):
    found = written(tmp_path, shapely.box(0, 0, 1, 1), shapely.box(2, 0, 4, 1))
    row = mesh_one(task_of(found, meshes=str(tmp_path)))
    assert (row["outcome"], row["keys"], row["wrong"]) == ("with the key", {"part": "largest"}, [])
    assert (tmp_path / "a.wkt.vtu").exists()


def test_a_wrong_area_is_noticed(tmp_path):
    found = written(tmp_path, shapely.box(0, 0, 1, 1))
    row = mesh_one(task_of(found._replace(areas=(1.001,)), read=True))
    assert row["wrong"] == ["the area differs from the file's by -1.0e-03"]


def test_a_file_that_does_not_get_in(tmp_path):
    found = written(tmp_path, shapely.box(0, 0, 1, 1))
    found.path.write_text("LINESTRING (0 0, 1 0, 1 1)")
    row = mesh_one(task_of(found, read=True))
    assert (row["outcome"], row["code"]) == ("refused", 3)
    assert "open ends" in row["why"]


def test_a_crash_and_no_end_are_outcomes():
    task = {"name": "a", "kind": "lake", "holds_area": True}
    assert row_of(Call(task, 1.0, crash="Traceback\nKeyError: 1"))["outcome"] == "crash"
    assert row_of(Call(task, 1.0, crash="no end after 1 s"))["outcome"] == "no end"


def test_one_reason_has_one_text():
    texts = ["/tmp/a.wkt: open ends: line 3 at (1, 2): 4.5e-3 away", "/b/a.wkt: open ends: line 14 at (7, -2): 12 away"]
    assert len({reason(ROW | {"why": text}) for text in texts}) == 1


def test_the_page_counts_what_gets_in(tmp_path):
    rows = [ROW | {"outcome": "at once", "nodes": 1000, "least": 0.7}, ROW | {"why": "a.wkt: open ends"}]
    path = tmp_path / "rows.jsonl"
    path.write_text("\n".join(map(json.dumps, rows)))
    text = page(path)
    assert "Of 2 files of 1 kinds 2 hold an area; of those 1 mesh, which is 50.0%. 0 ended in a crash" in text
    assert f"| lake | {KINDS['lake'].about} | 2 | 1 | 0 | 1 | 10.0 | 0.70 |" in text
    assert "| 1 | yes | open ends | a.wkt |" in text


def test_borders_of_neighbours_are_shared(tmp_path):
    found = maps.states(tmp_path, 0, np.random.default_rng(1))
    shapes = [
        shapely.from_geojson(json.dumps(one["geometry"])) for one in json.loads(found.path.read_text())["features"]
    ]
    assert shapely.coverage_is_valid(np.array(shapes))
    assert sum(found.areas) == pytest.approx(shapely.union_all(shapes).area)


def test_sections_are_simple(tmp_path):
    for number in range(8):
        assert points.airfoil(tmp_path, number, np.random.default_rng(number)).areas is not None
