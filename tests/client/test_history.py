"""The older frames that are kept.

Never too many, never too close, and every frame is given back exactly once.
"""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.client import History
from hmdwarp.frames import Frame, Others

MS = 1_000_000
# Instants in the order in which frames are replaced: never backwards, now and then the same again.
INSTANTS = st.lists(st.integers(0, 60), max_size=40).map(
    lambda steps: [sum(steps[:n]) * MS for n in range(1, len(steps) + 1)]
)
KEEPS, SPACINGS = st.integers(0, 5), st.sampled_from([0, 1, 16 * MS, 100 * MS])


def frame(drawn_ns: int) -> Frame:
    return Frame((), drawn_ns, ())


@given(KEEPS, SPACINGS, KEEPS, INSTANTS)
def test_held_frames_keep_within_the_limits(keep, spacing_ns, recent, instants):
    history = History(Others(keep, spacing_ns, recent=recent), lambda _: None)
    for count, now in enumerate(instants, start=1):
        history.offer(frame(now))
        held = [frame.drawn_ns for frame in history.frames]
        assert len(held) <= keep
        assert held == sorted(held, reverse=True), "newest first"
        assert all(newer - older >= spacing_ns for newer, older in zip(held, held[1:], strict=False))
        assert keep == 0 or held[0] > now - max(spacing_ns, 1), (
            "the newest held one is no older than the spacing allows"
        )
        assert [frame.drawn_ns for frame in history.recent] == instants[:count][::-1][:recent]


@given(KEEPS, SPACINGS, KEEPS, INSTANTS)
def test_every_offered_frame_is_held_or_given_back_once(keep, spacing_ns, recent, instants):
    discarded: list[Frame] = []
    history = History(Others(keep, spacing_ns, recent=recent), discarded.append)
    offered = []
    for now in instants:
        offered.append(frame(now))
        history.offer(offered[-1])
        assert sorted({*map(id, [*discarded, *history.frames, *history.recent])}) == sorted(map(id, offered))
    history.close()
    assert history.frames == history.recent == ()
    assert sorted(map(id, discarded)) == sorted(map(id, offered))
    history.close()
    assert len(discarded) == len(offered), "closing twice gives nothing back twice"
