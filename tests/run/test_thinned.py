"""A table of bounded size that stays evenly spaced, and the pauses of the garbage collector."""

from __future__ import annotations

import gc

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.poses import quaternions
from hmdwarp.run.ending import Pauses
from hmdwarp.run.frame_rows import angle_between
from hmdwarp.run.live_figures import Thinned


@given(count=st.integers(0, 3000), half=st.integers(1, 40))
def test_kept_rows_are_evenly_spaced(count, half):
    most = 2 * half
    table = Thinned(("number", "square"), most)
    for number in range(count):
        table.add((number, number * number))
    kept = table.column("number")
    assert kept.tolist() == list(range(0, count, table.every))
    assert table.column("square").tolist() == [number * number for number in kept]
    assert len(kept) <= most and (table.every == 1 or len(kept) > half) and (table.every & (table.every - 1)) == 0


def test_unmeasured_rows_are_left_out():
    table = Thinned(("a", "b"))
    for row in ((1, np.nan), (np.nan, np.nan), (2, 3)):
        table.add(row)
    assert table.measured("a", "b").tolist() == [1, 2, 3] and np.isnan(table.column("b")[:2]).all()


def test_pauses_are_those_between_start_and_stop():
    pauses = Pauses()
    gc.collect()
    pauses.start()
    try:
        gc.collect(0)
        gc.collect(0)
        gc.collect(2)
    finally:
        pauses.stop()
        pauses.stop()
    gc.collect()
    told = pauses.as_dict()
    assert (
        told["collections"][0] >= 2 and told["collections"][2] == 1
    )  # Python may find it is time for a young one by itself
    assert 0 < told["longest_ms"] <= told["total_ms"]


@given(st.lists(st.floats(-1, 1), min_size=8, max_size=8))
def test_the_angle_in_plain_floats_is_that_of_the_arrays(values):
    a, b = np.array(values[:4]) + (0, 0, 0, 1.5), np.array(values[4:]) + (0, 0, 0, 1.5)
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    # 4 atan2 of lengths that are off by a unit in the last place each: 1e-15 of an angle up to pi
    assert abs(angle_between(a.tolist(), (-b).tolist()) - quaternions.angle_between(a, b)) < 1e-14
