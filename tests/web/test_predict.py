"""The page's predictor beside hmdwarp's own, on the same heads."""

from __future__ import annotations

import json

import needs
import numpy as np

from hmdwarp.poses import PoseTrack, load_trace
from hmdwarp.poses.predictors.cautious import HORIZON_NS, cautious

from .browser import Browser, page

pytestmark = needs.programs("chromium")

PREDICTED = """
async (heads, asked) => {
  const { Predictor } = await import("./predict.js"), predictor = new Predictor(), found = [];
  for (const [ms, x, y, z, ...orientation] of heads) {
    predictor.saw(ms, { position: [x, y, z], orientation });
    for (const [now, ahead] of asked) if (now === ms) {
      const { position, orientation } = predictor.at(now, ahead);
      found.push([...position, ...orientation]);
    }
  }
  return found;
}
"""


def test_the_same_head_as_here(tmp_path):
    """Both in float64: what differs is the order of sums."""
    track = load_trace("walk").track
    ms = np.delete(np.arange(0, 6000, 1000 / 72), slice(310, 322))  # a gap
    places = [track.at(track.start_ns + round(at * 1e6)).pose for at in ms]
    p, q = (np.array([getattr(one, name) for one in places]) for name in ("position_m", "orientation_xyzw"))
    p[200:203], q[200:203] = p[199], q[199]  # a tracker that repeats itself
    seen = PoseTrack(np.round(ms * 1e6).astype(np.int64), p, q, name="seen", origin=track.origin, axes=track.axes)
    asked = [(k, ahead) for k in (0, 2, 4, 9, 50, 201, 204, 300, 312, 316, 400) for ahead in (20.0, 90.0, 230.0)]
    with Browser(tmp_path) as driven, page({}) as address:
        driven.open(address)
        driven.until("globalThis.packed")
        times = (seen.time_ns * 1e-6).tolist()
        heads = np.column_stack([times, seen.position_m, seen.orientation_xyzw]).tolist()
        found = driven.does(f"({PREDICTED})({json.dumps(heads)}, {json.dumps([(times[k], a) for k, a in asked])})")
    for (k, ahead), values in zip(asked, found, strict=True):
        now_ns = int(seen.time_ns[k])
        own = cautious(seen, now_ns, now_ns + round(ahead * 1e6), HORIZON_NS).pose
        sign = np.sign(np.dot(own.orientation_xyzw, values[3:]))
        np.testing.assert_allclose(values[:3], own.position_m, atol=1e-9)
        np.testing.assert_allclose(sign * np.array(values[3:]), own.orientation_xyzw, atol=1e-9)
    assert any(np.abs(np.array(values[:3]) - p[k]).max() > 0.01 for (k, _), values in zip(asked, found, strict=True))
