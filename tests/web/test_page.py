"""The whole way: `serve --web`, the page in Chromium, a scripted head, and what it shows."""

from __future__ import annotations

import os
import time
from urllib.parse import urlsplit

import needs
import numpy as np
import page_reads
import pages
import pytest
from serving import Serving
from sources.feed.relay import Relay

from .browser import Browser, says
from .looks import CLOCK, LOOK, Own, look_after, pictures_of

pytestmark = needs.programs("chromium")

SAMPLES = 4  # of a pixel, as serve has it by default: jagged edges differ from the truth by 3 dB more


@pytest.fixture(scope="module")
def address():
    with Serving("--scene", "room", "--web", "127.0.0.1:*", "--samples", str(SAMPLES)) as server:
        yield server, server.line("for a browser").split()[-1]


@pytest.fixture
def page(address, tmp_path):
    """A function that opens the page with what it asks, in a browser of its own."""
    server, first = address
    opened = []

    def show(asks: str, size: tuple[int, int] = (960, 600), script: str = "") -> Browser:
        browser = Browser(tmp_path, size).__enter__()
        opened.append(browser)
        browser.send("Page.addScriptToEvaluateOnNewDocument", source=script)
        browser.open(f"{getattr(server, 'next', first)}&{asks}")
        server.next = server.line("for another one").split()[-1]
        browser.until("hmdwarp.session.shown" if not script else "hmdwarp.session.feed.socket.readyState === 1")
        return browser

    yield show
    for browser in opened:
        browser.__exit__()


def in_time(browser: Browser) -> dict:
    """What a refresh shows on a device that keeps up, whatever else this machine does."""
    browser.does("(async () => { while (!hmdwarp.session.shown) await stepped(1); })()")
    return browser.does(look_after(6))


def test_a_walk_200_ms_late_is_near_the_truth(page, gpu, record_property):
    """As a replay measures it: PSNR of all pixels, of frames that were coded.

    The mean of 14 refreshes of six seconds, at the quality that the page asks for by itself.
    """
    browser = page("trace=walk&latency=200&warp=iterative&size=640&crf=18", script=CLOCK)
    in_time(browser)
    found, ages = [], []
    with Own(gpu, SAMPLES) as own:
        for _ in range(14):
            looked = browser.does(look_after(24))
            off = pictures_of(looked)[0].astype(float) - own.truth(looked)
            found.append(20 * np.log10(255) - 10 * np.log10(np.mean(off**2)))
            ages.append(looked["age"])
    assert min(ages) >= 200 and max(ages) <= 200 + 2 * 1000 / 30
    record_property("psnr_db", float(np.mean(found)))  # workers send plain numbers alone
    assert np.mean(found) >= 28


@pytest.mark.parametrize("video", ["h264", "av1"])
def test_with_videos_the_codecs_loss_is_all_that_is_added(page, gpu, video):
    """At CRF 10 half the pixels of a decoded picture are within two levels of 255. Codes of depth
    move others by a fraction of a pixel, and textures by as much of their contrast: twice that.
    """
    looked = in_time(page(f"trace=walk&latency=200&warp=iterative&size=256&crf=10&codec={video}", script=CLOCK))
    assert looked["video"] == video
    with Own(gpu, SAMPLES) as own:
        here = own.warped(looked)
    off = np.abs(pictures_of(looked)[0].astype(int) - here.colour)[here.coverage > 0]
    assert np.median(off) <= 4 and np.percentile(off, 90) <= 20


def test_panels_come_once_and_stay(tmp_path, gpu):
    """As hmdwarp lays them; while a server starts anew, and once lost graphics are back."""
    (tmp_path / "secret").write_text("a shared secret", encoding="utf-8")
    options = ("--scene", "reading", "--samples", str(SAMPLES), "--token-file", str(tmp_path / "secret"), "--web")
    laid, least = "hmdwarp.session.panels.laid.length === 2", 10 + 2 * 2  # bytes, of what only says what is shown
    come = f"{laid} && hmdwarp.session.shown.panels.length === {least} && !hmdwarp.session.panels.old.length"
    with Browser(tmp_path / "profile", (400, 300)) as browser:
        browser.send("Page.addScriptToEvaluateOnNewDocument", source=HOLDS)
        with Serving(*options, "127.0.0.1:*") as server:
            address = server.line("for a browser").split()[-1]
            browser.open(f"{address}&raw&trace=walk&latency=100&warp=iterative&size=96")
            browser.until(f"{come} && hmdwarp.session.costs.iterative !== undefined")
            looked = browser.does(LOOK)
            held = browser.does("[held().made.Texture, held().made.Framebuffer]")
        with Own(gpu, SAMPLES, "reading") as own:
            here = own.warped(looked)
        off = np.abs(pictures_of(looked)[0].astype(int) - here.colour).max(axis=-1)
        # A byte of rounding at the canvas, and one of the half floats in between; where a
        # comparison stands on the brink, another surface.
        assert looked["age"] >= 100 and looked["chain"] == "iterative"
        assert (here.coverage > 0).mean() > 0.3 and np.mean((here.coverage > 0) & (off > 2)) <= 0.01
        browser.does("globalThis.least = 2")
        browser.does("setInterval(() => (least = Math.min(least, hmdwarp.session.panels.laid.length)), 4)")
        browser.until(says("Connection lost"))
        with Serving(*options, f"127.0.0.1:{urlsplit(address).port}"):
            browser.until(f"{come} && !document.getElementById('told').textContent")
            assert browser.does("[held().made.Texture, held().made.Framebuffer, least]") == [*held, 2]
            assert not [line for line in browser.said if "GL" in line]
            browser.does("globalThis.lost = hmdwarp.chain.gl.getExtension('WEBGL_lose_context'), lost.loseContext()")
            browser.until(says("graphics"))
            browser.does("lost.restoreContext()")
            browser.until(f"!globalThis.lost && {come}")


# Before a page's own scripts: notes what it holds, and calls a lost server again at once.
HOLDS = """
{
  const frames = new Set(), decoders = new Set(), answers = new Set(), made = {}, { setTimeout, fetch } = globalThis;
  let listeners = 0;
  globalThis.setTimeout = (act, ms) => setTimeout(act, Math.min(ms, 20));
  globalThis.fetch = async (...given) => {
    const answer = await fetch(...given);
    for (const one of answers) if (one.bodyUsed) answers.delete(one);
    if (given[1]?.method !== "HEAD") answers.add(answer);
    return answer;
  };
  globalThis.VideoDecoder = class extends VideoDecoder {
    constructor({ output, ...rest }) {
      super({ ...rest, output: (frame) => (frames.add(frame), output(frame)) });
      decoders.add(this);
    }
    close() {
      super.close();
      decoders.delete(this);
    }
  };
  const { close } = VideoFrame.prototype;
  VideoFrame.prototype.close = function () {
    frames.delete(this);
    close.call(this);
  };
  const { addEventListener } = EventTarget.prototype;
  EventTarget.prototype.addEventListener = function (...given) {
    listeners += this instanceof WebSocket ? 0 : 1; // a socket and its listeners go together
    return addEventListener.apply(this, given);
  };
  for (const name of Object.getOwnPropertyNames(WebGL2RenderingContext.prototype)) {
    const [, verb, kind] = name.match(/^(create|delete)(\\w+)/) ?? [];
    if (!verb) continue;
    const own = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (given) {
      made[kind] = (made[kind] ?? 0) + (verb === "create" ? 1 : given ? -1 : 0);
      return own.call(this, given);
    };
  }
  globalThis.held = () => {
    const { kept, coming } = hmdwarp.session;
    return {
      made: { ...made }, listeners, unread: [...answers].filter(({ bodyUsed }) => !bodyUsed).length,
      decoders: [...decoders].filter(({ state }) => state !== "closed").length,
      frames: frames.size - kept.length, coming, kept: kept.length,
    };
  };
}
"""
ROUNDS = int(os.environ.get("WEB_ROUNDS", "8"))  # of a stall, a cut and another head
LEAST_LEAK = 1 << 10  # bytes a round: a sixth of what the browser keeps of an answer that is not read
SETTLES = 1 << 20  # bytes, of compiled scripts and caches
MOST_ASKED = 8  # requests under way, as page/feed.js has it


def test_what_the_page_holds_stays_the_same_over_stalls_and_cuts(address, tmp_path):
    """Another head is chosen each time, too. On their way are two pictures a request.

    `make test-soak` goes on for ten minutes or more, and says what it finds on the way.
    """
    server, first = address
    here = getattr(server, "next", first)
    with Relay(int(urlsplit(here).port)) as relay, Browser(tmp_path, (240, 160)) as browser:
        browser.send("Page.addScriptToEvaluateOnNewDocument", source=HOLDS)
        browser.open(
            f"http://{relay.address}/?{urlsplit(here).query}&trace=walk&latency=0&size=64&crf=18&warp=iterative"
        )
        server.next = server.line("for another one").split()[-1]
        browser.until("hmdwarp.session.costs.iterative !== undefined")

        def goes_on_after(mend) -> None:
            browser.does("globalThis.before = hmdwarp.session.shown.number")
            mend()
            browser.until("hmdwarp.session.shown.number > before")

        def stall() -> None:
            relay.is_stalled = True
            browser.until("hmdwarp.session.feed.asked.size > 0 && hmdwarp.session.kept.length === 0")
            relay.is_stalled = False

        def cut() -> None:
            browser.does("globalThis.gone = hmdwarp.session.feed.socket, 0")
            relay.cut()
            # Frames of before may still be shown; through a stalled link no socket opens.
            browser.until("hmdwarp.session.feed.socket !== gone && hmdwarp.session.feed.socket.readyState === 1")

        def change() -> None:
            for head in ("hand", "walk"):
                browser.does(f"(head => (head.value = '{head}', head.onchange()))(document.getElementById('head'))")

        def heap(rounds: int) -> int:
            browser.send("HeapProfiler.collectGarbage")
            found = browser.send("Runtime.getHeapUsage")
            used = sum(found.get(f"{name}Size", 0) for name in ("used", "embedderHeapUsed", "backingStorage"))
            print(f"{used / 2**20:.2f} MiB after {rounds} rounds, {time.monotonic() - begun:.0f} s", flush=True)
            return used

        goes_on_after(change)
        begun = time.monotonic()
        before, used = browser.does("held()"), heap(0)
        for done in range(1, ROUNDS + 1):
            goes_on_after(stall)
            goes_on_after(cut)
            goes_on_after(change)
            if done % 10 == 0 or done == ROUNDS:
                grown = heap(done) - used
        held = browser.does("held()")
    assert grown <= SETTLES + LEAST_LEAK * ROUNDS
    assert [held[key] for key in ("made", "listeners")] == [before[key] for key in ("made", "listeners")]
    assert held["unread"] == 0  # the browser keeps such an answer and what carries it
    assert held["decoders"] == 2 and held["coming"] <= MOST_ASKED and held["kept"] <= MOST_ASKED
    assert held["frames"] <= 2 * held["coming"]


def test_a_long_press_hides_the_panel_and_a_drag_does_not(page):
    browser, hidden = page("raw&trace=walk&size=128", (600, 400)), "document.getElementById('panel').hidden"

    def mouse(*events: tuple[str, int]) -> None:
        how = {"button": "left", "buttons": 1, "clickCount": 1, "y": 200}
        browser.send_all(*(("Input.dispatchMouseEvent", {"type": f"mouse{what}", "x": x, **how}) for what, x in events))

    mouse(("Pressed", 450), ("Moved", 500))
    browser.does("new Promise((go) => setTimeout(go, 700))")  # it comes after what a press would have set off
    assert not browser.does(hidden)
    mouse(("Released", 500), ("Pressed", 450))
    browser.until(hidden)
    mouse(("Released", 450))


def test_a_busy_processor_is_not_taken_for_a_slow_link(page):
    browser = page("trace=walk&size=320")
    browser.until("hmdwarp.session.shown")
    blocks = "const then = performance.now() + 400; while (performance.now() < then);"
    browser.does(f"setInterval(() => {{ {blocks} }}, 900), 0")
    browser.does("new Promise((go) => setTimeout(go, 9000))")
    assert browser.does("hmdwarp.session.pace.mbit === Infinity && hmdwarp.session.pace.way > 0")


def test_nothing_is_wrong_on_the_page(page):
    browser = page("raw&trace=none-such&size=128", (390, 700))
    browser.does("document.getElementById('more').click()")
    browser.until("document.getElementById('rows').rows.length > 5")
    assert "There is no trace none-such" in browser.does("document.getElementById('told').textContent")
    assert "NaN" not in browser.does("document.body.innerText")
    assert browser.does("document.getElementById('chain').value === hmdwarp.session.inUse")
    panel, image = (f"document.getElementById('{name}').getBoundingClientRect()" for name in ("panel", "shown"))
    assert browser.does(f"{image}.height > 0.4 * innerHeight && {panel}.top - {image}.bottom") >= 0, "a phone's image"
    assert browser.does("document.documentElement.scrollWidth - innerWidth") <= 0
    browser.send("Emulation.setDeviceMetricsOverride", width=700, height=390, deviceScaleFactor=1, mobile=False)
    assert browser.does(f"{image}.width > 0.5 * innerWidth && {image}.left - {panel}.right") >= 0, "held sideways"
    assert browser.said == []


# Before a page's own scripts: counts what it makes on the GPU.
MADE = """
globalThis.made = {};
for (const name of Object.getOwnPropertyNames(WebGL2RenderingContext.prototype)) {
  if (!/^(create|texStorage|texImage|renderbufferStorage|bufferData|compileShader|linkProgram)/.test(name)) continue;
  const own = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...values) {
    made[name] = (made[name] ?? 0) + 1;
    return own.apply(this, values);
  };
}
"""


def test_a_session_that_goes_on_makes_nothing_on_the_gpu(page):
    browser = page("trace=walk&size=96&warp=iterative&crf=18&latency=100", (400, 300), MADE)
    browser.until("hmdwarp.session.shown && hmdwarp.session.costs.iterative !== undefined")
    for first in ("before", "after"):
        browser.does(f"made = {{ '{first}': 1 }}, globalThis.begun = hmdwarp.figures.all")
        browser.until("hmdwarp.figures.all > begun + 60")
    assert browser.does("made") == {"after": 1}


def test_the_documentation_says_what_each_chain_reads_and_moves():
    assert page_reads.table() == pages.text_of("page reads").strip()
