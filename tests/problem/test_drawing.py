"""What a case moves and repeats."""

import re

import numpy as np
import pytest
import shapely

from bubblemesh.case import load_case
from bubblemesh.errors import BubblemeshError, located
from bubblemesh.problem.domain import case_domain

BOARD = "{rectangle: [0, 0, 12, 8], label: edge}"


def domain_of(text, folder="."):
    return case_domain(load_case(f"{folder}/case.yaml", text=f"spacing: 0.5\n{text}"))


def located_domain_of(text):
    case = load_case("case.yaml", text=f"spacing: 0.5\n{text}")
    with located("case.yaml", case.origin):
        return case_domain(case)


def holes_of(entry, extra=""):
    domain = domain_of(f"domain: {{outer: {BOARD}, holes: [{entry}]}}\n{extra}")
    return sorted(tuple(np.round(hole.centroid.coords[0], 9)) for hole in map(_polygon, domain.polygon.interiors))


def _polygon(ring):
    return shapely.Polygon(ring)


@pytest.mark.parametrize(
    ("keys", "centers"),
    [
        ("move: [2, 3]", [(3, 4)]),
        ("scale: 2", [(2, 2)]),
        ("rotate: 90, move: [6, 0]", [(5, 1)]),
        ("rotate: {by: 180, about: [3, 3]}", [(5, 5)]),
        ("mirror: x, move: [6, 0]", [(5, 1)]),
        ("mirror: y, move: [0, 6]", [(1, 5)]),
        ("repeat: {grid: [3, 2], step: [2, 3]}", [(1, 1), (1, 4), (3, 1), (3, 4), (5, 1), (5, 4)]),
        ("repeat: {grid: [2*n, 1], step: [2, 0]}", [(1, 1), (3, 1), (5, 1), (7, 1)]),
        ("repeat: {around: [4, 4], times: 4}", [(1, 1), (1, 7), (7, 1), (7, 7)]),
        ("move: [1, 1], repeat: {around: [4, 4], times: n}", [(2, 2), (6, 6)]),
        ("repeat: {grid: [4, 3], step: [2, 2], where: i == 3 and j != 1}", [(7, 1), (7, 5)]),
        ("repeat: {around: [4, 4], times: 4, where: i % n}", [(1, 7), (7, 1)]),
    ],
)
def test_holes_are_where_the_keys_take_them(keys, centers):
    entry = f"{{circle: {{center: [1, 1], radius: 0.3}}, {keys}}}"
    assert holes_of(entry, "parameters: {n: 2}") == centers


def test_the_first_copies_are_the_first_column():
    domain = domain_of(
        f"domain: {{outer: {BOARD}, holes: [{{rectangle: [1, 1, 2, 2], repeat: {{grid: [2, 2], step: [3, 4]}}}}]}}"
    )
    first = [tuple(np.array(hole.coords).min(axis=0)) for hole in domain.polygon.interiors]
    assert first == [(1, 1), (1, 5), (4, 1), (4, 5)]
    assert domain.labels == ("edge", "hole-1", "hole-2", "hole-3", "hole-4")


def test_lines_points_and_regions_are_repeated_too():
    domain = domain_of(f"""
domain:
  outer: {BOARD}
  lines:
    - {{path: [[1, 1], [2, 1]], repeat: {{grid: [1, 3], step: [0, 2]}}}}
    - {{path: [[1, 7], [2, 7]], label: last}}
    - {{path: [[3, 7], [4, 7]]}}
  points:
    - {{at: [11, 1], repeat: {{grid: [1, 2], step: [0, 1]}}}}
    - {{at: [1, 1], rotate: {{by: 90, about: [6, 1]}}, move: [-1, 8], label: well}}
    - {{at: [1, 2], move: [10, 4]}}
  regions:
    - {{name: coil, ring: {{circle: {{center: [0, 0], radius: 0.5}}, move: [5, 0]}}, move: [0, 2],
       repeat: {{grid: [2, 1], step: [2, 0]}}}}
""")
    assert [line.label for line in domain.parts.lines] == ["line-1", "line-2", "line-3", "last", "line-5"]
    points = {point.label: point.at for point in domain.parts.points}
    assert points == {"point-1": (11, 1), "point-2": (11, 2), "well": (5, 4), "point-4": (11, 6)}
    assert [region.name for region in domain.parts.regions] == ["coil", "coil"]
    assert [tuple(np.round(r.polygon.centroid.coords[0], 9)) for r in domain.parts.regions] == [(5, 2), (7, 2)]


def test_files_are_scaled_when_they_are_read_and_moved_then(tmp_path):
    (tmp_path / "slot.csv").write_text("0,0\n100,0\n100,50\n0,50\n")
    text = f"domain: {{outer: {BOARD}, holes: [{{file: slot.csv, units: cm, mirror: x, move: [3, 1]}}]}}"
    domain = domain_of(text, tmp_path)
    assert domain.polygon.interiors[0].bounds == (2, 1, 3, 1.5)
    domain = domain_of("domain: {file: slot.csv, scale: 0.1, rotate: 90}", tmp_path)
    assert domain.bounds == (-5, 0, 0, 10)


def test_a_ring_is_followed_after_it_has_been_moved(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    np.savetxt(tmp_path / "disc.csv", np.column_stack([np.cos(angle), np.sin(angle)]), delimiter=",")
    text = f"domain: {{outer: {BOARD}, holes: [{{file: disc.csv, scale: 2, corners: 30, move: [5, 4]}}]}}"
    domain = domain_of(text, tmp_path)
    assert domain.given_outlines[1].mean(axis=0) == pytest.approx([5, 4])
    assert np.hypot(*(domain.given_outlines[1] - [5, 4]).T) == pytest.approx(2)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("scale: -1", "scale: must be greater than 0"),
        ("mirror: z", "mirror: must be 'x' or 'y'"),
        ("rotate: {about: [0, 0]}", "rotate.by: is missing"),
        ("repeat: {grid: [2, 2]}", "repeat.step: is missing"),
        ("repeat: {grid: [0, 2], step: [1, 1]}", "repeat.grid.0: must be at least 1"),
        ("repeat: {grid: [2.5, 2], step: [1, 1]}", "repeat.grid.0: must be a whole number"),
        ("repeat: {grid: [1e4, 1e4], step: [1, 1]}", "repeat: makes 100,000,000 copies, more than 100,000"),
        ("repeat: {around: [0, 0], times: 1e9}", "repeat.times: must be at most 100000"),
        ("repeat: {times: 3}", "repeat: must be a mapping with exactly one of the keys grid, around"),
        ("repeat: {around: [0, 0], times: 3, where: k}", "repeat.where: column 1: unknown name 'k'"),
        ("repeat: {around: [0, 0], times: 3, where: i > 5}", "no copy has i > 5"),
        ("repeat: {around: [0, 0], times: 3}", "hole 2 at (-1.51603, 0.62583) lies outside"),
    ],
)
def test_wrong_keys_are_told(keys, message):
    with pytest.raises(BubblemeshError, match=re.escape(message)):
        holes_of(f"{{circle: {{center: [1, 1], radius: 0.3}}, {keys}}}")


def test_a_parameter_with_the_name_of_a_copys_number_is_told():
    with pytest.raises(BubblemeshError, match="'i' is the number of a copy here, and a parameter too: rename"):
        holes_of(
            "{circle: {center: [1, 1], radius: 0.3}, repeat: {around: [4, 4], times: 4, where: i}}",
            "parameters: {i: 2}",
        )


CIRCLE = "circle: {center: [1, 1], radius: 0.3}"


@pytest.mark.parametrize(
    ("label", "repeat", "labels"),
    [
        (
            "label: pad, ",
            'grid: [2, 2], step: [3, 4], name: "pad-{i}-{j}"',
            ["pad-0-0", "pad-0-1", "pad-1-0", "pad-1-1"],
        ),
        ("label: pad, ", 'grid: [3, 1], step: [3, 0], where: i != 1, name: "{name} {i + 1}"', ["pad 1", "pad 3"]),
        ("", 'around: [4, 4], times: 2, name: "slot-{n*i}{{x}}"', ["slot-0{x}", "slot-20{x}"]),
        ("label: pad, ", 'grid: [2, 1], step: [3, 0], name: "{name}"', ["pad"]),
        ("label: pad, ", 'grid: [1, 1], step: [0, 0], name: "only-{i}"', ["only-0"]),
    ],
)
def test_copies_may_have_names_of_their_own(label, repeat, labels):
    hole = f"{{{CIRCLE}, {label}repeat: {{{repeat}}}}}"
    domain = domain_of(f"parameters: {{n: 20}}\ndomain: {{outer: {BOARD}, holes: [{hole}]}}")
    assert list(domain.labels) == ["edge", *labels]


def test_each_label_of_a_copys_sides_is_in_its_name():
    square = "rectangle: [1, 1, 2, 2], labels: [b, r, t, l]"
    repeat = '{grid: [2, 1], step: [4, 0], name: "{name}{i}"}'
    domain = domain_of(f"domain: {{outer: {BOARD}, holes: [{{{square}, repeat: {repeat}}}]}}")
    assert set(domain.labels) == {"edge", *(f"{side}{k}" for side in "brtl" for k in (0, 1))}


def test_regions_lines_and_points_have_names_of_their_own_as_well():
    domain = domain_of(f"""
domain:
  outer: {BOARD}
  regions:
    - {{name: slot, ring: {{{CIRCLE}, label: rim}}, repeat: {{grid: [2, 1], step: [2, 0], name: "{{name}}-{{i}}"}}}}
    - {{name: bar, ring: {{rectangle: [1, 4, 2, 5], repeat: {{grid: [1, 2], step: [0, 2], name: "side-{{j}}"}}}}}}
  lines: [{{path: [[8, 1], [9, 1]], label: wire, repeat: {{grid: [1, 2], step: [0, 2], name: "{{name}}-{{j}}"}}}}]
  points: [{{at: [11, 1], repeat: {{grid: [1, 2], step: [0, 2], name: "probe {{j}}"}}}}]
""")
    assert [region.name for region in domain.parts.regions] == ["slot-0", "slot-1", "bar", "bar"]
    assert domain.labels == ("edge", "wire-0", "wire-1", "rim", "side-0", "side-1", "probe 0", "probe 1")


@pytest.mark.parametrize(
    ("repeat", "message"),
    [
        ('name: "slot-{k}"', "repeat.name: column 1: unknown name 'k'"),
        ('name: "slot-{i"', "repeat.name: has a single brace"),
        ("name: 7", "repeat.name: must be a text (found 7)"),
        ('name: "{name}-{i}"', "repeat.name: '{name}-{i}': what is repeated has no name: give it a label"),
        ("name: 'a\"{i}'", "repeat.name: 'a\"0' is no name"),
        ('name: ""', "repeat.name: '' is no name"),
        ("outside: clip", "repeat.outside: must be 'error' or 'skip'"),
    ],
)
def test_wrong_names_of_copies_are_told(repeat, message):
    with pytest.raises(BubblemeshError, match=re.escape(message)):
        holes_of(f"{{{CIRCLE}, repeat: {{around: [4, 4], times: 2, {repeat}}}}}")


def test_a_parameter_called_name_is_told():
    hole = f'{{{CIRCLE}, label: pad, repeat: {{around: [4, 4], times: 2, name: "{{name}}-{{i}}"}}}}'
    with pytest.raises(BubblemeshError, match="'name' is the name of what is repeated here, and a parameter too"):
        holes_of(hole, "parameters: {name: 2}")
    assert len(holes_of(hole.replace("{name}", "pad"), "parameters: {name: 2}")) == 2


def test_a_case_with_names_of_copies_is_written_as_it_was_given():
    hole = f'{{{CIRCLE}, label: pad, repeat: {{around: [4, 4], times: 2, name: "{{name}}-{{i}}"}}}}'
    case = load_case("a.yaml", text=f"spacing: 0.5\ndomain: {{outer: {BOARD}, holes: [{hole}]}}")
    assert case.model_dump(mode="json")["domain"]["holes"][0]["repeat"]["name"] == "{name}-{i}"


class TestOutside:
    def test_copies_of_holes_and_regions_that_do_not_meet_the_domain_are_left_out(self):
        domain = domain_of(f"""
domain:
  outer: {BOARD}
  holes:
    - {{{CIRCLE}, label: pad, repeat: {{grid: [8, 2], step: [2, 5], name: "pad-{{i}}-{{j}}", outside: skip}}}}
  regions:
    - name: slot
      ring: {{rectangle: [2.5, 2.5, 3.5, 3.5]}}
      repeat: {{grid: [4, 3], step: [3.2, 2], name: "slot-{{i}}-{{j}}", outside: skip}}
  lines: [{{path: [[1, 4], [2, 4]], repeat: {{grid: [3, 1], step: [5, 0], outside: skip}}}}]
  points: [{{at: [11.5, 4], repeat: {{grid: [2, 1], step: [5, 0], outside: skip}}}}]
""")
        assert len(domain.polygon.interiors) == 12
        assert [label for label in domain.labels if "pad" in label] == [
            f"pad-{i}-{j}" for i in range(6) for j in (0, 1)
        ]
        names = [region.name for region in domain.parts.regions]
        assert names == [f"slot-{i}-{j}" for i in range(3) for j in range(3)]
        assert (len(domain.parts.lines), len(domain.parts.points)) == (3, 1)
        left_out = [note for note in domain.notes if "left out" in note]
        assert left_out[0] == "4 holes left out, outside of the domain"
        assert any(note.startswith("1 point left out") for note in domain.parts.notes)

    def test_a_copy_that_only_touches_the_domain_is_outside_and_one_in_a_hole_too(self):
        square = "ring: {rectangle: [10, 1, 12, 3]}"
        domain = domain_of(f"""
domain:
  outer: {BOARD}
  holes: [{{rectangle: [4, 1, 8, 3]}}]
  regions:
    - {{name: slot, {square}, repeat: {{grid: [2, 1], step: [2, 0], outside: skip}}}}
    - name: plug
      ring: {{circle: {{center: [5, 2], radius: 0.5}}}}
      repeat: {{grid: [1, 2], step: [0, 4], outside: skip}}
""")
        assert [region.name for region in domain.parts.regions] == ["slot", "plug"]
        assert domain.parts.notes == ("2 regions left out, outside of the domain: 'slot', 'plug'",)

    def test_a_copy_across_the_boundary_is_told_as_before(self):
        with pytest.raises(BubblemeshError, match="hole 2 crosses the outer ring at"):
            holes_of(f"{{{CIRCLE}, repeat: {{grid: [2, 1], step: [11, 0], outside: skip}}}}")

    def test_copies_of_files_that_are_followed_are_left_out_too(self, tmp_path):
        angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
        np.savetxt(tmp_path / "disc.csv", np.column_stack([3 + np.cos(angle), 3 + np.sin(angle)]), delimiter=",")
        hole = "{file: disc.csv, corners: 30, repeat: {grid: [4, 1], step: [3, 0], outside: skip, where: i != 3}}"
        far = hole.replace("[3, 0]", "[20, 0]")
        assert len(domain_of(f"domain: {{outer: {BOARD}, holes: [{hole}]}}", tmp_path).polygon.interiors) == 3
        assert len(domain_of(f"domain: {{outer: {BOARD}, holes: [{far}]}}", tmp_path).polygon.interiors) == 1

    @pytest.mark.parametrize(
        "domain",
        [
            "{outer: {rectangle: [0, 0, 1, 1], repeat: {grid: [2, 1], step: [3, 0], outside: skip}}}",
            "{outer: {minus: [{rectangle: [0, 0, 9, 9]}, "
            "{rectangle: [1, 1, 2, 2], repeat: {grid: [2, 1], step: [9, 0], outside: skip}}]}}",
        ],
    )
    def test_rings_around_a_domain_may_not_be_left_out(self, domain):
        with pytest.raises(BubblemeshError, match="outside: skip is for holes, regions, lines and points"):
            domain_of(f"domain: {domain}")


class TestOverlaid:
    PLATE = "{rectangle: [0, 0, 4, 2], label: plate}"
    TOOL = "{circle: {center: [4, 1], radius: 0.5}, label: tool}"

    @pytest.mark.parametrize(
        ("ring", "area"),
        [
            (f"{{union: [{PLATE}, {TOOL}]}}", 8 + np.pi / 8),
            (f"{{minus: [{PLATE}, {TOOL}]}}", 8 - np.pi / 8),
            (f"{{intersection: [{PLATE}, {TOOL}]}}", np.pi / 8),
            (f"{{minus: [{PLATE}, {{union: [{TOOL}, {{rectangle: [0, 0, 1, 2]}}]}}]}}", 6 - np.pi / 8),
            (f"{{union: [{PLATE}, {{rectangle: [0, 0, 4, 2], move: [4, 0]}}]}}", 16),
            ("{union: [{rectangle: [0, 0, 1, 1], repeat: {grid: [5, 1], step: [1, 0]}}]}", 5),
            ("{union: [{rectangle: [0, 0, 1, 4], repeat: {around: [0.5, 2], times: 2}}], scale: 2}", 16),
            (f"{{minus: [{PLATE}, {{circle: {{center: [2, 1], radius: 0.5}}}}], rotate: 90}}", 8 - np.pi / 4),
            (f"{{minus: [{PLATE}, {{rectangle: [1, -1, 2, 3]}}]}}", 6),
        ],
    )
    def test_as_the_outer_ring(self, ring, area):
        assert domain_of(f"domain: {{outer: {ring}}}").polygon.area == pytest.approx(area, rel=1e-3)

    def test_as_holes_and_regions(self):
        cross = "{union: [{rectangle: [-1, -0.2, 1, 0.2]}, {rectangle: [-0.2, -1, 0.2, 1]}]"
        domain = domain_of(f"""
domain:
  outer: {BOARD}
  holes: [{cross}, label: cross, rotate: 30, move: [2, 2], repeat: {{grid: [3, 1], step: [3, 0]}}}}]
  regions: [{{name: frame, ring: {{minus: [{{rectangle: [1, 4, 6, 7]}}, {{rectangle: [2, 5, 5, 6]}}]}}}}]
""")
        assert domain.hole_count == 3
        assert domain.polygon.area == pytest.approx(96 - 3 * 1.44)
        assert [region.name for region in domain.parts.regions] == ["frame"]
        assert "cross" in domain.labels

    def test_of_files_all_areas_count_with_their_holes(self, tmp_path):
        (tmp_path / "two.wkt").write_text(
            "POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0), (1 1, 1 2, 2 2, 2 1, 1 1))\nPOLYGON ((6 0, 7 0, 7 1, 6 1, 6 0))\n"
        )
        text = "domain: {outer: {union: [{file: two.wkt}, {rectangle: [4, 0, 6, 1], label: bridge}]}}"
        domain = domain_of(text, tmp_path)
        assert domain.polygon.area == 18
        assert (domain.piece_count, domain.hole_count) == (1, 1)

    def test_straight_sides_are_followed_after_all(self):
        angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
        points = np.column_stack([np.cos(angle), np.sin(angle)]).tolist()
        text = f"domain: {{outer: {{minus: [{{polygon: {points}}}, {{rectangle: [0, -2, 2, 2]}}], corners: 30}}}}"
        domain = domain_of(text)
        assert len(domain.boundary.kind) == 2
        assert 0 in domain.given_outlines

    @pytest.mark.parametrize(
        ("ring", "message"),
        [
            ("{union: []}", "domain.outer.union: must have at least one entry"),
            (
                f"{{intersection: [{PLATE}, {{circle: {{center: [9, 9], radius: 1}}}}]}}",
                "case.yaml:2: domain: the outer ring: nothing is left of intersection: [rectangle 'plate', circle]: th",
            ),
            (f"{{minus: [{PLATE}, {PLATE}]}}", "nothing is left of minus: [rectangle 'plate', rectangle 'plate']: the"),
            (
                f"{{union: [{PLATE}, {{polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]}}]}}",
                "the outer ring: the ring crosses or touches itself at (0.5, 0.5)",
            ),
            (f"{{union: [{PLATE}, {{polygon: []}}]}}", "the outer ring: union, ring 2: a polygon has no points"),
            (f"{{union: [{PLATE}, {{rectangle: [4.0000001, 0, 5, 2]}}]}}", "next to"),
        ],
    )
    def test_what_gives_no_ring_is_told(self, ring, message):
        with pytest.raises(BubblemeshError, match=re.escape(message)):
            located_domain_of(f"domain: {{outer: {ring}}}")

    def test_a_hole_in_a_hole_is_an_area_again(self):
        ring = "{minus: [{rectangle: [1, 1, 5, 5]}, {rectangle: [2, 2, 4, 4]}]}"
        whole = domain_of(f"domain: {{outer: {BOARD}}}")
        found = domain_of(f"domain: {{outer: {BOARD}, holes: [{ring}]}}")
        assert found.polygon.area == pytest.approx(whole.polygon.area - 16 + 4)
        assert (found.piece_count, found.hole_count) == (2, 1)
