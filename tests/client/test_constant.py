"""The last step of a chain: its twin, and coverage 1 whatever comes in."""

from __future__ import annotations

import numpy as np
import pytest
from holed import Holed
from reference.constant import constant

# The mean is stored as a half float, truncated: 2^-10 of it. Sums in float32 of n terms are off by
# less than n 2^-24 of what they add up.
ROUNDED = 2.0**-10


@pytest.mark.parametrize("size", [(67, 53), (64, 64), (1, 7), (129, 2), (300, 211)], ids="{0[0]}x{0[1]}".format)
@pytest.mark.parametrize("empty", [0.01, 0.5, 0.999])
def test_it_equals_its_twin(gpu, size, empty):
    holed = Holed(gpu, 3, size, empty)
    got, wanted = holed.fill(gpu, "constant")[0], constant(holed.colour)
    largest = np.abs(holed.colour).max(initial=0)
    assert np.abs(got - wanted).max() <= largest * (ROUNDED + holed.colour.size * 2.0**-24)


def test_an_uncovered_picture_becomes_black(gpu):
    got = Holed(gpu, 3, (31, 17), empty=1.0).fill(gpu, "constant")[0]
    assert np.array_equal(got, np.broadcast_to([0.0, 0, 0, 1], got.shape))


def test_bright_colours_do_not_overflow(gpu):
    holed = Holed(gpu, 3, (300, 211), empty=0.3)
    covered = holed.colour[..., 3] > 0
    holed.colour[covered] = (60000, -60000, 10000, 1)
    got = holed.fill(gpu, "constant")[0]
    assert np.abs(got[~covered] - (60000, -60000, 10000, 1)).max() <= 60000 * ROUNDED
