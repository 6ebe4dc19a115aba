"""Foreign depth to inverse depth and back, against the 4x4 matrices of other renderers."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from together import together

from hmdwarp.base import InputError
from hmdwarp.geometry import DepthLayer, inverse_depth_from_metres, metres_from_inverse_depth

UNIT = 2.0**-53
PLANES = [0.01, 0.1, 1.0, 50.0, 1e4, math.inf]
RANGES = [(0.0, 1.0), (0.1, 0.7), (0.0, 0.3), (0.5, 1.0), (0.25, 0.250001), (-1.0, 1.0)]
LAYERS = [
    DepthLayer(low, high, near, far)
    for (low, high), near, far in itertools.product(RANGES, PLANES, PLANES)
    if near != far
]


def tolerance(layer: DepthLayer) -> float:
    """In 1/m. A buffer value of at most 1 is good to 8 units, which the range and the span of
    inverse depths magnify."""
    span = abs(1 / layer.near_z - 1 / layer.far_z)
    return 8 * UNIT * (span / (layer.max_depth - layer.min_depth) + 1 / layer.near_z + 1 / layer.far_z)


def depths_between(layer: DepthLayer) -> np.ndarray:
    """Metres from one plane to the other, both included, evenly in inverse depth and evenly in its
    logarithm."""
    near, far = sorted((layer.near_z, layer.far_z))
    inverse = np.concatenate([np.linspace(1 / far, 1 / near, 33), np.geomspace(max(1 / far, 1e-12), 1 / near, 33)])
    return metres_from_inverse_depth(np.clip(inverse, 1 / far, 1 / near))


# --- the matrices of others: column vectors, eye looks along -z ---------------------------------


def gl_matrix(n: float, f: float) -> np.ndarray:
    """glFrustum's: depth to -1..1. OpenGL 4.6 compatibility specification, section 12.1.1."""
    last = (-1, -2 * n) if math.isinf(f) else (-(f + n) / (f - n), -2 * f * n / (f - n))
    return np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, *last], [0, 0, -1, 0]])


def d3d_matrix(n: float, f: float) -> np.ndarray:
    """D3DXMatrixPerspectiveRH's, transposed to column vectors: depth to 0..1."""
    last = (-1, -n) if math.isinf(f) else (f / (n - f), n * f / (n - f))
    return np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, *last], [0, 0, -1, 0]])


def reversed_matrix(n: float, f: float) -> np.ndarray:
    """near to 1, far to 0; infinite far has z_clip = n (Reed 2015, Depth Precision Visualized)."""
    last = (0, n) if math.isinf(f) else (n / (f - n), n * f / (f - n))
    return np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, *last], [0, 0, -1, 0]])


def clip_depth(matrix: np.ndarray, metres: np.ndarray) -> np.ndarray:
    """z / w of points straight and aslant ahead at these depths."""
    points = np.stack([0.3 * metres, -0.2 * metres, -metres, np.ones_like(metres)])
    clip = matrix @ points
    return clip[2] / clip[3]


# Each with the depth at the near and at the far plane; Vulkan's has y downwards, the same depth.
CLIP = {
    "gl": (gl_matrix, -1, 1),
    "gl reversed": (lambda n, f: np.diag([1, 1, -1, 1]) @ gl_matrix(n, f), 1, -1),
    "d3d": (d3d_matrix, 0, 1),
    "reversed": (reversed_matrix, 1, 0),
}


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (0.1, 0.7), (0.5, 1.0), (-1.0, 1.0)])
@pytest.mark.parametrize(("near", "far"), [(0.01, 2.0), (0.1, 100.0), (0.1, 1e5), (1.0, math.inf)])
@pytest.mark.parametrize("api", CLIP)
def test_depth_of_a_projection_matrix_in_a_range(api, near, far, low, high):
    """What glDepthRange(low, high) or a viewport stores of a matrix, or the matrix's own depth."""
    make, at_near, at_far = CLIP[api]
    metres = np.geomspace(near, min(far, 1e6), 41)[1:-1]
    share = (clip_depth(make(near, far), metres) - min(at_near, at_far)) / abs(at_far - at_near)
    layer = DepthLayer(low, high, *((near, far) if at_near < at_far else (far, near)))
    # z_clip and w carry terms of at most far / (far - near) <= 2 times the depth: clip depth is
    # good to 32 units.
    got = layer.inverse_depth(low + (high - low) * share)
    assert np.abs(got - 1 / metres).max() <= 32 * UNIT / near / min(high - low, 1)


def test_known_values():
    # Reversed with infinite far: d = near / depth. D3D 0.1..100 at 0.2 m: 100/99.9 (1 - 0.1/0.2) =
    # 0.5005...
    assert DepthLayer(0, 1, math.inf, 0.1).inverse_depth([1, 0.5, 0.1, 0]) == pytest.approx([10, 5, 1, 0], abs=1e-14)
    assert DepthLayer(0, 1, 0.1, 100).inverse_depth(100 / 99.9 / 2) == pytest.approx(5, abs=1e-13)


# --- every legal combination --------------------------------------------------------------------


@together("layer", LAYERS)
def test_round_trip_and_the_ends_are_the_planes(layer):
    metres = depths_between(layer)
    inverse = inverse_depth_from_metres(metres)
    stored = layer.encode(inverse)
    assert ((stored >= layer.min_depth - UNIT) & (stored <= layer.max_depth + UNIT)).all()
    again = layer.inverse_depth(stored)
    assert np.abs(again - inverse).max() <= tolerance(layer)
    ends = layer.inverse_depth([layer.min_depth, layer.max_depth])
    assert np.abs(ends - [1 / layer.near_z, 1 / layer.far_z]).max() <= tolerance(layer)


@together("layer", LAYERS)
def test_steps_go_one_way_and_what_lies_beyond_is_clamped_or_no_depth(layer):
    inverse = layer.inverse_depth(np.linspace(layer.min_depth, layer.max_depth, 101))
    assert (np.diff(inverse) * (1 if layer.near_z < layer.far_z else -1) < 0).all() and (inverse >= 0).all()
    near, far = sorted((layer.near_z, layer.far_z))
    ends = {layer.near_z: layer.min_depth, layer.far_z: layer.max_depth}
    assert layer.encode(1 / near * 3) == pytest.approx(ends[near], abs=2 * UNIT)
    assert layer.encode(1 / far / 3) == pytest.approx(ends[far], abs=2 * UNIT)
    margin = 0.05 * (layer.max_depth - layer.min_depth)
    got = layer.inverse_depth([layer.min_depth - margin, layer.max_depth + margin, math.nan, math.inf, -math.inf])
    assert np.isnan(got).all() and np.isnan(layer.encode(math.nan))


def stored(kind: str, value: float) -> float:
    """The number that a buffer of this kind holds for `value`."""
    if kind == "float32":
        return float(np.float32(value))
    steps = 2 ** int(kind.removeprefix("unorm")) - 1
    return round(value * steps) / steps


@pytest.mark.parametrize("kind", ["unorm16", "unorm24", "float32"])
@pytest.mark.parametrize("ends", [(0.0, 1.0), (0.1, 0.7), (0.0, 0.3), (1 / 3, 2 / 3), (0.2, 0.9)])
@pytest.mark.parametrize("planes", [(0.1, math.inf), (math.inf, 0.1), (0.1, 20.0)])
def test_a_cleared_buffer_is_at_its_plane_and_not_without_depth(kind, ends, planes):
    """float32(0.3) is above 0.3: the sky of such a buffer must not turn into holes."""
    layer = DepthLayer(*ends, *planes)
    got = layer.inverse_depth([stored(kind, end) for end in ends])
    half_step = 0.5 / (2**16 - 1)
    assert np.abs(got - [1 / planes[0], 1 / planes[1]]).max() <= 10.1 * half_step / (ends[1] - ends[0])


# --- what is refused ----------------------------------------------------------------------------


def test_planes_and_ranges_that_are_none_are_refused():
    inf, nan = math.inf, math.nan
    for near, far in ((0, 1), (1, 0), (-0.1, 1), (0.1, -1), (1, 1), (inf, inf), (nan, 1), (1, nan), (-inf, 1)):
        with pytest.raises(InputError, match="two different positive distances"):
            DepthLayer(0, 1, near, far)
    for low, high in ((0.5, 0.5), (0.7, 0.1), (-1.1, 1), (0, 1.1), (nan, 1), (0, nan), (-inf, 1), (0, inf)):
        with pytest.raises(InputError, match="expected min < max"):
            DepthLayer(low, high, 0.1, 10)


# --- metres -------------------------------------------------------------------------------------


def test_metres_at_the_edges():
    smallest = 1 / float(np.finfo(np.float32).max)
    got = inverse_depth_from_metres([math.inf, 0, -0.0, -1, math.nan, -math.inf, smallest / 2, 5e-324, smallest * 2, 4])
    assert np.array_equal(got[[0, 9]], [0, 0.25])
    assert np.isnan(got[1:8]).all()
    assert np.isfinite(np.float32(got[8]))
    assert np.array_equal(metres_from_inverse_depth([0, -0.0, 2]), [math.inf, math.inf, 0.5])
    assert np.isnan(metres_from_inverse_depth(math.nan))
