"""Hard pictures: sizes that fit no work group, light beyond any display."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hmdwarp.geometry import Pose

from .motions import SLANTED
from .registry import hard_case, twin_case
from .setting import SIZE, Setting, is_warped_by_the_frame_alone

STEP = Pose((0.05, -0.02, 0.03), (0.01, 0.02, 0, 1))


def of_size(size: tuple[int, int], shown: tuple[int, int] | None = None) -> Callable[..., Setting]:
    depth = 0.4 + np.add.outer(np.linspace(0, 0.2, size[1]), np.linspace(0, 0.3, size[0]))
    return lambda gpu: Setting(gpu, depth, STEP, shown_size=shown)


# No neighbours, no slope, a pyramid of one level.
twin_case("one_pixel", of_size((1, 1)))
# No neighbour on one axis; blocks of 2x2 do not exist.
twin_case("one_row_and_one_column", of_size((37, 1)), of_size((1, 37)))
# No tile, block or pyramid divides them.
twin_case("prime_sizes", of_size((31, 23), (37, 41)))
# More than one work group on one axis, a fraction of one on the other.
twin_case("wider_than_a_work_group", of_size((515, 3)), of_size((3, 515)))


@hard_case(
    "nothing brighter or darker than went in, no Inf; what is copied keeps its bits", is_warped_by_the_frame_alone
)
def light_of_ten_thousand_and_below_zero(gpu, name):
    """Sums overflow, weights cancel, fixed point saturates, a half float holds eleven bits."""
    colour = np.full((*SIZE[::-1], 3), 1e-4)
    colour[::3], colour[:, ::4] = 1e4, (-3.0, 0.5, 1e4)
    for pose in (Pose(), STEP):
        setting = Setting(gpu, SLANTED, pose, colour=colour)
        shader, *_ = setting.pictures(name)
        assert pose is STEP or np.array_equal(shader.colour, setting.colour)
