"""Hard pictures: sizes that fit no work group, light beyond any display."""

from __future__ import annotations

import numpy as np

from hmdwarp.geometry import Pose

from .motions import SLANTED
from .registry import hard_case
from .setting import SIZE, Setting, is_warped_by_the_frame_alone

STEP = Pose((0.05, -0.02, 0.03), (0.01, 0.02, 0, 1))


def _of_size(gpu, name, size: tuple[int, int], shown: tuple[int, int] | None = None) -> None:
    depth = 0.4 + np.add.outer(np.linspace(0, 0.2, size[1]), np.linspace(0, 0.3, size[0]))
    list(Setting(gpu, depth, STEP, shown_size=shown).pictures(name))


@hard_case()
def one_pixel(gpu, name):
    """What: rendered and shown pictures of 1x1
    Why: no neighbours, no slope, a pyramid of one level
    Wants: what the float64 twin says
    """
    _of_size(gpu, name, (1, 1))


@hard_case()
def one_row_and_one_column(gpu, name):
    """What: pictures of 37x1 and 1x37
    Why: no neighbour on one axis; blocks of 2x2 do not exist
    Wants: what the float64 twin says
    """
    _of_size(gpu, name, (37, 1))
    _of_size(gpu, name, (1, 37))


@hard_case()
def prime_sizes(gpu, name):
    """What: a rendered picture of 31x23, shown at 37x41
    Why: no tile, block or pyramid divides them
    Wants: what the float64 twin says
    """
    _of_size(gpu, name, (31, 23), (37, 41))


@hard_case()
def wider_than_a_work_group(gpu, name):
    """What: pictures of 515x3 and 3x515
    Why: more than one work group on one axis, a fraction of one on the other
    Wants: what the float64 twin says
    """
    _of_size(gpu, name, (515, 3))
    _of_size(gpu, name, (3, 515))


@hard_case(is_warped_by_the_frame_alone)
def light_of_ten_thousand_and_below_zero(gpu, name):
    """What: colours of 1e4, of -3 (out of gamut) and of 1e-4 side by side
    Why: sums overflow, weights cancel, fixed point saturates, a half float holds eleven bits
    Wants: nothing brighter or darker than went in, no Inf; what is copied keeps its bits
    """
    colour = np.full((*SIZE[::-1], 3), 1e-4)
    colour[::3], colour[:, ::4] = 1e4, (-3.0, 0.5, 1e4)
    for pose in (Pose(), STEP):
        setting = Setting(gpu, SLANTED, pose, colour=colour)
        for picture in setting.pictures(name):
            if pose is STEP:
                continue
            assert (
                np.array_equal(picture.colour[picture.decided], setting.colour[picture.decided])
                or picture.maker == "twin"
            )
