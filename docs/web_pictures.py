"""Draw web.png and web-phone.png: the page of `serve --web` in a headless Chromium."""

from __future__ import annotations

import sys
import tempfile
from io import BytesIO
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent / "tests"))
from serving import Serving  # noqa: E402
from web.browser import Browser  # noqa: E402
from web.looks import CLOCK  # noqa: E402

PICTURES = {"web.png": (1400, 800), "web-phone.png": (390, 780)}


def main() -> None:
    """Walk for a moment, 200 ms late; without figures, as the clock is not real."""
    with tempfile.TemporaryDirectory() as folder, Serving("--scene", "room", "--web", "127.0.0.1:*") as server:
        address = server.line("for a browser").split()[-1]
        for name, (width, height) in PICTURES.items():
            with Browser(Path(folder) / name, (width, height)) as browser:
                browser.send("Page.addScriptToEvaluateOnNewDocument", source=CLOCK)
                browser.send(
                    "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False
                )
                browser.open(f"{address}&trace=walk&latency=200&warp=iterative&crf=18&size=800")
                browser.until("hmdwarp.session.feed.socket.readyState === 1")
                browser.does("stepped(45)")
                picture = Image.open(BytesIO(browser.picture())).convert("RGB")
                picture.quantize(192).save(DOCS / name, optimize=True)
            address = server.line("for another one").split()[-1]


if __name__ == "__main__":
    main()
