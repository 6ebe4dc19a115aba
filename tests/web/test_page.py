"""The whole way: `serve --web`, the page in Chromium, a scripted head, and what it shows."""

from __future__ import annotations

import needs
import numpy as np
import pytest
from serving import Serving

from .browser import Browser, says
from .looks import CLOCK, LOOK, Own, look_after, pictures_of

pytestmark = needs.programs("chromium")


@pytest.fixture(scope="module")
def address():
    with Serving("--scene", "room", "--web", "127.0.0.1:*", "--samples", "4") as server:
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


def test_what_is_shown_is_the_late_frame_warped_to_the_newest_head(page, gpu):
    looked = page("raw&trace=walk&latency=200&warp=iterative&size=200").does(LOOK)
    assert looked["age"] >= 200 and looked["chain"] == "iterative"
    with Own(gpu, samples=4) as own:
        here = own.warped(looked)
    seen = here.coverage > 0
    off = np.abs(pictures_of(looked)[0].astype(int) - here.colour).max(axis=-1)
    # A byte of rounding at the canvas, and one of the half floats in between; where a comparison
    # stands on the brink, another surface.
    assert seen.mean() > 0.3 and np.mean(off[seen] > 2) <= 0.01


def test_a_walk_200_ms_late_is_near_the_truth(page, gpu, record_property):
    """As a replay measures it: PSNR of all pixels, of frames that were coded.

    The mean of 14 refreshes of six seconds, at the quality that the page asks for by itself.
    """
    browser = page("trace=walk&latency=200&warp=iterative&size=640&crf=18", script=CLOCK)
    browser.does("(async () => { while (!hmdwarp.session.shown) await stepped(1); })()")
    found, ages = [], []
    with Own(gpu, samples=4) as own:
        for _ in range(14):
            looked = browser.does(look_after(24))
            off = pictures_of(looked)[0].astype(float) - own.truth(looked)
            found.append(20 * np.log10(255) - 10 * np.log10(np.mean(off**2)))
            ages.append(looked["age"])
    assert min(ages) >= 200 and max(ages) <= 200 + 2 * 1000 / 30
    record_property("psnr_db", float(np.mean(found)))  # workers send plain numbers alone
    assert np.mean(found) >= 28


def test_with_videos_the_codecs_loss_is_all_that_is_added(page, gpu):
    """Where the head is then, nobody chooses, so medians count.

    At CRF 10 half the pixels of a decoded picture are within two levels of 255. Codes of depth
    move others by a fraction of a pixel, and textures by as much of their contrast: twice that.
    """
    looked = page("trace=walk&latency=200&warp=iterative&size=256&crf=10").does(LOOK)
    with Own(gpu, samples=4) as own:
        here = own.warped(looked)
    off = np.abs(pictures_of(looked)[0].astype(int) - here.colour)[here.coverage > 0]
    assert np.median(off) <= 4 and np.percentile(off, 90) <= 20


def test_a_server_that_goes_is_told_and_taken_up_again(page):
    browser = page("raw&trace=walk&size=128")
    browser.does("hmdwarp.session.feed.socket.close()")
    browser.until(says("not there"))
    browser.does("globalThis.before = hmdwarp.session.shown.number")
    browser.until("hmdwarp.session.shown.number > before && !document.getElementById('told').textContent")


def test_a_lost_context_is_told(page):
    browser = page("raw&trace=walk&size=128")
    browser.does("hmdwarp.chain.gl.getExtension('WEBGL_lose_context').loseContext()")
    browser.until(says("graphics"))


def test_nothing_is_wrong_on_the_page(page):
    browser = page("raw&trace=none-such&size=128", (390, 700))
    browser.does("document.getElementById('more').click()")
    browser.until("document.getElementById('figures').rows.length > 5")
    assert "There is no trace none-such" in browser.does("document.getElementById('told').textContent")
    assert browser.does("document.documentElement.scrollWidth - innerWidth") <= 0
    assert browser.said == []
