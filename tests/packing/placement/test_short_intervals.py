import numpy as np
import pytest
from domains_and_spacings import DOMAINS, SPACINGS

from bubblemesh.spacing.rules.sources import LONGEST, short_intervals
from bubblemesh.spacing.spacing import Spacing


@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("domain", DOMAINS)
def test_intervals_cover_each_piece_and_are_short(domain, spacing):
    domain, spacing = DOMAINS[domain], Spacing(SPACINGS[spacing])
    boundary = domain.boundary
    piece, begin, length = short_intervals(domain, spacing)
    assert set(piece.tolist()) == set(range(len(boundary.lengths)))
    for k, whole in enumerate(boundary.lengths):
        mine = piece == k
        assert begin[mine][0] == 0
        np.testing.assert_allclose(np.cumsum(length[mine]), np.append(begin[mine][1:], whole), rtol=1e-12)
    for share in (0, 0.5, 1):
        assert (length <= LONGEST * spacing(boundary.points(piece, begin + share * length))).all()
