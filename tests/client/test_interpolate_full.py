"""The repeated 3x3 median fill: its twin, what small means, and that it ends by itself."""

from __future__ import annotations

import numpy as np
import pytest
from holed import Holed
from reference.interpolate import interpolate_full

from hmdwarp.client import parse_fills
from hmdwarp.client.fills.interpolate import minimum_count
from hmdwarp.errors import InputError


def with_a_hole(gpu, size: tuple[int, int], hole: tuple[slice, slice], empty: float = 0.0) -> Holed:
    holed = Holed(gpu, 4, size, empty)
    mask = np.zeros(size[::-1], bool)
    mask[hole] = True
    holed.empty(mask)
    return holed


@pytest.mark.parametrize("reach", [1, 2, 5, 16])
@pytest.mark.parametrize("size", [(67, 53), (31, 127), (129, 2)], ids="{0[0]}x{0[1]}".format)
def test_it_equals_its_twin(gpu, size, reach):
    holed = with_a_hole(gpu, size, np.s_[5:40, 10:60], empty=0.5)
    got = holed.fill(gpu, f"interpolate_full:reach={reach}")[0]
    wanted = interpolate_full(holed.colour, minimum_count(3), reach)
    assert np.array_equal(got[..., 3], wanted[..., 3])
    # Each pass truncates to a half float: 2^-10 of a colour below 2. A median moves by no more than
    # what it is taken of.
    assert np.abs(got - wanted).max() <= reach * 2 * 2.0**-10


def test_a_hole_twice_as_wide_as_the_reach_is_closed_and_a_wider_one_gets_a_rim(gpu):
    for width, left in ((32, 0), (36, 4)):
        holed = with_a_hole(gpu, (80, 60), np.s_[:, 20 : 20 + width])
        empty = holed.fill(gpu, "interpolate_full")[0][..., 3] == 0
        assert (empty[20:40].sum(axis=1) == left).all()  # at the picture's ends there is less to grow from


def test_it_goes_on_as_long_as_anything_changes_and_no_longer(gpu):
    """The result no longer depends on the reach once nothing changes, whichever of the two pictures
    was written last.
    """
    holed = with_a_hole(gpu, (67, 53), np.s_[20:30, 30:41], empty=0.4)
    enough, more = (holed.fill(gpu, f"interpolate_full:reach={reach}")[0] for reach in (40, 41))
    assert np.array_equal(enough, more)
    assert (enough[..., 3] == 1).all()


def test_lone_pixels_grow_nothing(gpu):
    """One covered pixel is no neighbourhood of three.

    It ends after one pass, with the picture as it was.
    """
    holed = Holed(gpu, 4, (40, 40), empty=1.0)
    holed.colour[::4, ::4] = (0.5, 0.25, 1, 1)
    assert np.array_equal(holed.fill(gpu, "interpolate_full")[0], holed.colour)


def test_bright_and_negative_colours_stay_between_their_neighbours(gpu):
    holed = with_a_hole(gpu, (67, 53), np.s_[20:30, 30:41])
    holed.colour[..., :3] *= np.where(holed.world.rng.uniform(size=(53, 67, 1)) < 0.5, 1e4, -1e4)
    holed.colour = holed.colour.astype(np.float16).astype(np.float64)
    got = holed.fill(gpu, "interpolate_full")[0]
    assert np.isfinite(got).all()
    assert np.abs(got[20:30, 30:41, :3]).max() <= np.abs(holed.colour[..., :3]).max()


def test_settings_out_of_range_are_refused():
    for text in ("interpolate_full:reach=0", "interpolate_full:reach=5000"):
        with pytest.raises(InputError, match="expected 1 to 1024"):
            parse_fills(text)
