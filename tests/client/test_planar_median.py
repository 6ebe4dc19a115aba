"""The median shader against NumPy: holes, ties, sky, odd sizes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.gather import median_inverse_depth

from hmdwarp.gpu import SCALAR, allocate

GRID = 64


def gpu_median(gpu, depth: np.ndarray) -> np.float32:
    """What the shader leaves in its buffer for an (h, w) float32 picture, bottom row first."""
    size = depth.shape[1::-1]
    texture = allocate(gpu.gl, size, SCALAR)
    texture.write(np.ascontiguousarray(depth, np.float32).tobytes(), alignment=1)
    buffer = gpu.gl.buffer(np.full(4, np.nan, np.float32).tobytes())
    program = gpu.shaders.compute("warps/median.comp")
    texture.use(1)
    buffer.bind_to_storage_buffer(0)
    program.uniforms.set(rendered_inverse_depth=1, rendered_size=size)
    program.run(1)
    gpu.gl.memory_barrier()
    out = np.frombuffer(buffer.read(), np.float32)
    assert np.isnan(out[1:]).all(), "it writes one number"
    buffer.release()
    texture.release()
    return out[0]


def random_depth(seed: int, size: tuple[int, int]) -> np.ndarray:
    rng = np.random.default_rng(seed)
    depth = rng.exponential(0.5, (size[1], size[0])).astype(np.float32)
    depth[rng.uniform(size=depth.shape) < 0.1] = 0
    depth[rng.uniform(size=depth.shape) < 0.1] = -1
    return depth


@pytest.mark.parametrize(
    "size", [(1, 1), (3, 5), (67, 53), (129, 2), (2, 129), (1000, 3), (63, 65), (641, 401), (128, 128)]
)
def test_any_size_gives_the_median_of_the_cells(gpu, size):
    depth = random_depth(sum(size), size)
    assert gpu_median(gpu, depth) == median_inverse_depth(depth.astype(np.float64))


@settings(max_examples=60)
@given(
    st.tuples(st.integers(1, 80), st.integers(1, 80)),
    st.lists(st.sampled_from([-1.0, 0.0, 0.25, 0.5, 1.0, 1e-30, 1e30, 3.0]), min_size=1, max_size=6),
    st.integers(0, 2**31),
)
def test_with_few_values_and_many_ties(gpu, size, values, seed):
    depth = np.random.default_rng(seed).choice(np.array(values, np.float32), (size[1], size[0]))
    assert gpu_median(gpu, depth) == np.float32(median_inverse_depth(depth))


def test_neighbouring_floats_are_told_apart(gpu):
    values = np.full(GRID * GRID, np.float32(0.1))
    values[: GRID * GRID // 2 - 1] = np.nextafter(np.float32(0.1), np.float32(0))
    values[-3:] = np.nextafter(np.float32(0.1), np.float32(1))
    assert gpu_median(gpu, values.reshape(GRID, GRID)) == np.float32(0.1)
    values[: GRID * GRID // 2] = np.nextafter(np.float32(0.1), np.float32(0))
    assert gpu_median(gpu, values.reshape(GRID, GRID)) == np.nextafter(np.float32(0.1), np.float32(0))
