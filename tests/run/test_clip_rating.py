"""Which refreshes a clip before an instant has."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.run.combinations import instants_of
from hmdwarp.run.side_by_side import clips_before


@given(st.integers(1, 500), st.integers(1, 40), st.integers(2, 60))
def test_each_instant_ends_one_clip_of_neighbours_and_no_refresh_is_in_two(count, wanted, length):
    instants = instants_of(count, wanted)
    ends = clips_before(instants, length)
    clips = {end: [number for number in ends if ends[number] == end] for end in instants}
    for before, end in zip((-1, *instants), instants, strict=False):
        # As long as asked for, unless the run begins or the instant before lies within.
        assert clips[end] == list(range(end + 1))[-min(length, end - before) :]
        assert len(clips[end]) >= min(2, count)  # one picture is no clip


def test_clips_reach_back_from_their_instants():
    assert clips_before([2, 9], 4) == {0: 2, 1: 2, 2: 2, 6: 9, 7: 9, 8: 9, 9: 9}
    assert clips_before([2, 4], 4) == {0: 2, 1: 2, 2: 2, 3: 4, 4: 4}
