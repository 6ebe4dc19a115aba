"""What modules of the page find, beside hmdwarp's own: predictor, governor, PSNR; and what a page
asks for over a link that is modelled.
"""

from __future__ import annotations

import json
from itertools import pairwise
from statistics import fmean

import needs
import numpy as np
import pytest

from hmdwarp.metrics import db_of
from hmdwarp.pipeline import QualityLevel
from hmdwarp.pipeline.governor import Governor
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
    p[200:206], q[200:206] = p[199], q[199]  # a tracker that repeats itself, until it counts as at rest
    seen = PoseTrack(np.round(ms * 1e6).astype(np.int64), p, q, name="seen", origin=track.origin, axes=track.axes)
    asked = [(k, ahead) for k in (0, 2, 4, 9, 50, 201, 204, 207, 300, 312, 316, 400) for ahead in (20.0, 90.0, 230.0)]
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


GOVERNED = """
async (levels, budget, times) => {
  const { Governor } = await import("./measure.js"), governor = new Governor(levels, budget);
  return times.map((ms) => [Boolean(governor.measured(ms)), governor.level.name]);
}
"""


def test_the_page_governs_as_a_live_run(browser):
    """The same moves at the same refreshes: calm, slow spells, noise about the budget, calm."""
    rng, levels = np.random.default_rng(4), {"cheap": 1.0, "middle": 2.5, "good": 3.0, "best": 4.0}
    known = json.dumps([{"name": name, "ms": ms} for name, ms in levels.items()])
    seen, changes = set(), 0
    for _ in range(8):
        # The dearer a level, the longer it may be slow: what is tried again fails again.
        spells = [np.full(rng.integers(40, 500), factor) for factor in rng.uniform(0.7, 2.6, 12)]
        slow = np.concatenate([np.ones(100), *spells, 1 + 0.6 * rng.random(300), np.full(700, 0.9)])
        own = Governor(tuple(QualityLevel(name, "none", ms, 1 / ms) for name, ms in levels.items()), 4.5)
        times, expected = [], []
        for factor in slow:
            times.append(float(factor * levels[own.level.warp]))
            expected.append([own.measured(times[-1]) is not None, own.level.warp])
        assert browser.does(f"({GOVERNED})({known}, 4.5, {json.dumps(times)})") == expected
        seen, changes = seen | {name for _, name in expected}, changes + sum(changed for changed, _ in expected)
    assert changes > 20 and seen == {*levels}


ERRORS = """
async (pixels, truth) => {
  const { psnr } = await import("./bench.js");
  return psnr(new Uint8Array(pixels), new Uint8Array(truth));
}
"""


PHONE = """
async (angle, [alpha, beta, gamma]) => {
  const { ByHand, rotate } = await import("./head.js");
  const head = new ByHand(document.body, { position: [0, 0, 0], orientation: [0, 0, 0, 1] });
  Object.defineProperty(screen, "orientation", { value: { angle }, configurable: true });
  dispatchEvent(new DeviceOrientationEvent("deviceorientation", { alpha, beta, gamma }));
  return [[0, 0, -1], [0, 1, 0]].flatMap((way) => rotate(head.at(0).orientation, way));
}
"""


def test_a_phone_held_upright_looks_ahead_on_either_side(browser):
    """To the north; its upper end up, left, right."""
    for angle, turns in ((0, [0, 90, 0]), (90, [90, 0, -90]), (270, [270, 0, 90])):
        assert browser.does(f"({PHONE})({angle}, {turns})") == pytest.approx([0, 0, -1, 0, 1, 0], abs=1e-9)


@pytest.mark.parametrize("off", [0, 1, 60])
def test_the_page_s_psnr_is_that_of_every_run(browser, off):
    """Of colours alone, whatever is in alpha; equal pictures have a finite one, for JSON."""
    truth = np.random.default_rng(off).integers(0, 256 - off, (24, 4), np.uint8)
    pixels = truth + np.array([off, 0, off, 0], np.uint8)
    pixels[:, 3] = 255 - truth[:, 3]
    found = browser.does(f"({ERRORS})({pixels.ravel().tolist()}, {truth.ravel().tolist()})")
    assert found == pytest.approx(db_of(2 / 3 * off**2 / 255**2))


# A link of so many Mbit/s at each instant, 20 ms long each way, on which frames queue; a server
# that codes a picture at best with 0.15 bits of colour and 0.1 of depth a pixel, as it does the
# room, and key frames four times as large; a page that asks where its window has room.
LINK = """
async (mbit_at, seconds, decoding) => {
  const { Pace } = await import("./pace.js"), { Feed } = await import("./feed.js");
  const pace = new Pace(30), sent = [], log = [], feed = Object.create(Feed.prototype);
  pace.pixels = 800 * 500;
  const socket = { readyState: WebSocket.OPEN, bufferedAmount: 0 };
  Object.assign(feed, { asked: new Map(), work: 10, round: 0, socket });
  let free = 0, last = -1e9, before = "", number = 0;
  const clock = performance.now;
  performance.now = () => now;
  let now = 0;
  for (; now < 1000 * seconds; now += 1) {
    while (sent.length && sent[0].there <= now) {
      const frame = sent.shift();
      feed.asked.delete(frame.number);
      const queue = { decoding: decoding(now, pace.wish), slack: 33 };
      pace.took(now, { way: now - frame.asked - 10, bytes: frame.bytes, depth: frame.depth, ...queue });
      log.push([now, now - frame.asked, frame.bytes, frame.wish]);
    }
    const wish = pace.wish;
    if (now - last < 1000 / wish.rate || !feed.hasRoom(1000 / wish.rate, pace.shortest)) continue;
    [last, number] = [now, number + 1];
    feed.asked.set(number, now);
    const pixels = pace.pixels * wish.scale ** 2, key = JSON.stringify(wish) === before ? 1 : 4;
    before = JSON.stringify(wish);
    const depth = 0.1 * pixels / 8 * key;
    const bytes = depth + key * (wish.mbit ? 1e6 * wish.mbit / wish.rate / 8 : 0.15 * pixels / 8);
    free = Math.max(free, now + 30) + 8e-3 * bytes / mbit_at(now);
    sent.push({ number, asked: now, bytes, depth, wish, there: free + 20 });
  }
  performance.now = clock;
  return log;
}
"""
NO_QUEUE = "() => 0"


@pytest.fixture(scope="module")
def over(browser):
    """A function: what came over a link, (ms, its age, bytes, wish) of each frame."""
    return lambda mbit, seconds, decoding=NO_QUEUE: browser.does(f"({LINK})({mbit}, {seconds}, {decoding})")


def test_a_wide_link_gets_the_best(over):
    log = over("() => 20", 20)
    assert {json.dumps(wish) for *_, wish in log} == {json.dumps({"mbit": 0, "scale": 1, "rate": 30})}
    assert len(log) > 0.95 * 30 * 20


@pytest.mark.parametrize("mbit", [2.0, 1.0, 0.4])
def test_bits_follow_a_narrow_link(over, mbit):
    """At best frames have 3 Mbit/s. From the tenth second on a frame is as old as way and server
    make it, the queue that Pace lets be, and a frame's interval; and the link is half full.
    """
    log = [row for row in over(f"() => {mbit}", 60) if row[0] > 10_000]
    carried = 8e-3 * sum(size for _, _, size, _ in log) / 50_000
    assert 0.5 * mbit < carried <= 1.01 * mbit
    assert fmean(age for _, age, _, _ in log) < 50 + 60 + 1000 / min(wish["rate"] for *_, wish in log)
    assert len(log) > (0.9 if mbit >= 1 else 0.45) * 30 * 50


def test_there_are_fewer_pixels_before_there_are_fewer_frames(over):
    wishes = [wish for at, *_, wish in over("() => 0.4", 60) if at > 10_000]
    assert {wish["scale"] for wish in wishes if wish["rate"] < 30} <= {0.5}
    assert min(wish["scale"] for wish in wishes) == 0.5
    one = [wish for at, *_, wish in over("() => 1", 60) if at > 10_000]
    assert {wish["rate"] for wish in one} == {30} and min(wish["scale"] for wish in one) < 1
    # More is tried, more and more seldom.
    assert 0 < sum(after["mbit"] > before["mbit"] for before, after in pairwise(one)) < 6


def test_the_best_comes_back_with_the_link(over):
    log = over("(now) => now < 20000 ? 1 : 20", 90)
    assert max(wish["mbit"] for at, *_, wish in log if 10_000 < at < 20_000) > 0
    assert log[-1][3] == {"mbit": 0, "scale": 1, "rate": 30}


def test_a_slow_decoder_gets_fewer_pixels_of_the_same_quality(over):
    log = over("() => 20", 20, "(now, { scale }) => scale > 0.6 ? 8 : 1")
    assert {wish["mbit"] for *_, wish in log} == {0} and {wish["rate"] for *_, wish in log} == {30}
    assert min(wish["scale"] for *_, wish in log) == 0.5
