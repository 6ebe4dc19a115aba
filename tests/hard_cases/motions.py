"""Hard head motions: none, tiny, through, beside and behind things; extreme fields of view."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hmdwarp.geometry import Fov, Pose, View

from .registry import TWIN, hard_case, knows_one_depth, twin_case
from .setting import HALF, SIZE, SQUARE, Setting, brings_more_pictures, is_warped_by_the_frame_alone, reads_depth

SLANTED = 0.4 + np.add.outer(
    np.linspace(0, 0.2, SIZE[1]), np.linspace(0, 0.3, SIZE[0])
)  # 1/m: one plane, 1 to 2.5 m away


def turned(axis: tuple[float, float, float], degrees: float, position=(0, 0, 0)) -> Pose:
    """A head turned about an axis."""
    half = math.radians(degrees) / 2
    direction = np.array(axis, float) / np.linalg.norm(axis)
    return Pose(position, (*(math.sin(half) * direction), math.cos(half)))


def stepped_depth() -> np.ndarray:
    """A near square before a far wall, some sky."""
    depth = np.full(SIZE[::-1], 0.25)
    depth[8:18, 10:20] = 1.25
    depth[:, 28:] = 0
    return depth


@hard_case("every colour bit for bit, coverage 1", is_warped_by_the_frame_alone)
def identity(gpu, name):
    """A map that is off by one part in ten million samples beside the pixel centre."""
    setting = Setting(gpu, stepped_depth(), Pose())
    for picture in setting.pictures(name):
        tolerance = 0 if picture.maker == "shader" else 1e-9
        assert picture.covered[picture.decided].all()
        assert (np.abs(picture.colour - setting.colour)[picture.decided] <= tolerance).all()


UNMOVED = "no hole, no speckle: the rendered picture, to the rounding of a half float"


def _as_good_as_still(gpu, name, pose: Pose) -> None:
    setting = Setting(gpu, stepped_depth(), pose)
    for picture in setting.pictures(name):
        assert picture.covered[picture.decided].all(), "a hole"
        # 1e-9 of 16 pixels a tangent at 1.25 1/m is far below the sampler's own error; bilinear
        # looks change by that times the contrast.
        error = np.abs(picture.colour - setting.colour)[picture.decided].max(initial=0)
        assert error <= 4 * HALF + 4 * (setting.sampler_pixels + 1e-6), "speckle"


@hard_case(UNMOVED, is_warped_by_the_frame_alone)
def motion_of_a_nanometre(gpu, name):
    """What is not exactly still takes the general path, where rounding may open cracks or flip
    pixels at edges."""
    _as_good_as_still(gpu, name, Pose((1e-9, -1e-9, 1e-9)))


@hard_case(UNMOVED, is_warped_by_the_frame_alone)
def turn_of_a_nanoradian(gpu, name):
    """Sin and cos of it are 0 and 1 in float32; made from quaternions the angle may vanish or
    double."""
    _as_good_as_still(gpu, name, turned((1, 1, 1), math.degrees(1e-9)))


@hard_case("nothing of the rows behind the eye anywhere; what is before it where it belongs", reads_depth)
def points_at_and_behind_the_eye(gpu, name):
    """W goes through 0: dividing by it mirrors and smears what is behind across the whole
    picture."""
    near = np.full(SIZE[::-1], 0.5)
    near[10:17] = np.array([0.9, 1 - 2**-20, 1.0, 1 + 2**-20, 1.1, 2.0, 100.0])[:, None]  # 1/m, the eye ends at 1 m
    colour = np.full((*SIZE[::-1], 3), 0.25)
    colour[12:17] = (4.0, 0.25, 0.25)  # at and behind the eye: red
    setting = Setting(gpu, near, Pose((0, 0, -1)), colour=colour)
    for picture in setting.pictures(name):
        # backward without its test knows none of the rendered picture's depth; what is stretched
        # mixes what is before the eye with what is not
        others = name in ("backward:test=off", "mesh:grid=64") or knows_one_depth(name)
        if not others and not brings_more_pictures(name):
            assert (picture.colour[picture.decided][:, 0] <= 0.25 * (1 + 2 * HALF)).all()


# The border of the rendered picture meets that of the shown one; w is 0 along a line.
twin_case(
    "turn_by_90_degrees",
    lambda gpu: Setting(gpu, stepped_depth(), turned((0, 1, 0), 90)),
    wants=f"{TWIN}, no NaN along the line",
)


@hard_case("nothing covered (`none` shows the rendered picture, `environment` what is behind)")
def turn_by_180_degrees(gpu, name):
    """All that was rendered is behind the eye; a homography still has an answer, upside down."""
    for picture in Setting(gpu, stepped_depth(), turned((0.3, 1, 0.1), 180)).pictures(name):
        if is_warped_by_the_frame_alone(name) and name != "none":
            assert not picture.covered[picture.decided].any(), "where that is meant, name the warp here"


@hard_case("the rendered picture bit for bit: infinity does not move", is_warped_by_the_frame_alone)
def sky_under_translation(gpu, name):
    """As metres that is inf, and inf times 0 is NaN."""
    setting = Setting(gpu, np.zeros(SIZE[::-1]), Pose((0.3, -0.2, 0.25)))
    for picture in setting.pictures(name):
        assert picture.covered[picture.decided].all()
        # Only a head that does not move at all is sampled without a filter: a bilinear look
        # misses the centre by the sampler's error.
        error = np.abs(picture.colour - setting.colour)[picture.decided].max(initial=0)
        assert error <= HALF + 4 * setting.sampler_pixels


# Nine orders of magnitude in one float32 map; a depth buffer with planes keeps one end only.
ENDS = np.where(np.arange(SIZE[0]) % 3, 1e-6, 1e3) * np.ones((SIZE[1], 1))  # 1/m
twin_case(
    "a_thousandth_and_a_million_metres",
    lambda gpu: Setting(gpu, ENDS, Pose((1e-4, 0, -5e-5))),
    wants=f"{TWIN} at both ends",
)


@hard_case("the picture made beside the origin, bit for bit")
def a_million_metres_from_the_origin(gpu, name):
    """Float32 world coordinates are 6 cm coarse there, and even a float64 matrix through the origin
    loses ten digits."""
    step, far = np.array([2.0**-10, 0, -(2.0**-9)]), np.array([2.0**20, -(2.0**20), 2.0**20])
    here = Setting(gpu, stepped_depth(), Pose(step))
    there = Setting(gpu, stepped_depth(), Pose(far + step), rendered=Pose(far))
    for near, distant in zip(here.pictures(name), there.pictures(name), strict=True):
        both = near.decided & distant.decided
        assert (np.abs(near.colour - distant.colour)[both] <= (0 if near.maker == "shader" else 1e-9)).all()


@hard_case("what the float64 twin says; the neighbourhood of the epipole stays covered")
def epipole_inside_the_picture(gpu, name):
    """Around it the epipolar directions turn through all angles and parallax vanishes."""
    _towards_the_epipole(gpu, name, Pose((0.013, 0.021, -0.2)))


@hard_case("what the float64 twin says; the pixel itself is covered and keeps its colour")
def epipole_at_a_pixel_centre(gpu, name):
    """The epipolar direction of that pixel is 0 / 0."""
    _towards_the_epipole(gpu, name, Pose((0, 0, -0.2)))


def _towards_the_epipole(gpu, name, pose: Pose) -> None:
    setting = Setting(gpu, SLANTED, pose)
    middle = np.s_[SIZE[1] // 2, SIZE[0] // 2]
    for picture in setting.pictures(name):
        if picture.decided[middle]:
            assert picture.covered[middle]


@hard_case("what the float64 twin says; gather, mesh and splat warps leave no crack")
def forward_motion(gpu, name):
    """Every pixel grows: scattered points come apart."""
    setting = Setting(gpu, SLANTED, Pose((0, 0, -0.3)))
    for picture in setting.pictures(name):
        if not name.startswith("forward") and name not in ("layered", "multi"):
            inner = np.s_[4:-4, 4:-4]
            assert (picture.covered | ~picture.decided)[inner].all(), "a crack"


@hard_case("what the float64 twin says; the middle is covered")
def backward_motion(gpu, name):
    """Several drawn pixels share a shown one, and the border of what was drawn moves in."""
    setting = Setting(gpu, SLANTED, Pose((0, 0, 0.3)))
    for picture in setting.pictures(name):
        assert (picture.covered | ~picture.decided)[SIZE[1] // 2, SIZE[0] // 2]


@hard_case("what the float64 twin says; depth makes no difference to a gather")
def zero_baseline(gpu, name):
    """E is 0: the epipole is undefined, and an epipolar search has no direction to go."""
    pose = turned((0.2, 1, -0.4), 7)
    for near, far in zip(
        Setting(gpu, SLANTED, pose).pictures(name), Setting(gpu, SLANTED / 8, pose).pictures(name), strict=True
    ):
        if knows_one_depth(name):
            assert np.abs(near.colour - far.colour)[near.decided & far.decided].max(initial=0) <= HALF + 4e-5


def through(fov: Fov, *head) -> Callable[..., Setting]:
    """A slanted plane through a field of view, seen by a head that is `turned`."""
    return lambda gpu: Setting(gpu, SLANTED, View(turned(*head), fov), rendered=View(Pose(), fov))


def wide(degrees: float) -> Fov:
    return Fov.symmetric(math.radians(degrees), math.radians(degrees))


# Tangents of 0.009 are differences of nearly equal numbers; one pixel is half a milliradian.
twin_case("field_of_view_of_1_degree", through(wide(1), (0, 1, 0), 0.2, (0.002, 0, 0)))
# Pixels at the edge see four times less of an angle than those in the middle.
twin_case("field_of_view_of_120_degrees", through(wide(120), (1, 1, 0), 9, (0.05, 0, 0.05)))
# Tangents of 11.4: much of the rendered picture ends up beside and behind the shown eye, w passes 0
# inside the picture.
twin_case(
    "field_of_view_of_170_degrees",
    through(wide(170), (0, 1, 0.2), 20, (0.02, 0.01, 0)),
    wants=f"{TWIN}, nothing mirrored",
)
# The axis lies in a corner: formulas fail that assume it in the middle, or one scale on both axes.
corner = Fov(*np.deg2rad([-5, 80, -70, 10]))
twin_case("strongly_asymmetric_field_of_view", through(corner, (1, -1, 0.5), 5, (0.04, -0.02, 0.03)))
# The axis lies outside the picture, as in tiled displays; the principal point is at negative pixels
tile = Fov(*np.deg2rad([10, 55, 5, 40]))
twin_case("view_that_does_not_hold_its_axis", through(tile, (1, 0.5, 0), 4, (0.03, 0.02, -0.03)))


@hard_case("the same picture bit for bit")
def q_and_minus_q(gpu, name):
    """Both are the same rotation; what interpolates or compares components sees two."""
    q = np.array(turned((0.3, 1, 0.1), 6).orientation_xyzw)
    pictures = [Setting(gpu, SLANTED, Pose((0.02, 0, 0.01), sign * q)).warp(gpu, name) for sign in (1, -1)]
    assert np.array_equal(*pictures)


@hard_case("the picture of the unit quaternion, to the last bits of the map")
def unnormalised_quaternion(gpu, name):
    """Trackers and files deliver them; as a matrix they scale the picture."""
    q = np.array(turned((0.3, 1, 0.1), 6).orientation_xyzw)
    unit, *scaled = (
        list(Setting(gpu, SLANTED, Pose((0.02, 0, 0.01), scale * q)).pictures(name)) for scale in (1, 1e-3, 1e3)
    )
    for pictures in scaled:
        for picture, wanted in zip(pictures, unit, strict=True):
            same = np.abs(picture.colour - wanted.colour).max(axis=-1) <= 4 * HALF
            assert same[picture.decided & wanted.decided].mean() > 0.99  # a last bit decides at a border


assert SQUARE.tangents[1] == np.tan(np.pi / 4)  # the cases above count on 90 degrees
