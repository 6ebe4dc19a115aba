"""Hard depth: holes of every kind, extremes, noise at pixel frequency, ties, coarse buffers."""

from __future__ import annotations

import numpy as np

import hmdwarp
from hmdwarp.client import parse_warp
from hmdwarp.frames.layers import PICTURE
from hmdwarp.geometry import DepthLayer, Pose, View, metres_from_inverse_depth

from .motions import SLANTED, stepped_depth
from .registry import TWIN, hard_case, knows_one_depth, twin_case
from .setting import HALF, SIZE, SQUARE, Setting, brings_more_pictures, is_warped_by_the_frame_alone, reads_depth

STEP = Pose((0.05, -0.02, 0.03))


def takes_a_picture(name: str) -> bool:
    """Whether the warp works on somebody's own RGB-D frame."""
    return set(parse_warp(name).entry.reads) <= set(PICTURE)


@hard_case("finite, counted as holes, and no red anywhere: what has no depth has no place", takes_a_picture)
def depth_holes_of_every_kind(gpu, name):
    """Sensors deliver them; a filter or an average spreads them, a comparison with NaN is always
    false."""
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
    assert out.hole_share > 0 or knows_one_depth(name)


@hard_case("finite, only what float64 says is covered; no value spreads to its neighbours", reads_depth)
def depth_on_the_gpu_that_is_no_number(gpu, name):
    """A frame that comes straight from a renderer's memory has passed no check."""
    depth = SLANTED.copy()
    for k, bad in enumerate((np.nan, np.inf, -np.inf, -1.0, 1e-40, -0.0)):
        depth[4 + 4 * k, 3::6] = bad
    list(Setting(gpu, depth, STEP).pictures(name))


@hard_case("nothing covered, nothing NaN")
def nothing_has_depth(gpu, name):
    """Medians, minima and pyramids of nothing."""
    for picture in Setting(gpu, np.full(SIZE[::-1], -1.0), STEP).pictures(name):
        if name not in ("environment", "layered", "multi"):
            assert not picture.covered.any()


# Every slope is a silhouette, every average a surface that does not exist.
CHECKERED = np.where(np.add.outer(np.arange(SIZE[1]), np.arange(SIZE[0])) % 2, 1.0, 0.2)
twin_case(
    "checkerboard_depth", lambda gpu: Setting(gpu, CHECKERED, STEP), wants=f"{TWIN}; no colour that was not there"
)


@hard_case("the same winner in ten runs")
def two_surfaces_at_equal_depth(gpu, name):
    """What comes last wins, and on a GPU that changes from run to run."""
    setting = Setting(gpu, np.full(SIZE[::-1], 1.0), Pose((0, 0, 1.0)))
    first = setting.warp(gpu, name)
    assert all(np.array_equal(setting.warp(gpu, name), first) for _ in range(4))  # each runs it twice


@hard_case("what the float64 twin says of it; as many pixels covered as with exact depth, to one in fifty", reads_depth)
def sixteen_bit_depth(gpu, name):
    """2e-4 1/m steps make terraces: neighbouring pixels share a depth, then jump."""
    code = np.rint((1 / 0.1 - SLANTED) / (1 / 0.1 - 1 / 100) * 65535) / 65535
    coarse = DepthLayer(0, 1, 0.1, 100.0).inverse_depth(code)
    assert 0 < np.abs(coarse - SLANTED).max() < 1e-4
    exact, quantised = (list(Setting(gpu, depth, STEP).pictures(name)) for depth in (SLANTED, coarse))
    for a, b in zip(exact, quantised, strict=True):
        assert abs(a.covered.mean() - b.covered.mean()) <= 0.02


@hard_case(
    "depth right to 6e-5 1/m (half a float32 step of the buffer), and the picture of exact depth to what that moves",
    reads_depth,
)
def ill_conditioned_projection(gpu, name):
    """99.9 % of its values are spent on the first metre; unprojecting through the inverse matrix
    loses all digits."""
    near, far = 1e-3, 1e3
    window = (1 / near - SLANTED) / (1 / near - 1 / far) * 2 - 1
    decoded = DepthLayer(-1, 1, near, far).inverse_depth(window.astype(np.float32))
    # One step of a float32 just below 1 is 2^-24; the buffer's 0..2 span 1000 1/m: half a step is
    # 1.5e-5, plus rounding of `window`.
    assert np.abs(decoded - SLANTED).max() <= 6e-5
    list(Setting(gpu, decoded, STEP).pictures(name))


@hard_case("what the float64 twin says: it moves by its own parallax and drags nothing along")
def one_pixel_before_the_sky(gpu, name):
    """The thinnest thing there is: filters lose it, meshes stretch it to the horizon."""
    depth = np.zeros(SIZE[::-1])
    depth[13, 16] = 1.0
    colour = np.full((*depth.shape, 3), 0.25)
    colour[13, 16] = (4.0, 0.25, 0.25)
    for picture in Setting(gpu, depth, Pose((0.2, 0, 0)), colour=colour).pictures(name):
        if is_warped_by_the_frame_alone(name):
            bright = (picture.colour[..., 0] > 1) & picture.decided
            assert bright.sum() <= 4, "smeared"


@hard_case("what the float64 twin says; no mixture of square and wall anywhere")
def silhouette_under_large_motion(gpu, name):
    """The square uncovers a strip as wide as itself, and covers another."""
    depth = stepped_depth()
    colour = np.zeros((*depth.shape, 3))
    colour[..., 1] = 1.0  # wall and sky: green
    colour[depth > 1] = (1.0, 0.0, 0.0)  # the square: red
    for picture in Setting(gpu, depth, Pose((0.25, 0.05, 0)), colour=colour).pictures(name):
        # Copies; the others resample, and may mix within one pixel.
        if name in ("forward", "forward_raster", "forward_ordered"):
            red, green = picture.colour[picture.decided][:, 0], picture.colour[picture.decided][:, 1]
            assert (np.minimum(red, green) == 0).all()


@hard_case(
    "what the float64 twin says; red and blue in shares that make 1, nothing else",
    lambda name: is_warped_by_the_frame_alone(name) and not brings_more_pictures(name),
)
def silhouette_of_mixed_colours(gpu, name):
    """Such a pixel belongs to both surfaces and moves with one."""
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
