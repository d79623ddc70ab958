from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from domains_and_spacings import DOMAINS, SPACINGS, SQUARE
from lattices import uniform
from scipy.integrate import quad

from bubblemesh.geometry import rings
from bubblemesh.geometry.domain import Domain, Held
from bubblemesh.packing.placement.diffusion import equidistributed
from bubblemesh.spacing.spacing import Spacing


def integral(domain, spacing, piece, begin, end):
    """Integral of ds / d by adaptive quadrature, a few parts at a time."""

    def over(s):
        point = domain.boundary.points(np.array([piece]), domain.boundary.wrapped(np.array([piece]), np.array([s])))
        return 1 / float(spacing(point)[0])

    cuts = np.linspace(begin, end, 5)
    return sum(quad(over, a, b, epsrel=1e-7, limit=200)[0] for a, b in pairwise(cuts))


def placed(domain, piece, s):
    """Arc lengths at which the intervals of each piece begin and end, by piece."""
    boundary = domain.boundary
    for k, length in enumerate(boundary.lengths):
        mine = s[piece == k]
        yield k, np.append(mine, mine[:1] + length) if boundary.closed[k] else np.concatenate([[0.0], mine, [length]])


@pytest.mark.long
@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("domain", DOMAINS)
def test_intervals_are_equal_parts_of_the_integral(domain, spacing):
    domain, spacing = DOMAINS[domain], Spacing(SPACINGS[spacing])
    for piece, ends in placed(domain, *equidistributed(domain, spacing)):
        assert (np.diff(ends) > 0).all()
        parts = [integral(domain, spacing, piece, a, b) for a, b in pairwise(ends)]
        np.testing.assert_allclose(parts, np.mean(parts), rtol=0.02)
        assert abs(len(parts) - sum(parts)) < 0.5 + 1e-3 * sum(parts)


def test_uniform_spacing_gives_equal_lengths():
    for name, domain in DOMAINS.items():
        for piece, ends in placed(domain, *equidistributed(domain, uniform(0.11))):
            length = domain.boundary.lengths[piece]
            np.testing.assert_allclose(np.diff(ends), length / round(length / 0.11), rtol=1e-9, err_msg=name)


@pytest.mark.parametrize(("d", "intervals"), [(0.3, 7), (2 / 7.4, 7), (2 / 7.6, 8), (1.1, 2), (1.4, 1), (50.0, 1)])
def test_number_of_intervals_is_the_rounded_integral_and_at_least_one(d, intervals):
    piece, s = equidistributed(SQUARE, uniform(d))
    assert np.bincount(piece, minlength=4).tolist() == [intervals - 1] * 4
    assert s.shape == piece.shape


@pytest.mark.parametrize(
    ("d", "intervals"), [(2 / 90.4, 92), (2 / 46.2, 46), (2 / 23.4, 23), (2 / 191, 192), (50.0, 1)]
)
def test_numbers_that_are_halved_again_and_again_leave_twelve_intervals_or_more(d, intervals):
    piece, s = equidistributed(SQUARE, uniform(d), np.array([True, False, True, False]))
    found = np.bincount(piece, minlength=4) + 1
    assert found.tolist() == [intervals, max(round(2 / d), 1)] * 2
    np.testing.assert_allclose(s[piece == 0], 2 * np.arange(1, intervals) / intervals, rtol=1e-9)


@pytest.mark.parametrize(
    ("number", "d", "step"),
    [(8, 0.2, 1), (8, 0.25, 1), (8, 0.32, 1), (8, 0.4, 2), (8, 0.7, 2), (8, 0.8, 4), (9, 0.25, 1), (9, 0.5, 0)],
)
def test_coarser_spacings_take_every_second_or_fourth_of_the_bubbles_that_are_held(number, d, step):
    inner = 2 * (np.arange(1, number) / number) ** 1.1
    held = Held(np.array([0, 1]), np.repeat([0, 1], number - 1), np.append(inner, inner))
    piece, s = equidistributed(replace(SQUARE, held=held), uniform(d))
    rows = round(2 / d)
    expected = inner[step - 1 :: step] if step else 2 * np.arange(1, rows) / rows
    for side in (0, 1):
        np.testing.assert_allclose(s[piece == side], expected, rtol=1e-9)
    np.testing.assert_allclose(s[piece == 2], 2 * np.arange(1, rows) / rows, rtol=1e-9)


@pytest.mark.parametrize(("d", "intervals"), [(0.1, 63), (1.0, 6), (2.0, 3), (3.0, 3), (1e6, 3)])
def test_closed_curve_has_at_least_three_bubbles_and_begins_with_one(d, intervals):
    domain = Domain.of(rings.circle((0, 0), 1))
    piece, s = equidistributed(domain, uniform(d))
    assert piece.tolist() == [0] * intervals
    np.testing.assert_allclose(s, 2 * np.pi * np.arange(intervals) / intervals, atol=1e-9)


def test_corners_have_no_bubble_of_the_pieces():
    for spacing in SPACINGS.values():
        piece, s = equidistributed(SQUARE, Spacing(spacing))
        x = SQUARE.boundary.points(piece, s)
        assert np.hypot(*(x[:, None] - SQUARE.boundary.corners).transpose(2, 0, 1)).min() > 0.003


def test_pieces_and_arc_lengths_ascend():
    for domain in DOMAINS.values():
        piece, s = equidistributed(domain, Spacing(SPACINGS["linear"]))
        assert (np.lexsort((s, piece)) == np.arange(len(s))).all()


@pytest.mark.parametrize("sharpness", [1e-3, 1e-4])
def test_spacing_that_varies_a_thousandfold(sharpness):
    spacing = Spacing(lambda x, y: sharpness + 0.5 * np.hypot(x - 1 / 3, y))
    piece, s = equidistributed(SQUARE, spacing)
    for k, ends in placed(SQUARE, piece, s):
        middle = SQUARE.boundary.points(np.full(len(ends) - 1, k), (ends[:-1] + ends[1:]) / 2)
        ratio = np.diff(ends) / spacing(middle)
        assert ratio.min() > 0.8
        assert ratio.max() < 1.25
    assert spacing(SQUARE.boundary.points(piece, s)).max() / np.diff(s[piece == 0]).min() > 0.5 / sharpness


def test_many_pieces_do_not_lend_each_other_bubbles():
    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    domain = Domain.of(rings.polygon(np.column_stack([np.cos(angle), np.sin(angle)])))
    side = domain.boundary.lengths[0]
    for parts in (1, 2, 3, 7):
        piece, s = equidistributed(domain, uniform(side / parts))
        assert np.bincount(piece, minlength=300).tolist() == [parts - 1] * 300
        np.testing.assert_allclose(s, np.tile(np.arange(1, parts), 300) * side / parts, rtol=1e-6)


@pytest.mark.parametrize("scale", [2.0**-40, 2.0**40])
def test_distribution_does_not_depend_on_the_unit_of_length(scale):
    function = SPACINGS["waves"]
    piece, s = equidistributed(SQUARE, Spacing(function))
    large = Domain.of(rings.rectangle(0, 0, 2 * scale, 2 * scale))
    scaled_piece, scaled_s = equidistributed(large, Spacing(lambda x, y: scale * function(x / scale, y / scale)))
    np.testing.assert_array_equal(scaled_piece, piece)
    np.testing.assert_allclose(scaled_s / scale, s, rtol=1e-12)
