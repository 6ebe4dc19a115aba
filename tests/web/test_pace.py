"""What a page asks for, as link and decoder allow: over a link that is modelled, and a real one."""

from __future__ import annotations

import json
from itertools import pairwise
from statistics import fmean

import needs
import pytest
from serving import Serving
from sources.feed.relay import Relay

from .browser import Browser

pytestmark = needs.programs("chromium")

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


def test_the_page_does_so_over_a_real_link(tmp_path):
    """0.4 Mbit/s, of which a best frame takes seconds."""
    with Serving("--scene", "room", "--web", "127.0.0.1:*") as server:
        place, _, rest = server.line("for a browser").split()[-1].partition("/?")
        with Relay(int(place.rpartition(":")[2])) as relay, Browser(tmp_path / "profile") as browser:
            browser.open(f"http://{relay.address}/?{rest}&trace=walk&size=640")
            browser.until("hmdwarp.session.shown")
            relay.bytes_s = 50_000  # scripts of the page have crossed
            best = browser.does("hmdwarp.session.shown.size[0]")
            # What a stalled machine passes on in a lump is measured as more, for a while.
            narrow = "hmdwarp.session.pace.wish.mbit > 0 && hmdwarp.session.pace.mbit < 1"
            browser.until(f"{narrow} && hmdwarp.session.shown.size[0] <= {best} * 0.75")
