"""What the twins are made of: error bounds that hold.

The warps' twins need no tests of their own: another route leads to the shaders' pictures, and what
those show is known in tests/image/test_warping.py.
"""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import METRES, neighbouring_views

from hmdwarp.geometry import WarpMap
from reference._rays import pixel_error_bound

SIZES = st.tuples(st.integers(1, 40), st.integers(1, 40))


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
