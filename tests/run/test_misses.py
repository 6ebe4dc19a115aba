"""What missed refreshes cost."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.run.misses import MissTally


@given(st.lists(st.booleans(), min_size=1), st.floats(0, 90))
def test_the_figures_of_a_head_that_is_always_as_far_off(stale, off):
    tally = MissTally()
    for one in stale:
        tally.add(one, off)
    figures = tally.as_dict()
    assert figures["stale_share"] * len(stale) == pytest.approx(stale.count(True))
    assert figures["longest_stale"] <= stale.count(True)
    assert figures["judder_deg"] == 0
