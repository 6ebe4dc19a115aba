"""Pictures go into textures and come back as they were, rows turned once. Sizes no GPU has are
refused."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest
from together import together

from hmdwarp.base import InputError
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate, check_size, download, flip_rows, upload

KINDS = [(c, d) for c in (1, 2, 3, 4) for d in ("f1", "f2", "f4", "u4")]
TYPES = {"f1": np.uint8, "f2": np.float16, "f4": np.float32, "u4": np.uint32}


def picture(seed: int, size: tuple[int, int], kind: tuple[int, str]) -> np.ndarray:
    """Random values that the type holds exactly, top row first."""
    components, dtype = kind
    rng, shape = np.random.default_rng(seed), (size[1], size[0]) + ((components,) if components > 1 else ())
    if dtype == "f1":
        return rng.integers(0, 256, shape, dtype=np.uint8)
    if dtype == "u4":
        return rng.integers(0, 2**32, shape, dtype=np.uint32)
    return rng.normal(size=shape).astype(TYPES[dtype])


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: f"{k[0]}{k[1]}")
@together("size", [(1, 1), (3, 5), (7, 2), (5, 1), (1, 5), (64, 33)])
def test_round_trip(gpu, kind, size):
    """Odd widths of one-byte pixels are where a forgotten row alignment shows."""
    texture, image = allocate(gpu.gl, size, kind), picture(1, size, kind)
    upload(texture, image)
    got = download(texture)
    assert got.dtype == TYPES[kind[1]]
    assert got.shape == image.shape
    assert np.array_equal(got, image)
    stored = np.frombuffer(texture.read(alignment=1), TYPES[kind[1]]).reshape(size[1], size[0], -1)
    assert np.array_equal(flip_rows(stored).reshape(image.shape), image)
    texture.release()


@pytest.mark.parametrize(("dtype", "opaque"), [("f1", 255), ("f2", 1), ("f4", 1)])
def test_three_channels_become_opaque(gpu, dtype, opaque):
    texture, image = allocate(gpu.gl, (3, 2), (4, dtype)), picture(2, (3, 2), (3, dtype))
    upload(texture, image)
    assert np.array_equal(download(texture)[..., :3], image)
    assert (download(texture)[..., 3] == opaque).all()
    texture.release()


def test_views_and_reversed_arrays_are_written_as_they_look(gpu):
    texture, image = allocate(gpu.gl, (5, 7), SCALAR), picture(3, (7, 5), SCALAR)
    for view in (
        image.T,
        np.asfortranarray(image.T),
        picture(4, (10, 7), SCALAR)[:, ::2],
        picture(5, (5, 7), SCALAR)[:, ::-1],
    ):
        upload(texture, view)
        assert np.array_equal(download(texture), view)
    texture.release()


def test_pictures_of_another_shape_are_refused_and_a_scalar_takes_its_axis_or_none(gpu):
    texture, scalar = allocate(gpu.gl, (4, 3), COLOUR), allocate(gpu.gl, (4, 3), SCALAR)
    for shape in ((4, 3, 4), (3, 5, 4), (3, 4), (3, 4, 2), (3, 4, 5), (3, 4, 1), (3, 4, 4, 1)):
        with pytest.raises(InputError, match=r"picture (is|has shape)"):
            upload(texture, np.zeros(shape, np.float32))
    image = picture(6, (4, 3), SCALAR)
    upload(scalar, image[..., None])
    assert np.array_equal(download(scalar), image)
    with pytest.raises(InputError, match="1 components"):
        upload(scalar, np.zeros((3, 4, 3), np.float32))


def test_sizes_below_one_and_beyond_the_limit_are_refused_and_the_limit_is_not(gpu):
    limit = gpu.max_texture_size
    for size in ((0, 0), (0, 5), (5, 0), (-1, 5), (limit + 1, 1), (1, limit + 1), (10**9, 10**9)):
        for made in (check_size, lambda gl, size: allocate(gl, size, SCALAR), Canvas):
            with pytest.raises(InputError, match=rf"picture size {size[0]}x{size[1]}: expected 1 to {limit} on each"):
                made(gpu.gl, size)
    for size in ((limit, 1), (1, limit)):
        allocate(gpu.gl, size, SCALAR).release()


@pytest.mark.parametrize("linear", [False, True])
def test_textures_are_clamped_and_filtered_as_asked(gpu, linear):
    texture = allocate(gpu.gl, (2, 1), SCALAR, linear=linear)
    assert (texture.repeat_x, texture.repeat_y) == (False, False)
    assert texture.filter == (moderngl.LINEAR if linear else moderngl.NEAREST,) * 2
    texture.release()


@pytest.mark.parametrize("size", [(1, 1), (67, 53), (129, 2)])
def test_clear_empties_every_pixel_and_nothing_else(gpu, size):
    canvas, other = Canvas(gpu.gl, size), Canvas(gpu.gl, size)
    full = np.full((size[1], size[0], 4), 0.5, np.float16)
    for each in (canvas, other):
        upload(each.texture, full)
    before = gpu.gl.fbo
    canvas.clear()
    assert np.array_equal(download(canvas.texture), np.zeros_like(full))
    assert np.array_equal(download(other.texture), full)
    assert gpu.gl.fbo is before
    assert canvas.size == size
    canvas.release()
    other.release()
