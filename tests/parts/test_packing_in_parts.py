"""Domains packed in parts: cuts, the parts' domains, what they have in common, and the joined meshes."""

import pickle
from itertools import pairwise, product

import numpy as np
import pytest
import shapely
from invariants import check_mesh
from part_cases import CASES, CHECKS, HOLES, PERIODIC, REGIONS, SHORE, SQUARE, case, meshed
from partitions import MOONS
from scipy.spatial import cKDTree
from sweeps import sweep
from twins import needs_compiler

from bubblemesh.case import load_case
from bubblemesh.errors import CaseError
from bubblemesh.meshes.quality import Measures, radius_ratios
from bubblemesh.packing.placement.diffusion import boundary_bubbles
from bubblemesh.parts import seams
from bubblemesh.parts.cuts import find_cuts
from bubblemesh.parts.division import cut_domain
from bubblemesh.parts.landings import Landings
from bubblemesh.parts.periodic_sides import CutPeriodicSides
from bubblemesh.parts.pipeline import PER_PART, enough_parts
from bubblemesh.parts.work import Deadline, alone
from bubblemesh.problem.prepare import prepare
from bubblemesh.process.resources import WorkClock
from bubblemesh.run.pipeline import mesh_case
from bubblemesh.run.time_limit import TimeLimit
from bubblemesh.spacing.grid.table import tabulated


def division_of(text, parts):
    problem = prepare(case(text))
    cuts = find_cuts(problem.domain, problem.packing_spacing, problem.expected_nodes, parts)
    return problem, cuts, cut_domain(problem.domain, cuts, problem.packing_spacing, coarsened=problem.method.coarsens)


def nodes_of(domain, places, division):
    """Places (k, 2) of what a part holds, in the order of the division's pieces and arc lengths."""
    held = domain.held
    piece, turned = places.piece[held.piece], places.turned[held.piece]
    s = np.where(turned, division.boundary.lengths[piece] - held.s, held.s)
    return {
        int(number): domain.boundary.points(held.piece[mine], held.s[mine])[np.argsort(s[mine])]
        for number in np.unique(piece)
        for mine in [np.flatnonzero(piece == number)]
    }


@pytest.mark.parametrize(("name", "parts"), sweep(product(CASES, [7, 3, 2]), quick=8))
def test_parts_are_as_much_work_as_each_other_and_make_up_the_domain(name, parts):
    problem, cuts, division = division_of(CASES[name], parts)
    assert cuts.cells == parts
    np.testing.assert_allclose(cuts.work, problem.expected_nodes / parts, rtol=0.35)
    domains = [division.part(cell)[0] for cell in range(parts)]
    assert all(domain.polygon.is_valid for domain in domains)
    total = sum(domain.polygon.area for domain in domains)
    assert total == pytest.approx(
        problem.domain.polygon.area, rel=1e-3 if problem.domain.boundary.curved.any() else 1e-12
    )
    x0, y0, x1, y1 = problem.domain.bounds
    points = np.random.default_rng(1).uniform([x0, y0], [x1, y1], (2000, 2))
    points = points[problem.domain.signed_distance(points) > 0.01]
    inside = np.array([domain.contains(points) for domain in domains])
    np.testing.assert_array_equal(inside.sum(axis=0), 1)
    np.testing.assert_array_equal(inside.argmax(axis=0), cuts.cell_of(points))


@pytest.mark.parametrize("name", CASES)
def test_neighbours_have_the_same_bubbles_along_their_cut(name):
    _, cuts, division = division_of(CASES[name], 5)
    found = {}
    for cell in range(cuts.cells):
        domain, places = division.part(cell)
        np.testing.assert_allclose(
            division.boundary.corners[places.corner], domain.boundary.corners, rtol=0, atol=1e-12
        )
        for piece, points in nodes_of(domain, places, division).items():
            found.setdefault(piece, []).append(points)
    between = set(np.flatnonzero(division.on_cut).tolist())
    assert between
    assert {len(found[piece]) for piece in between & set(found)} == {2}
    for points in found.values():
        for other in points[1:]:
            np.testing.assert_allclose(points[0], other, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", sweep(["REGIONS", "PERIODIC", "DISC", "SHORE", "AREAS", "HOLES", "SPLINE"], quick=4))
def test_a_mesh_of_parts_is_as_good_as_that_of_one_piece(name):
    one, many = meshed(CASES[name]), meshed(CASES[name], 4)
    mesh = many.mesh
    for check in CHECKS[len(mesh.regions) > 1 :]:  # corners of regions come before other boundary nodes
        check(mesh)
    assert mesh.labels == one.mesh.labels
    assert mesh.regions == one.mesh.regions
    assert mesh.point_labels == one.mesh.point_labels
    assert len(mesh.points) == pytest.approx(len(one.mesh.points), rel=0.06)
    assert len(mesh.periodic) == pytest.approx(len(one.mesh.periodic), rel=0.05)
    assert many.report["quality"]["mean"] > one.report["quality"]["mean"] - 0.006
    assert many.report["quality"]["min"] > one.report["quality"]["min"] - 0.12
    areas = [mesh.points[mesh.triangles[mesh.triangle_regions == k]] for k in range(len(mesh.regions))]
    others = [one.mesh.points[one.mesh.triangles[one.mesh.triangle_regions == k]] for k in range(len(mesh.regions))]
    for mine, theirs in zip(areas, others, strict=True):
        assert shapely.area(shapely.polygons(mine)).sum() == pytest.approx(
            shapely.area(shapely.polygons(theirs)).sum(), rel=2e-3
        )
    assert many.report["parts"]["number"] == 4


@pytest.mark.parametrize("parts", sweep([3, 5, 8], quick=2))
def test_ends_of_cuts_make_no_short_sides_on_a_wall_of_many_corners(parts):
    one, many = meshed(SHORE), meshed(SHORE, parts)
    shortest = [
        np.hypot(*(mesh.points[mesh.facets[:, 0]] - mesh.points[mesh.facets[:, 1]]).T).min()
        for mesh in (one.mesh, many.mesh)
    ]
    assert shortest[1] > 0.65 * shortest[0]
    assert many.report["quality"]["min"] > one.report["quality"]["min"] - 0.15


@pytest.mark.parametrize("size", sweep([0.03, 0.025], quick=1))
def test_ends_of_cuts_make_no_short_sides_on_the_front_of_layers(size):
    """Sides of a front that are long get a bubble in their middle, wherever a cut meets them."""
    text = f"""
domain:
  outer: {{rectangle: [0, 0, 2, 1]}}
  holes: [{{circle: {{center: [0.6, 0.5], radius: 0.2}}, label: body}}]
spacing: {size}
layers: [{{on: body, first: 0.001, until: isotropic}}]
"""
    result = mesh_case(case(text, 3 if size == 0.03 else 8))
    mesh = result.mesh
    check_mesh(mesh)
    packed = result.fields["layer"] == 0
    assert Measures(mesh.points, mesh.triangles[packed]).radius_ratios.min() > 0.7


def test_no_line_shows_where_the_cuts_were():
    text = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.008 + 0.006*(x + y)\n"
    problem, _, division = division_of(text, 3)
    mesh = mesh_case(case(text, 3)).mesh
    held = division.held
    lines = shapely.union_all(
        shapely.linestrings(
            np.stack(
                [division.boundary.corners[division.boundary.start[held.pieces]],
                 division.boundary.corners[division.boundary.end[held.pieces]]], axis=1,
            )
        )
    )  # fmt: skip
    centers = mesh.points[mesh.triangles].mean(axis=1)
    away = shapely.distance(lines, shapely.points(centers)) / problem.packing_spacing(centers)
    q = radius_ratios(mesh.points, mesh.triangles)
    inner = problem.domain.signed_distance(centers) > 0.03
    beside, elsewhere = q[inner & (away < 2)], q[inner & (away > 8)]
    assert len(beside) > 500
    assert beside.mean() > elsewhere.mean() - 0.001
    assert np.quantile(beside, 0.01) > np.quantile(elsewhere, 0.01) - 0.01
    # No edges follow the cut: those whose both ends are on it are few.
    on_cut = shapely.distance(lines, shapely.points(mesh.points)) < 1e-9
    assert on_cut.sum() < 0.1 * shapely.length(lines) / 0.014


RING = """
domain: {outer: {rectangle: [-3, -3, 3, 3]}}
spacing: 0.13*(0.2*abs(hypot(x, y) - 2) + 0.15)
"""


def test_on_each_level_cuts_have_every_second_bubble_of_the_next_one():
    problem, cuts, division = division_of(RING, 4)
    method, spacing = problem.method, problem.packing_spacing
    for cell in range(4):
        domain, places = division.part(cell)
        levels, _ = method.started(domain, tabulated(domain, spacing), float(cuts.work[cell]), 100_000)
        shells = [boundary_bubbles(domain, level) for level in levels]
        on_cuts = [shell.x[shell.corners :][places.on_cut[shell.piece]] for shell in shells]
        assert len(levels) == 3
        for coarse, fine in pairwise(on_cuts):
            assert cKDTree(fine).query(coarse)[0].max() < 1e-12
            pieces = places.on_cut.sum()
            assert len(fine) + pieces == 2 * (len(coarse) + pieces)


def test_cuts_meet_another_one_in_the_same_place_from_both_sides():
    """Bubbles at their ends would be nearer to each other than a spacing."""
    _, cuts, division = division_of(RING, 4)
    _, *others = (np.array(line.vertices) for line in cuts.lines)
    met = [end for line in others for end in line if np.abs(end).max() < 3]
    assert len(met) == 2
    np.testing.assert_allclose(*met, atol=1e-12)
    assert division.on_cut.sum() == 4


LAKE = """
domain: {outer: {rectangle: [0, 0, 2, 1]}}
spacing: min(0.02, 0.004 + 0.1*hypot(x - 0.5, y - 0.5))
packing: {effort: fast}
"""


def test_one_lattice_goes_on_across_the_cuts_of_a_mesh_that_is_even_in_most_of_it():
    parts = 3
    problem, mesh = prepare(case(LAKE)), mesh_case(case(LAKE, parts)).mesh
    lines = find_cuts(problem.domain, problem.packing_spacing, problem.expected_nodes, parts).lines
    cuts = shapely.multilinestrings([line.vertices for line in lines])
    middles = mesh.points[mesh.triangles].mean(axis=1)
    even = problem.packing_spacing(middles) > 0.0199
    beside = shapely.distance(cuts, shapely.points(middles)) < 0.06
    within = problem.domain.distance_at_least(middles) > 0.06
    q = radius_ratios(mesh.points, mesh.triangles)[even & beside & within]
    assert len(q) > 500
    assert q.mean() > 0.995  # 0.989 with a lattice for each part


def test_the_mesh_does_not_depend_on_who_packs_which_part_when():
    def backwards(function, jobs):
        results = [(number, function(*pickle.loads(pickle.dumps(job.arguments)))) for number, job in enumerate(jobs)]
        yield from reversed(results)

    coarse = case(REGIONS.replace("0.1,", "0.15,"), 3)
    first, second = (mesh_case(coarse, crew=crew) for crew in (alone, backwards))
    np.testing.assert_array_equal(first.mesh.points, second.mesh.points)
    np.testing.assert_array_equal(first.mesh.triangles, second.mesh.triangles)
    assert [row.nodes_after for row in first.report.rounds] == [row.nodes_after for row in second.report.rounds]


def test_the_longest_jobs_are_begun_first_and_workers_start_before_there_are_any(monkeypatch):
    monkeypatch.setattr(seams, "TOGETHER", 100)
    calls = []

    def noting(function, jobs):
        jobs = list(jobs)
        calls.append([job.arguments for job in jobs])
        return alone(function, jobs)

    mesh_case(case(SHORE.replace("0.055", "0.045"), 6), crew=noting)
    none, parts, strips, _ = calls
    assert none == []
    for work in ([part.expected_nodes for (part,) in parts], [len(arguments[0].triangles) for arguments in strips]):
        assert len(set(work)) > 1
        assert work == sorted(work, reverse=True)


def test_small_strips_are_packed_together_and_large_ones_alone(monkeypatch):
    monkeypatch.setattr(seams, "TOGETHER", 100)
    for sizes, groups in (
        ([], []),
        ([30], [0]),
        ([30, 40, 20], [0, 0, 0]),
        ([300, 30, 40, 20], [0, 1, 1, 1]),
        ([90, 60, 70, 40, 30], [0, 2, 1, 2, 1]),
    ):
        assert seams._together(np.array(sizes, np.int64)).tolist() == groups


@needs_compiler
@pytest.mark.parametrize("text", sweep([HOLES, REGIONS], quick=1), ids=["holes", "regions"])
def test_bands_are_settled_by_flips(text, monkeypatch):
    """A triangulation anew of all bands would take longer than all else that one process does alone."""
    settling = []

    def noted(net, spacing):
        settling.append(net)
        with monkeypatch.context() as patch:
            patch.setattr(seams, "linked", None)
            return settled(net, spacing)

    settled = seams.settled
    monkeypatch.setattr("bubblemesh.parts.pipeline.settled", noted)
    mesh_case(case(text, 3))
    assert [len(net.triangles) > 100 for net in settling] == [True]


def test_large_meshes_have_parts_that_two_and_four_workers_share_evenly():
    known = {1.4: 1, 1.6: 2, 2.9: 2, 3: 4, 5: 4, 7: 8, 9.5: 8, 11: 12, 94: 32, 1000: 100}
    assert {size: enough_parts(size * PER_PART) for size in known} == known


def test_one_part_is_the_mesh_of_one_piece():
    one, auto = meshed(HOLES), meshed(HOLES, "auto")
    np.testing.assert_array_equal(one.mesh.points, auto.mesh.points)
    assert "parts" not in auto.report


def test_a_least_angle_and_a_number_of_nodes_are_reached_in_parts_too():
    result = mesh_case(case(HOLES.replace("0.07", "{value: 0.1, nodes: 2000}") + "angle_min: 30\n", 3))
    check_mesh(result.mesh)
    assert len(result.mesh.points) == pytest.approx(2000, rel=0.02)
    assert result.report["quality"]["angle_min"] >= 30


def test_a_number_of_nodes_takes_several_attempts_where_the_first_one_misses():
    text = HOLES.replace("0.07", "{value: 0.1, nodes: 150}")
    result = mesh_case(case(text, 5))
    check_mesh(result.mesh)
    assert len(result.report["node_target"]["attempts"]) > 1


def test_a_late_packing_ends_with_a_valid_mesh(monkeypatch):
    monkeypatch.setattr(Deadline, "left", property(lambda self: 0.0))
    text = HOLES + "limits: {seconds: 1000}\n"
    result = mesh_case(case(text, 3))
    check_mesh(result.mesh)
    assert not result.report["finished"]
    assert "time limit" in str(result.verdict)


@pytest.mark.parametrize(("slowness", "finished"), [(1.0, True), (1e6, False)])
def test_parts_leave_more_time_for_the_rest_where_other_programs_take_the_processor(slowness, finished, monkeypatch):
    monkeypatch.setattr(WorkClock, "slowness", lambda self: slowness)
    result = mesh_case(case(HOLES + "limits: {seconds: 1000}\n", 3))
    assert result.report["finished"] == finished


def test_bubbles_that_slide_along_walls_have_no_cuts():
    with pytest.raises(CaseError, match="parts: bubbles would slide along the cuts"):
        mesh_case(load_case("parts.yaml", text=f"{HOLES}\nparts: 2\nmethod: accelerated\n"))


@pytest.mark.parametrize("parts", ["0", "-1", "2.5", "many", "[2]"])
def test_what_is_no_number_of_parts_is_told(parts):
    with pytest.raises(CaseError, match="parts: must be auto, or a whole number of at least 1"):
        case(HOLES, parts)


SMALL = "domain: {outer: {rectangle: [0, 0, 1, 1]}}\nspacing: 0.1\n"


@pytest.mark.parametrize("parts", [150, 999, 10**9])
def test_more_parts_than_nodes_are_refused(parts):
    with pytest.raises(CaseError, match=rf"parts: about \d+ nodes are too few for {parts} parts: ask for fewer"):
        mesh_case(case(SMALL, parts))


def test_parts_may_have_few_nodes():
    check_mesh(mesh_case(case(SMALL, 12)).mesh)


def test_the_share_that_a_time_limit_left_is_that_of_the_parts(monkeypatch):
    """The last share that is told while there is time counts, not what late parts make of it."""
    left, reserve = iter([1e9, 1e9, 1e9, 0.0, 0.0, 0.0, 0.0]), 1.0
    monkeypatch.setattr("bubblemesh.run.time_limit.time_left", lambda: next(left))
    told = list[float]()
    limit = TimeLimit(5.0, reserve, told.append)
    for share in (0.1, 0.3, 0.5, 0.8, 1.0):
        limit.tell(share)
    assert told == [0.1, 0.3, 0.5, 0.8, 1.0]
    assert limit.share == 0.5


def test_cuts_keep_off_corners_that_are_nearly_on_them():
    # Steps at every height, so that any even cut across would pass a corner.
    y = np.linspace(0, 4, 4001)
    x = 1 + 1e-3 * (np.arange(4001) % 2)
    outline = np.vstack([np.column_stack([x, y]), [[0, 4], [0, 0]]])
    text = f"domain: {{outer: {{polygon: {outline.tolist()}}}}}\nspacing: 0.1\n"
    problem, cuts, division = division_of(text, 6)
    assert sum(division.part(cell)[0].polygon.area for cell in range(6)) == pytest.approx(problem.domain.polygon.area)
    near = 1e-6 * problem.domain.size
    for line in cuts.lines:
        start, end = np.array(line.vertices)
        (ux, uy), (dx, dy) = (end - start) / np.hypot(*(end - start)), (outline - start).T
        assert np.abs(ux * dy - uy * dx).min() > near


@pytest.mark.parametrize("name", ["SQUARE", "SPLINE", "HOLES"])
def test_a_cut_leaves_walls_the_bubbles_that_they_have_without_it(name):
    text = CASES.get(name, f"\ndomain: {{outer: {SQUARE}}}\nspacing: 0.083 + 0.02*x*y\n")
    problem, cuts, division = division_of(text, 2)
    there = boundary_bubbles(problem.domain, problem.packing_spacing).x
    parts = [division.part(cell)[0] for cell in range(2)]
    (x0, y0), (x1, y1) = cuts.lines[0].vertices
    for part in parts:
        here = boundary_bubbles(part, problem.packing_spacing).x
        here = here[np.abs((x1 - x0) * (here[:, 1] - y0) - (y1 - y0) * (here[:, 0] - x0)) > 1e-9]  # beside the cut
        away = np.hypot(*(here[:, None] - there).transpose(2, 0, 1)).min(axis=1)
        assert away.max() < 0.02 * problem.survey.extremes.minimum


@pytest.mark.parametrize("parts", sweep(range(2, 8), quick=2))
def test_a_cut_passes_sharp_corners_by_also_where_it_runs_through_others(parts):
    """Mirrored corners lie on the same lines as bubbles elsewhere: no two nodes may come next to each other."""
    turn = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    radii = np.where(np.arange(96) // 2 % 2 == 0, 1.0, 0.8)
    ring = np.column_stack([radii * np.cos(turn), radii * np.sin(turn)]).tolist()
    result = mesh_case(case(f"domain: {{outer: {{polygon: {ring}}}}}\nspacing: 0.06\n", parts))
    check_mesh(result.mesh)
    assert result.report["quality"]["min"] > 0.5


def test_the_line_that_lands_best_is_found():
    """Against every line through two bubbles or one, whose crossings are counted one by one."""
    random = np.random.default_rng(3)
    for _ in range(20):
        walls = np.arange(4.0)  # upright, crossed at their height 0
        shift = random.uniform(0, 0.1, 4)
        x = np.array([(wall, k / 10 + off) for wall, off in zip(walls, shift, strict=True) for k in range(-5, 5)])
        crossings = np.column_stack([walls, np.zeros(4)])
        near = x[np.abs(x[:, 1]) <= 0.1]
        found = Landings(x, np.full(len(x), 0.1), np.full(len(x), 0.1)).near(
            np.zeros(2), np.array([1.0, 0.0]), crossings
        )

        def missed(at, slope, near=near, walls=walls):
            heights = at[1] + slope * (walls - at[0])
            off = [np.abs(near[near[:, 0] == wall, 1] - y).min() for wall, y in zip(walls, heights, strict=True)]
            return np.minimum(off, 0.05).sum()

        best = min(
            missed(a, slope)
            for a in near
            for slope in [0.0, *((b[1] - a[1]) / (b[0] - a[0]) for b in near if b[0] > a[0])]
            if abs(slope) < 0.05
        )
        assert missed(found.through[0], found.slope) == pytest.approx(best, abs=1e-9)
        assert 1 <= len(found.through) <= 4


@pytest.mark.parametrize(("size", "parts"), [("0.0335 + 0.0181", 4), ("0.0365 + 0.0199", 8)])
def test_cuts_on_both_sides_of_another_one_do_not_meet_it_at_nearly_the_same_place(size, parts):
    _, _, division = division_of(PERIODIC.replace("0.04 + 0.02", size), parts)
    x = division.boundary.corners
    apart = np.hypot(*(x[:, None] - x).transpose(2, 0, 1)) + np.eye(len(x))
    assert apart.min() > 1e-4


GRAIN = "regions: [{name: grain, ring: {circle: {center: [0.8, 0.5], radius: 0.25}}}]"
BORE = "holes: [{circle: {center: [0.29, 0.6], radius: 0.15}}]"


@pytest.mark.parametrize(
    ("width", "pairs", "inside", "size", "parts"),
    [
        (1.6, "[[l, r], [b, t]]", GRAIN, 0.034, 2),  # one cut, from a side to its counterpart, which lines turn
        (1.6, "[[l, r], [b, t]]", GRAIN, 0.054, 2),
        (0.72, "[[l, r]]", BORE, 0.04, 11),  # a cut in line with one behind others
        (0.72, "[[l, r]]", BORE, 0.052, 11),
    ],
)
def test_ends_of_cuts_on_periodic_sides_are_counterparts_of_each_other_or_well_apart(width, pairs, inside, size, parts):
    sides = f"{{rectangle: [0, 0, {width}, 1], labels: [b, r, t, l]}}"
    text = f"domain: {{outer: {sides}, periodic: {pairs}, {inside}}}\nspacing: {size}\n"
    problem, _, division = division_of(text, parts)
    on_side = (division.origin >= 0) & problem.domain.tied[division.origin]
    assert division.boundary.lengths[on_side].min() > 0.9 * size


def test_the_same_place_on_curved_periodic_sides_is_told_from_one_beside_it():
    """Chords of the arcs are some 1e-5 away from these, where cuts meet them obliquely."""
    problem = prepare(case(f"domain:\n  {MOONS.strip()}\n  periodic: [[left, right], [bottom, top]]\nspacing: 0.1\n"))
    left = np.array([0.5 * np.cos(0.4), 0.5 + 0.5 * np.sin(0.4)])
    tangent = np.array([-np.sin(0.4), np.cos(0.4)])
    across = np.array([[-0.1, -0.03], [0.1, 0.03]])
    sides = CutPeriodicSides.of(problem.domain, problem.packing_spacing).with_cut(left + across)
    right = left + np.array([2, 0]) + np.array([[-0.1, 0.02], [0.1, -0.02]])
    assert sides.apart(right) == np.inf
    assert sides.apart(right + 0.01 * tangent) == pytest.approx(0.1, rel=0.02)


@pytest.mark.long
def test_cuts_that_meet_periodic_sides_at_nearly_the_same_height_meet_them_at_the_same():
    """Else a side had two nodes there next to each other."""
    sides = "{rectangle: [0, 0, 1, 1], labels: [b, r, t, l]}"
    text = f"domain: {{outer: {sides}, periodic: [[l, r], [b, t]]}}\nspacing: 0.03791*(1 + 0.8*sin(6*y))\n"
    result = mesh_case(case(text, 8))
    check_mesh(result.mesh)
    assert result.report["quality"]["min"] > 0.6
