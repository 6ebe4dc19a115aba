"""Footprints: no cracks, no halo, no fattened edges, light of any size, and a bounded cost."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate

FOV = Fov.from_tangents([-1, 1, -1, 1])


def centres(size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the pixel centres, 0 to 1 over the picture."""
    y, x = np.mgrid[: size[1], : size[0]]
    return (x + 0.5) / size[0], (y + 0.5) / size[1]


def ramps(size: tuple[int, int]) -> np.ndarray:
    """A picture that says where each of its points is."""
    x, y = centres(size)
    return np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1)


def splatted(gpu, depth, colour, shown: Pose, shown_size=None, spec="splat", fov=FOV) -> np.ndarray:
    """(h, w, 4), bottom row first, seen from `shown`; the rendered eye is at the origin."""
    depth = np.asarray(depth, np.float32)
    size = depth.shape[::-1]
    shown_size = shown_size or size
    rendered_colour, rendered_depth = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
    rendered_colour.write(np.asarray(colour, np.float16).tobytes(), alignment=1)
    rendered_depth.write(depth.tobytes(), alignment=1)
    choice, canvas = parse_warp(spec), Canvas(gpu.gl, shown_size)
    warp = choice.entry(gpu, size, shown_size, choice.settings)
    warp.run(PassInputs(EyeImage(View(Pose(), fov), rendered_colour, rendered_depth), View(shown, fov)), canvas)
    gpu.gl.memory_barrier()
    out = (
        np.frombuffer(canvas.texture.read(alignment=1), np.float16)
        .reshape(shown_size[1], shown_size[0], 4)
        .astype(np.float64)
    )
    warp.close()
    for thing in (rendered_colour, rendered_depth, canvas):
        thing.release()
    return out


def places(size, depth_of_shown: np.ndarray, shown: Pose) -> np.ndarray:
    """(h, w, 2) where in the rendered picture, 0 to 1, each shown pixel's point is, its inverse
    depth in the shown view given.
    """
    high, wide = depth_of_shown.shape
    y, x = np.mgrid[:high, :wide] + 0.5
    backward = WarpMap.between(View(shown, FOV), (wide, high), View(Pose(), FOV), size)
    return backward.apply(np.stack([x, y], axis=-1), depth_of_shown)[0] / size


@pytest.mark.parametrize("closer", [1.3, 2.0, 3.7, 20.0])
def test_a_plane_that_comes_closer_has_no_cracks_and_is_smooth(gpu, closer):
    """From 2 m to 2 m / closer: the middle of the picture, magnified.

    Each pixel where it belongs to a hundredth of a rendered one.
    """
    size, moved = (64, 48), 2 - 2 / closer
    shown = Pose((0.013, -0.007, -moved))
    out = splatted(gpu, np.full(size[::-1], 0.5), ramps(size), shown)
    assert (out[..., 3] == 1).all()
    wanted = places(size, np.full(size[::-1], 0.5 * closer), shown)
    # Half floats below 1 are off by 2^-11.
    assert np.abs(out[..., :2] - wanted).max() * 64 < 0.01 + 64 * 2.0**-11


@pytest.mark.parametrize("closer", [1.0, 2.0, 4.0])
def test_an_approaching_surface_lets_nothing_through(gpu, closer):
    """A white square at 1 m before a black wall at 5 m, the eye at its side and closer.

    Not a trace of black inside, or white outside.
    """
    size, shown = (90, 90), Pose((0.06, 0.031, -(1 - 1 / closer)))
    x, y = (2 * value - 1 for value in centres(size))
    near = (abs(x) < 0.2) & (abs(y) < 0.2)
    colour = np.repeat(near[..., None], 4, axis=-1).astype(float)
    colour[..., 3] = 1
    out = splatted(gpu, np.where(near, 1.0, 0.2), colour, shown)
    # The square's border in the rendered picture runs between pixels, at 0.2; from the shown eye at
    # 1 / closer metres:
    off_x, off_y = (abs(value + closer * step) / closer for value, step in ((x, 0.06), (y, 0.031)))
    away = np.maximum(off_x, off_y) - 0.2
    half_pixel = 0.5 * 2 / 90
    # White over its own weight: a GPU's division is not exact, and the half float may round down.
    whole = (out[..., 0] >= 1 - 2.0**-10) & (out[..., 3] == 1)
    assert whole[away < 0].all(), "background, or a mixture, inside"
    # Fattened by half a shown pixel at most, overlap (a twentieth of a rendered one) included.
    assert (out[..., 0] == 0)[away * closer > max(half_pixel, closer * 0.05 * 2 * half_pixel * 1.01)].all(), (
        "foreground outside"
    )
    if closer == 1:
        hidden = (out[..., 3] == 0).mean()
        assert 0 < hidden < 0.02, "what the square hid is a hole: 2.2 and 1.1 pixels of parallax along two of its sides"


def test_light_of_any_size_and_sign_is_averaged(gpu):
    """1e4, 1e-3 and -5 side by side.

    Each mean is as exact as a half float can hold, none spoils its neighbours'.
    """
    light = np.random.default_rng(2).choice([1e4, 1e-3, -5.0, 6e4, 0.0], (8, 32, 3))
    colour = np.concatenate([light, np.ones((8, 32, 1))], axis=-1).astype(np.float16).astype(float)
    out = splatted(gpu, np.full((8, 32), 1.0), colour, Pose((0.25 / 16, 0, 0)))
    wanted = 0.75 * colour[:, :-1] + 0.25 * colour[:, 1:]
    # 2^-10 for the stored half float; the place is off by 1e-5 pixels at most, times the contrast.
    allowed = 2.0**-10 * np.abs(wanted) + 1e-5 * np.abs(colour[:, :-1] - colour[:, 1:]) + 1e-7
    assert (np.abs(out[:, :-1] - wanted) <= allowed).all()


@pytest.mark.parametrize("reach", [1, 4, 16])
def test_one_pixel_covers_no_more_than_its_reach(gpu, reach):
    """A single drawn pixel before an eye that sees it 60 pixels wide.

    2 reach of them, and no more work than that.
    """
    out = splatted(gpu, np.full((1, 1), 0.5), np.ones((1, 1, 4)), Pose((0, 0, -1e-3)), (60, 60), f"splat:reach={reach}")
    assert (out[..., 3] == 1).sum() == (2 * reach) ** 2
    assert (out[30 - reach : 30 + reach, 30 - reach : 30 + reach, 3] == 1).all()
