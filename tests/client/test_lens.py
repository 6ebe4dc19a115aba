"""The lens pass on the GPU against its float64 twin, and against the polynomial itself."""

from __future__ import annotations

import numpy as np
import pytest
from reference.fused import looked_at
from reference.lens import radial
from reference.picture import GPU_SAMPLER_PIXELS, HALF_SMALLEST, HALF_UNIT
from worlds import read

from hmdwarp.base import InputError
from hmdwarp.client.lens import lenses
from hmdwarp.geometry import Fov
from hmdwarp.gpu import Canvas
from hmdwarp.headsets import Headset, headset_names, load_headset

WITH_LENS = [name for name in headset_names() if load_headset(name).lens]
SIZES = [
    ((67, 53), (67, 53)),
    ((64, 64), (101, 37)),
    ((129, 2), (31, 127)),
    ((1, 1), (9, 7)),
    ((40, 50), (1, 1)),
]  # shown, panel
COLOURS = ("red", "green", "blue")
UNIT = 2.0**-24


def through_the_lens(gpu, shown: np.ndarray, headset: Headset, eye: int, panel_size: tuple[int, int]) -> np.ndarray:
    """(h, w, 4) shown picture, bottom row first, to the panel picture as the GPU makes it."""
    canvas, panel = Canvas(gpu.gl, shown.shape[1::-1]), Canvas(gpu.gl, panel_size)
    canvas.texture.write(shown.astype(np.float16).tobytes(), alignment=1)
    lens = lenses.get("radial")(gpu, headset, panel_size)
    lens.run(canvas, Fov.symmetric(1, 1), eye, panel)  # of which nothing stays
    panel.texture.write(np.full((panel_size[1], panel_size[0], 4), 7, np.float16).tobytes(), alignment=1)
    lens.run(canvas, headset.eyes[eye].fov, eye, panel)
    gpu.gl.memory_barrier()
    out = read(panel.texture)
    canvas.release()
    panel.release()
    return out


def places(headset: Headset, eye: int, panel_size, shown_size, colour: str) -> tuple[np.ndarray, ...]:
    """Where in the shown picture, in pixels, each panel pixel looks, and a float32 shader's error.
    And where its error leaves no doubt on which side of the border that is."""
    pixels, error = looked_at(headset, eye, panel_size, headset.eyes[eye].fov, shown_size, colour)
    decided = np.minimum(np.abs(pixels), np.abs(pixels - np.array(shown_size))).min(axis=-1) > error
    return pixels, error, decided


def sampler_error_pixels(gpu, size) -> float:
    """llvmpipe turns a place into 0..1 and back in float32, each half a unit of the place. A GPU
    rounds it to 1/256 pixel."""
    return 4 * UNIT * max(size) if gpu.is_software else GPU_SAMPLER_PIXELS


@pytest.mark.parametrize("name", WITH_LENS)
@pytest.mark.parametrize("eye", [0, 1])
@pytest.mark.parametrize(("shown_size", "panel_size"), SIZES)
def test_the_pass_equals_its_twin(gpu, name, eye, shown_size, panel_size):
    headset = load_headset(name)
    rng = np.random.default_rng(eye)
    shown = rng.uniform(0, 1, (shown_size[1], shown_size[0], 4)).astype(np.float16).astype(np.float64)
    got, wanted = (
        through_the_lens(gpu, shown, headset, eye, panel_size),
        radial(shown, headset.eyes[eye].fov, headset, eye, panel_size),
    )
    for channel, colour in enumerate(COLOURS):
        _, error, decided = places(headset, eye, panel_size, shown_size, colour)
        # Neighbours differ by less than 1, on both axes.
        moved = 2 * error + 2 * sampler_error_pixels(gpu, shown_size)
        for target in (channel, 3) if colour == "green" else (channel,):
            tolerance = moved + HALF_UNIT * np.abs(wanted[..., target]) + HALF_SMALLEST
            difference = np.abs(got[..., target] - wanted[..., target])
            assert (difference <= tolerance)[decided].all(), f"{colour}: {difference[decided].max()}"
        if decided.size > 100:
            assert decided.mean() > 0.95


def test_colours_part_where_the_lens_parts_them(gpu):
    """The DK1's blue is magnified more than its red. The three channels of a grey picture differ
    away from the axis, not on it."""
    headset = load_headset("rift-dk1")
    ramp = np.broadcast_to(np.linspace(0.1, 0.9, 65)[None, :, None], (65, 65, 4))
    got = through_the_lens(gpu, ramp, headset, 0, (65, 81))
    apart = np.abs(got[..., 0] - got[..., 2])
    axis_x = round((0.03744 + 0.00569) / 0.07488 * 65)
    assert apart[40, axis_x - 1 : axis_x + 1].max() < 0.002
    assert apart[40, 10:14].min() > 0.004


def test_a_headset_without_a_lens_is_refused(gpu):
    with pytest.raises(InputError, match="headset 'flat-90' has no lens: use --lens none"):
        lenses.get("radial")(gpu, load_headset("flat-90"), (8, 8))
