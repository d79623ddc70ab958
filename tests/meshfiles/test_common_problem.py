"""One problem with two materials and a curved interface: all solvers that are installed answer alike."""

import pytest

from benchmarks.solvers.__main__ import EXACT, periodic_sides, solved
from benchmarks.solvers.programs import SOLVERS, NotInstalledError

pytestmark = pytest.mark.solver


@pytest.mark.parametrize(("name", "order"), [(name, order) for name in SOLVERS for order in SOLVERS[name].orders])
def test_the_mean_on_the_bore(name, order):
    solver = SOLVERS[name]
    try:
        found, labels, regions = solved(name, solver, order)
    except NotInstalledError as missing:
        pytest.skip(f"{missing} is not installed, so that its answer is not compared")
    assert (labels, regions) == (True, True)
    # The polygon of the bore is shorter than its circle, which curved triangles follow.
    assert found.mean == pytest.approx(EXACT, rel=2e-5 if order == 2 and solver.second == "yes" else solver.close)


@pytest.mark.parametrize("name", SOLVERS)
def test_periodic_sides_are_joined(name):
    try:
        assert periodic_sides(name, SOLVERS[name]) == SOLVERS[name].periodic.way
    except NotInstalledError as missing:
        pytest.skip(f"{missing} is not installed, so that its periodic sides are not tried")


def test_every_solver_is_a_target():
    from bubblemesh.meshfiles.formats import FORMATS_FOR

    assert set(SOLVERS) <= set(FORMATS_FOR)
