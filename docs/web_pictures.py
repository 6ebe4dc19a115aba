"""Draw web*.png: the page of `serve --web` in a headless Chromium, and in an emulated headset."""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent / "tests"))
from serving import Serving  # noqa: E402
from web.browser import Browser, wear  # noqa: E402
from web.looks import CLOCK, enter_vr_at_once  # noqa: E402

PICTURES = {"web.png": (1400, 800), "web-phone.png": (390, 780)}
HEADSET = {"web-headset.png": (1000, 560)}  # both eyes
SERVED = ("--scene", "room", "--web", "127.0.0.1:*", "--samples", "4")  # as by default


def sized(browser: Browser, size: tuple[int, int]) -> None:
    """Give a page exactly so many pixels."""
    width, height = size
    browser.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)


def keep(browser: Browser, name: str) -> None:
    """Write what is shown."""
    picture = Image.open(BytesIO(browser.picture())).convert("RGB")
    picture.save(DOCS / name, optimize=True)  # a palette would show bands where there are none


def main() -> None:
    """Walk for a moment, then look about in a headset, 200 ms late.

    Without figures, as the clock is not real.
    """
    with Serving(*SERVED) as server:
        address = server.line("for a browser").split()[-1]
        for name, size in {**PICTURES, **HEADSET}.items():
            with Browser(size) as browser:
                browser.send("Page.addScriptToEvaluateOnNewDocument", source=CLOCK)
                sized(browser, size)
                if name in HEADSET:
                    wear(browser)
                browser.open(f"{address}&trace=walk&latency=200&warp=iterative&crf=18&size=800")
                browser.until("hmdwarp.session.feed.socket.readyState === 1")
                if name in HEADSET:
                    enter_vr_at_once(browser)
                browser.does("stepped(45)")
                keep(browser, name)
            address = server.line("for another one").split()[-1]


if __name__ == "__main__":
    main()
