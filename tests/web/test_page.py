"""The whole way: `serve --web`, the page in Chromium, a scripted head, and what it shows."""

from __future__ import annotations

import base64

import needs
import numpy as np
import pytest
from serving import Serving

from hmdwarp import Fov, Pose, View, warp_image
from hmdwarp.colour import srgb8_from_linear
from hmdwarp.gpu import download
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server
from hmdwarp.web.es_shaders import STEPS

from .browser import PACKED, Browser

pytestmark = needs.programs("chromium")

LOOK = (
    "(async () => { const { pixels, ...rest } = await hmdwarp.session.look(); "
    f"return {{...rest, pixels: ({PACKED})(pixels)}}; }})()"
)


@pytest.fixture(scope="module")
def address():
    with Serving("--scene", "room", "--web", "127.0.0.1:*") as server:
        yield server, server.line("for a browser").split()[-1]


@pytest.fixture
def page(address, tmp_path):
    """A function that opens the page with what it asks, in a browser of its own."""
    server, first = address
    opened = []

    def show(asks: str, size: tuple[int, int] = (960, 600)) -> Browser:
        browser = Browser(tmp_path, size).__enter__()
        opened.append(browser)
        browser.open(f"{getattr(server, 'next', first)}&{asks}")
        server.next = server.line("for another one").split()[-1]
        browser.until("hmdwarp.session.shown")
        return browser

    yield show
    for browser in opened:
        browser.__exit__()


def view_of(told: dict) -> View:
    return View(Pose(told["pose"]["position"], told["pose"]["orientation"]), Fov(*told["fov"]))


def picture_of(looked: dict) -> np.ndarray:
    """(h, w, 3) sRGB from the top, as the canvas had it."""
    width, height = looked["views"][0]["size"]
    return np.frombuffer(base64.b64decode(looked["pixels"]), np.uint8).reshape(height, width, 4)[::-1, :, :3]


def warped_here(looked: dict, gpu):
    """The same by hmdwarp's own warp, of what the server drew for the views that were sent."""
    late, shown, server = looked["late"][0], looked["views"][0], Server(gpu, load_scene("room"))
    frame = server.draw_frame((view_of(late),), round(looked["time"] * 1e6), tuple(late["size"]))
    light, depth = (download(texture) for texture in (frame.eyes[0].colour, frame.eyes[0].inverse_depth))
    server.close()
    colour = np.dstack([srgb8_from_linear(light[..., :3]), np.where(light[..., 3] > 0, 255, 0)]).astype(np.uint8)
    with np.errstate(divide="ignore"):
        metres = np.where(depth < 0, np.nan, 1 / depth)
    warp = f"iterative:seed=rotation,steps={STEPS}"
    return warp_image(colour, metres, view_of(late), view_of(shown), warp, "none", shown["size"], result="srgb8")


def test_what_is_shown_is_the_late_frame_warped_to_the_newest_head(page, gpu):
    looked = page("raw&trace=walk&latency=200&warp=iterative&size=200").does(LOOK)
    assert looked["age"] >= 200 and looked["chain"] == "iterative"
    here = warped_here(looked, gpu)
    seen = here.coverage > 0
    off = np.abs(picture_of(looked).astype(int) - here.colour).max(axis=-1)
    # A byte of rounding at the canvas, and one of the half floats in between; where a comparison
    # stands on the brink, another surface.
    assert seen.mean() > 0.3 and np.mean(off[seen] > 2) <= 0.01


def test_with_videos_the_codecs_loss_is_all_that_is_added(page, gpu):
    """Where the head is then, nobody chooses, so medians count.

    At CRF 10 half the pixels of a decoded picture are within two levels of 255. Codes of depth
    move others by a fraction of a pixel, and textures by as much of their contrast: twice that.
    """
    looked = page("trace=walk&latency=200&warp=iterative&size=256&crf=10").does(LOOK)
    here = warped_here(looked, gpu)
    off = np.abs(picture_of(looked).astype(int) - here.colour)[here.coverage > 0]
    assert np.median(off) <= 4 and np.percentile(off, 90) <= 20


def test_a_server_that_goes_is_told_and_taken_up_again(page):
    browser = page("raw&trace=walk&size=128")
    browser.does("hmdwarp.session.feed.socket.close()")
    browser.until("document.getElementById('told').textContent.includes('not there')")
    browser.does("globalThis.before = hmdwarp.session.shown.number")
    browser.until("hmdwarp.session.shown.number > before && !document.getElementById('told').textContent")


def test_a_lost_context_is_told(page):
    browser = page("raw&trace=walk&size=128")
    browser.does("hmdwarp.chain.gl.getExtension('WEBGL_lose_context').loseContext()")
    browser.until("document.getElementById('told').textContent.includes('graphics')")


def test_nothing_is_wrong_on_the_page(page):
    browser = page("raw&trace=none-such&size=128", (390, 700))
    browser.does("document.getElementById('more').click()")
    browser.until("document.getElementById('figures').rows.length > 5")
    assert "There is no trace none-such" in browser.does("document.getElementById('told').textContent")
    assert browser.does("document.documentElement.scrollWidth - innerWidth") <= 0
    assert browser.said == []
