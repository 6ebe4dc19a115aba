"""The page's predictor beside hmdwarp's own, on the same heads."""

from __future__ import annotations

import json

import needs
import numpy as np

from hmdwarp.poses import PoseTrack, load_trace
from hmdwarp.poses.predictors.cautious import HORIZON_NS, cautious

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


def test_the_same_head_as_here(browser):
    """Both in float64: what differs is the order of sums."""
    track = load_trace("walk").track
    ms = np.delete(np.arange(0, 6000, 1000 / 72), slice(310, 322))  # a gap
    places = [track.at(track.start_ns + round(at * 1e6)).pose for at in ms]
    p, q = (np.array([getattr(one, name) for one in places]) for name in ("position_m", "orientation_xyzw"))
    p[200:203], q[200:203] = p[199], q[199]  # a tracker that repeats itself
    seen = PoseTrack(np.round(ms * 1e6).astype(np.int64), p, q, name="seen", origin=track.origin, axes=track.axes)
    asked = [(k, ahead) for k in (0, 2, 4, 9, 50, 201, 204, 300, 312, 316, 400) for ahead in (20.0, 90.0, 230.0)]
    times = (seen.time_ns * 1e-6).tolist()
    heads = np.column_stack([times, seen.position_m, seen.orientation_xyzw]).tolist()
    found = browser.does(f"({PREDICTED})({json.dumps(heads)}, {json.dumps([(times[k], a) for k, a in asked])})")
    for (k, ahead), values in zip(asked, found, strict=True):
        now_ns = int(seen.time_ns[k])
        own = cautious(seen, now_ns, now_ns + round(ahead * 1e6), HORIZON_NS).pose
        sign = np.sign(np.dot(own.orientation_xyzw, values[3:]))
        np.testing.assert_allclose(values[:3], own.position_m, atol=1e-9)
        np.testing.assert_allclose(sign * np.array(values[3:]), own.orientation_xyzw, atol=1e-9)
    assert any(np.abs(np.array(values[:3]) - p[k]).max() > 0.01 for (k, _), values in zip(asked, found, strict=True))


def test_a_jump_of_the_tracking_space_is_not_extrapolated(browser):
    """Once the new place is seen, what is foretold is within 116 ms of a head's own motion."""
    ms = np.arange(0, 1500, 1000 / 90)
    for yaw, step in ((75, 0.0), (0, 10.0), (-170, 0.5)):
        angle = 20 * np.sin(ms / 600) + yaw * (ms >= 1000)
        place = 0.1 * np.sin(ms / 700) + step * (ms >= 1000)
        half = np.radians(angle) / 2
        still = np.zeros_like(ms)
        heads = np.column_stack([ms, place, still + 1.6, still, still, np.sin(half), still, np.cos(half)])
        asked = [(float(at), 116.0) for at in ms[ms >= 1000][:12]]
        found = np.array(browser.does(f"({PREDICTED})({json.dumps(heads.tolist())}, {json.dumps(asked)})"))
        then = ms[ms >= 1000][:12] + 116
        off = 2 * np.degrees(np.arctan2(found[:, 4], found[:, 6])) - 20 * np.sin(then / 600) - yaw
        # It turns by 33 degrees/s at most and moves by 0.14 m/s: 3.9 degrees and 17 mm in 116 ms.
        assert np.abs((off + 180) % 360 - 180).max() < 3.9
        assert np.abs(found[:, 0] - 0.1 * np.sin(then / 700) - step).max() < 0.017
