"""A mesh with regions, lines and points for the tests."""

import pytest
from sandwiches import ODD, sandwich


@pytest.fixture(scope="module", params=["plain", "odd"])
def mesh(request):
    return sandwich() if request.param == "plain" else sandwich(ODD, ("domain", "on"))
