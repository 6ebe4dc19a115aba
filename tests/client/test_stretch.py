"""The directed fill.

Its twin, that foreground is never smeared, and what it leaves to the next one.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from holed import Holed
from reference.stretch import stretch

from hmdwarp.client import parse_fills
from hmdwarp.client.fills.plain import LEAST_PARALLAX
from hmdwarp.geometry import Pose, View

from .filled import filled
from .rendered_pictures import square_before_a_wall

# Two colours are stored truncated to half floats, 2^-10 each, of colours below 2; the means in
# between are float32.
TOLERANCE = 2 * 2 * 2.0**-10


@pytest.mark.parametrize(
    ("size", "empty"), [((67, 53), 0.5), ((64, 64), 0.2), ((31, 127), 0.7), ((129, 2), 0.5), ((19, 23), 1.0)], ids=str
)
@pytest.mark.parametrize("depthless", [False, True], ids=["depth", "some-depth"])
def test_it_equals_its_twin(gpu, size, empty, depthless):
    holed = Holed(gpu, 8, size, empty)
    if depthless:
        holed.inverse_depth[::2] = -1
    (choice,) = parse_fills("stretch")
    wanted = stretch(
        holed.colour, holed.inverse_depth, (holed.inputs.rendered.view, size), holed.inputs.shown, choice.settings,
        LEAST_PARALLAX,
    )  # fmt: skip
    got, depth = holed.fill(gpu, "stretch")
    decided = ~wanted.undecided
    assert decided.mean() > 0.85  # lines pass within a thousandth of a pixel of a corner or of another pixel
    assert np.array_equal(got[decided][:, 3], wanted.colour[decided][:, 3])
    assert np.abs(got - wanted.colour)[decided].max(initial=0) <= TOLERANCE
    assert np.abs(depth - wanted.inverse_depth)[decided].max(initial=0) <= 1e-5


@pytest.mark.parametrize("step", [(0.4, 0, 0), (-0.4, 0, 0), (0, 0.4, 0), (0.3, -0.3, 0), (0.25, 0.1, 0.3)], ids=str)
def test_foreground_is_never_smeared(gpu, step):
    """Red is the rendered inverse depth: 1 of the square, 0.25 of the wall.

    Of the square there is not a trace in what was hidden.
    """
    colour, depth = square_before_a_wall(np.s_[22:38, 22:38])
    before, after = filled(gpu, "search", "stretch", colour, depth, Pose(step))
    guessed = (before[..., 3] == 0) & (after[..., 3] == 1)
    assert guessed.sum() > 60
    assert np.abs(after[guessed][:, 0] - 0.25).max() <= TOLERANCE
    inner = np.s_[12:48, 12:48]
    assert (after[inner][..., 3] == 1).all()


def test_places_outside_the_rendered_view_stay_empty(gpu):
    colour, depth = square_before_a_wall(np.s_[20:40, 20:40])
    before, after = filled(gpu, "search", "stretch", colour, depth, Pose((0.4, 0, 0)))
    assert (before[:, 57:, 3] == 0).all()
    assert (after[:, 57:, 3] == 0).all()
    assert (filled(gpu, "search", "stretch+pyramid", colour, depth, Pose((0.4, 0, 0)))[1][..., 3] == 1).all()


def test_a_head_that_only_turned_hid_nothing(gpu):
    holed = Holed(gpu, 8, (67, 53), empty=0.3)
    turned = View(
        Pose(holed.inputs.rendered.view.pose.position_m, holed.inputs.shown.pose.orientation_xyzw),
        holed.inputs.shown.fov,
    )
    holed.inputs = attrs.evolve(holed.inputs, shown=turned)
    got, depth = holed.fill(gpu, "stretch")
    assert np.array_equal(got, holed.colour)
    assert np.array_equal(depth, holed.inverse_depth)
