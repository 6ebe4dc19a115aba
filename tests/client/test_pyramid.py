"""The push-pull fill.

Its twin, whose colours and depths fill a hole, and numbers that are hard on half floats.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from holed import Holed
from reference._behind import Behind
from reference.pyramid import Chosen, pyramid

from hmdwarp.client import parse_fills
from hmdwarp.client.fills.pyramid import CRACK_BORDER, LEAST_BEYOND, LEAST_BORDER, LEAST_LOCAL, LOCAL_LEVELS


def wanted_of(holed: Holed, text: str = "pyramid") -> tuple[np.ndarray, np.ndarray]:
    (choice,) = parse_fills(text)
    settings = choice.settings
    chosen = Chosen(
        settings.holes, Behind(settings.tolerance, settings.floor), LOCAL_LEVELS, LEAST_LOCAL, LEAST_BORDER,
        LEAST_BEYOND, CRACK_BORDER, holed.inputs.middle, (holed.inputs.rendered.view, holed.size),
    )  # fmt: skip
    return pyramid(holed.colour, holed.inverse_depth, chosen)


def tolerance(holed: Holed) -> float:
    """Colours and weights are stored as half floats on the way up and down each level, truncated.

    2^-10 of the colour each time, and a weight that is off by as much moves a mean by at most twice
    that of the colours' spread, which may be twice the largest.
    """
    levels = math.ceil(math.log2(max(holed.size))) + 1
    return 2 * levels * 3 * np.abs(holed.colour).max(initial=0) * 2.0**-10


@pytest.mark.parametrize(
    ("size", "empty"),
    [((67, 53), 0.5), ((64, 64), 0.3), ((31, 127), 0.9), ((129, 2), 0.5), ((31, 17), 0.99), ((301, 40), 0.7)],
    ids=str,
)
@pytest.mark.parametrize("unknown", [1, 3, 0], ids=["no-depth", "some-depth", "depth"])
def test_it_equals_its_twin(gpu, size, empty, unknown):
    holed = Holed(gpu, 8, size, empty)
    wide = np.zeros(size[::-1], bool)
    wide[10:30, 8:50] = True
    holed.empty(wide)
    if unknown:
        holed.inverse_depth[::unknown] = -1
    holed.keep_one()
    got, depth = holed.fill(gpu, "pyramid")
    wanted, wanted_depth = wanted_of(holed)
    assert np.array_equal(got[..., 3], wanted[..., 3])
    assert np.abs(got - wanted).max() <= tolerance(holed)
    assert np.array_equal(depth < 0, wanted_depth < 0)
    assert np.abs(depth - wanted_depth).max() <= 1e-3  # weights are rounded as above, 2^-10 of depths of about 1


def test_without_a_floor_what_is_infinitely_far_is_one_surface(gpu):
    """Its depths differ by 0 of 0; a third of the picture is nearer."""
    text, holed = "pyramid:floor=0", Holed(gpu, 8, (31, 17), 0.5)
    holed.inverse_depth[(holed.inverse_depth >= 0) & (np.arange(31) % 3 > 0)] = 0
    got, depth = holed.fill(gpu, text)
    wanted, wanted_depth = wanted_of(holed, text)
    assert np.abs(got - wanted).max() <= tolerance(holed)
    assert np.abs(depth - wanted_depth).max() <= 1e-3


def test_a_crack_in_what_is_near_stays_near(gpu):
    """One pixel wide, beside a far surface a few pixels away.

    What shows through a crack is no hole's background.
    """
    holed = Holed(gpu, 1, (64, 64), empty=0)
    holed.colour[:], holed.inverse_depth[:] = (1, 0, 0, 1), 1.0
    holed.colour[:, 40:], holed.inverse_depth[:, 40:] = (0, 1, 0, 1), 0.25
    crack = np.zeros((64, 64), bool)
    crack[:, 8:30:3] = True
    holed.empty(crack)
    got, depth = holed.fill(gpu, "pyramid")
    assert np.abs(got[crack] - (1, 0, 0, 1)).max() <= 2.0**-8
    assert np.abs(depth[crack] - 1).max() <= 1e-3


def test_a_glimpse_of_the_sky_is_no_background_for_a_wide_hole_elsewhere(gpu):
    """A wall at 4 m, half the picture a hole; far to the right a window, its sky full of cracks.

    No sky in the hole.
    """
    holed = Holed(gpu, 1, (512, 256), empty=0)
    holed.colour[:], holed.inverse_depth[:] = (0, 1, 0, 1), 0.25
    sky, lost, hole = np.s_[20:240, 360:500], np.s_[30:230, 370:490:3], np.s_[:, :256]
    holed.colour[sky], holed.inverse_depth[sky] = (0, 0, 1, 1), 0.0
    for part in (lost, hole):
        holed.colour[part], holed.inverse_depth[part] = 0, -1
    got, depth = holed.fill(gpu, "pyramid")
    assert got[hole][..., 2].max() < 0.05
    assert np.abs(depth[hole] - 0.25).max() < 0.01
    assert got[lost][..., 2].min() > 0.95


def test_bright_and_negative_colours_stay_between_what_they_are_made_of(gpu):
    holed = Holed(gpu, 1, (67, 53), empty=0.6)
    bright = holed.world.rng.uniform(size=(53, 67)) < 0.5
    covered = holed.colour[..., 3] > 0
    holed.colour[covered & bright, :3], holed.colour[covered & ~bright, :3] = 6e4, -6e4
    holed.colour = holed.colour.astype(np.float16).astype(np.float64)
    got = holed.fill(gpu, "pyramid")[0]
    assert np.isfinite(got).all()
    assert np.abs(got[..., :3]).max() <= 6e4
    assert np.abs(got - wanted_of(holed)[0]).max() <= tolerance(holed)
