import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bubblemesh.arrays import members


@given(st.lists(st.integers(0, 5)))
def test_members_of_groups_one_after_the_other(counts):
    group, rank = members(np.array(counts, np.int64))
    assert list(zip(group, rank, strict=True)) == [(k, r) for k, count in enumerate(counts) for r in range(count)]
