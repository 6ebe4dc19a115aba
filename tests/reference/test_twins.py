"""What the twins are made of: the way of a ray, and error bounds that hold.

The warps' twins need no tests of their own: another route leads to the shaders' pictures, and what
those show is known in tests/image/test_warping.py.
"""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import METRES, neighbouring_views

from hmdwarp.geometry import WarpMap
from reference._rays import pixel_error_bound, project, world_directions

SIZES = st.tuples(st.integers(1, 40), st.integers(1, 40))


@given(neighbouring_views(METRES), SIZES, SIZES, st.floats(0, 3))
def test_rays_and_the_warp_map_agree(views, size, to_size, inverse_depth):
    """Two routes to the same place: what makes the twins proof for shaders that multiply by H."""
    frm, to = views
    own = np.full(size[::-1], inverse_depth)
    pixels, depth, w = project(world_directions(frm, size), frm.pose.position_m - to.pose.position_m, own, to, to_size)
    centres = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in size)), axis=-1)
    map_pixels, map_depth, map_w = WarpMap.between(frm, size, to, to_size).apply(centres, own)
    ahead = w > 0.05
    # Terms of up to 3 m * 3 / m and tangents below 3, through a turn: 64 units of 20; over w 0.05
    # and 40 / 0.2 pixels per tangent.
    assert np.abs(w - map_w).max() <= 2e-13
    assert np.abs(pixels - map_pixels)[ahead].max(initial=0) <= 1e-7
    assert np.abs(depth - map_depth)[ahead].max(initial=0) <= 1e-9


@settings(max_examples=60)
@given(neighbouring_views(METRES), SIZES, SIZES, st.integers(0, 99))
def test_a_float32_map_stays_within_its_bound(views, size, to_size, seed):
    """What a shader does, in NumPy's float32. The error is below the bound, and the bound is no
    excuse for anything."""
    frm, to = views
    own = np.random.default_rng(seed).uniform(0, 2, size[::-1]).astype(np.float32).astype(np.float64)
    warp = WarpMap.between(frm, size, to, to_size)
    centres = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in size)), axis=-1)
    exact, _, w = warp.apply(centres, own)
    bound = pixel_error_bound(warp, size, own)
    H, e, p = (a.astype(np.float32) for a in (warp.H, warp.e, centres))
    q = (H[:, 0] * p[..., :1] + H[:, 1] * p[..., 1:]) + H[:, 2] + e * own.astype(np.float32)[..., None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        got = (q[..., :2] / q[..., 2:]).astype(np.float64)
    sure = np.isfinite(bound) & (w > 0)
    assert (np.abs(got - exact).max(axis=-1) <= bound)[sure].all()
    plain = w > 0.5
    # Pictures of 40 pixels: positions below 1e4 (a view far off its axis), 24 units of them, over
    # w.
    assert bound[plain].max(initial=0) < 0.05
