"""Hard depth: holes of every kind, extremes, noise at pixel frequency, ties, coarse buffers."""

from __future__ import annotations

import numpy as np

import hmdwarp
from hmdwarp.client import parse_warp
from hmdwarp.frames.layers import PICTURE
from hmdwarp.geometry import DepthLayer, Pose, View, metres_from_inverse_depth

from .motions import SLANTED, stepped_depth
from .registry import hard_case
from .setting import HALF, SIZE, SQUARE, Setting, brings_more_pictures, is_warped_by_the_frame_alone, reads_depth

STEP = Pose((0.05, -0.02, 0.03))


def takes_a_picture(name: str) -> bool:
    """Whether the warp works on somebody's own RGB-D frame."""
    return set(parse_warp(name).entry.reads) <= set(PICTURE)


@hard_case(takes_a_picture)
def depth_holes_of_every_kind(gpu, name):
    """What: single pixels of 0, NaN, -1, -inf, 1e-40 m (a denormal inverse overflows) in somebody's
      depth picture, bright red colour
    Why: sensors deliver them; a filter or an average spreads them, a comparison with NaN is always
      false
    Wants: finite, counted as holes, and no red anywhere: what has no depth has no place
    """
    depth = metres_from_inverse_depth(SLANTED)
    colour = np.full((*depth.shape, 3), 0.25)
    for k, bad in enumerate((0.0, np.nan, -1.0, -np.inf, 1e-40)):
        depth[5 + 3 * k, 4::7], colour[5 + 3 * k, 4::7] = bad, (9.0, 0.25, 0.25)
    view = View(Pose(), SQUARE)
    for pose in (Pose(), STEP):
        out = hmdwarp.warp_image(colour, depth, view, View(pose, SQUARE), warp=name, gpu=gpu)
        assert np.isfinite(out.colour).all()
        assert out.colour[..., 0].max() <= 0.25 * (1 + 2 * HALF)
        assert set(np.unique(out.coverage)) <= {0, 1}
    assert out.hole_share > 0 or name in ("none", "shift", "similarity", "rotation", "planar")


@hard_case(reads_depth)
def depth_on_the_gpu_that_is_no_number(gpu, name):
    """What: NaN, +inf, -inf, -0.0, -1 and a denormal in the inverse-depth texture itself
    Why: a frame that comes straight from a renderer's memory has passed no check
    Wants: finite, only what float64 says is covered; no value spreads to its neighbours
    """
    depth = SLANTED.copy()
    for k, bad in enumerate((np.nan, np.inf, -np.inf, -1.0, 1e-40, -0.0)):
        depth[4 + 4 * k, 3::6] = bad
    list(Setting(gpu, depth, STEP).pictures(name))


@hard_case()
def nothing_has_depth(gpu, name):
    """What: not one pixel of the rendered picture has depth
    Why: medians, minima and pyramids of nothing
    Wants: nothing covered, nothing NaN
    """
    for picture in Setting(gpu, np.full(SIZE[::-1], -1.0), STEP).pictures(name):
        if name not in ("environment", "layered", "multi"):
            assert not picture.covered.any()


@hard_case()
def checkerboard_depth(gpu, name):
    """What: near and far alternate from pixel to pixel
    Why: no neighbour belongs to the same surface: every slope is a silhouette, every average a
      surface that does not exist
    Wants: what the float64 twin says; no colour that was not there
    """
    depth = np.where(np.add.outer(np.arange(SIZE[1]), np.arange(SIZE[0])) % 2, 1.0, 0.2)
    list(Setting(gpu, depth, STEP).pictures(name))


@hard_case()
def two_surfaces_at_equal_depth(gpu, name):
    """What: everything at one depth, seen from twice as far: four drawn pixels fall into each shown
      one with equal depth
    Why: what comes last wins, and on a GPU that changes from run to run
    Wants: the same winner in ten runs
    """
    setting = Setting(gpu, np.full(SIZE[::-1], 1.0), Pose((0, 0, 1.0)))
    first = setting.warp(gpu, name)
    assert all(np.array_equal(setting.warp(gpu, name), first) for _ in range(4))  # each runs it twice


@hard_case(reads_depth)
def sixteen_bit_depth(gpu, name):
    """What: depth from a 16-bit buffer with planes at 0.1 m and 100 m, a slanted surface
    Why: 2e-4 1/m steps make terraces: neighbouring pixels share a depth, then jump
    Wants: what the float64 twin says of it; as many pixels covered as with exact depth, to one in
      fifty
    """
    code = np.rint((1 / 0.1 - SLANTED) / (1 / 0.1 - 1 / 100) * 65535) / 65535
    coarse = DepthLayer(0, 1, 0.1, 100.0).inverse_depth(code)
    assert 0 < np.abs(coarse - SLANTED).max() < 1e-4
    exact, quantised = (list(Setting(gpu, depth, STEP).pictures(name)) for depth in (SLANTED, coarse))
    for a, b in zip(exact, quantised, strict=True):
        assert abs(a.covered.mean() - b.covered.mean()) <= 0.02


@hard_case(reads_depth)
def ill_conditioned_projection(gpu, name):
    """What: a float32 clip depth with near / far = 1e-6 (1 mm to 1 km), GL's -1..1, objects at 1 to
      4 m
    Why: 99.9 % of its values are spent on the first metre; unprojecting through the inverse matrix
      loses all digits
    Wants: depth right to 6e-5 1/m (half a float32 step of the buffer), and the picture of exact
      depth to what that moves
    """
    near, far = 1e-3, 1e3
    window = (1 / near - SLANTED) / (1 / near - 1 / far) * 2 - 1
    decoded = DepthLayer(-1, 1, near, far).inverse_depth(window.astype(np.float32))
    # One step of a float32 just below 1 is 2^-24; the buffer's 0..2 span 1000 1/m: half a step is
    # 1.5e-5, plus rounding of `window`.
    assert np.abs(decoded - SLANTED).max() <= 6e-5
    list(Setting(gpu, decoded, STEP).pictures(name))


@hard_case()
def one_pixel_before_the_sky(gpu, name):
    """What: a single near pixel before infinity, the head moves sideways
    Why: the thinnest thing there is: filters lose it, meshes stretch it to the horizon
    Wants: what the float64 twin says: it moves by its own parallax and drags nothing along
    """
    depth = np.zeros(SIZE[::-1])
    depth[13, 16] = 1.0
    colour = np.full((*depth.shape, 3), 0.25)
    colour[13, 16] = (4.0, 0.25, 0.25)
    for picture in Setting(gpu, depth, Pose((0.2, 0, 0)), colour=colour).pictures(name):
        if is_warped_by_the_frame_alone(name):
            bright = (picture.colour[..., 0] > 1) & picture.decided
            assert bright.sum() <= 4, "smeared"


@hard_case()
def silhouette_under_large_motion(gpu, name):
    """What: a near square before a far wall and sky, the head moves by 25 cm
    Why: the square uncovers a strip as wide as itself, and covers another
    Wants: what the float64 twin says; no mixture of square and wall anywhere
    """
    depth = stepped_depth()
    colour = np.zeros((*depth.shape, 3))
    colour[..., 1] = 1.0  # wall and sky: green
    colour[depth > 1] = (1.0, 0.0, 0.0)  # the square: red
    for picture in Setting(gpu, depth, Pose((0.25, 0.05, 0)), colour=colour).pictures(name):
        if name in (
            "forward",
            "forward_raster",
            "forward_ordered",
        ):  # copies; the others resample, and may mix within one pixel
            red, green = picture.colour[picture.decided][:, 0], picture.colour[picture.decided][:, 1]
            assert (np.minimum(red, green) == 0).all()


@hard_case(lambda name: is_warped_by_the_frame_alone(name) and not brings_more_pictures(name))
def silhouette_of_mixed_colours(gpu, name):
    """What: a red square before a blue wall; pixels along its silhouette are half red, half blue,
      with the depth of square and wall by turns, as antialiased frames have them
    Why: such a pixel belongs to both surfaces and moves with one
    Wants: what the float64 twin says; red and blue in shares that make 1, nothing else
    """
    square = stepped_depth() > 1
    rim = square & ~np.roll(square, 1, 0) | square & ~np.roll(square, 1, 1)
    depth = np.where(square, 1.25, 0.25)
    depth[rim] = np.where(np.arange(np.count_nonzero(rim)) % 2, 1.25, 0.25)
    red = np.where(rim, 0.5, square)
    colour = np.stack([red, 0 * red, 1 - red], axis=-1)
    for picture in Setting(gpu, depth, STEP, colour=colour).pictures(name):
        found = picture.colour[picture.decided & picture.covered]
        assert np.abs(found[:, 0] + found[:, 2] - 1).max(initial=0) <= 4 * HALF
        assert (found[:, 1] == 0).all()
