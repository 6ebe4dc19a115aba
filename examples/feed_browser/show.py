# A session with a feed, in a browser: frames of a server, each warped to the newest pose of a head.
#
#     hmdwarp serve --scene room --listen 127.0.0.1:5570 &
#     python examples/feed_browser/show.py 127.0.0.1:5570
#
# Then open the address that it prints. It listens on this machine alone; Ctrl-C ends it.

import io
import json
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
from PIL import Image

from hmdwarp import Fov, View, Warper, load_trace
from hmdwarp.sources.feed.caller import Viewer
from hmdwarp.sources.feed.message import HALF

SIZE, FOV = (480, 360), Fov.symmetric(np.deg2rad(90), np.deg2rad(73.74))
PAGE = b"""<!doctype html><html lang="en"><meta charset="utf-8"><title>hmdwarp feed</title>
<style>body { font: 16px sans-serif; margin: 1rem; background: #111; color: #eee }
img { width: 100%; max-width: 960px } dd { margin: 0; text-align: right }
dl { display: grid; grid-template-columns: max-content max-content; gap: .2rem 1rem }
</style><h1>A feed, warped to the newest pose</h1><img id="shown" alt="what the eye sees" src="/shown.mjpeg">
<dl><dt>latency, ms</dt><dd id="latency_ms">-</dd><dt>drawn by the server in, ms</dt><dd id="render_ms">-</dd>
<dt>age when warped, ms</dt><dd id="age_ms">-</dd><dt>frames a second</dt><dd id="rate_hz">-</dd>
<dt>frames</dt><dd id="frames">0</dd></dl>
<script>new EventSource("/figures").onmessage = (told) => {
  for (const [name, value] of Object.entries(JSON.parse(told.data))) document.getElementById(name).textContent = value
}</script></html>"""


class Session:
    """The newest picture and its figures; whoever waits is woken by the next."""

    def __init__(self) -> None:
        self.changed, self.jpeg, self.figures = threading.Condition(), b"", {}

    def run(self, address: str, trace: str = "look-around") -> None:
        """Ask, warp and show, one frame after the other."""
        head, viewer = load_trace(trace).track, Viewer(address, wish=HALF)
        frames, begun_ns = 0, time.monotonic_ns()

        def view_now() -> tuple[View, int]:
            passed_ns = (time.monotonic_ns() - begun_ns) % head.duration_ns
            return View(head.at(head.start_ns + passed_ns).pose, FOV), passed_ns

        with Warper(SIZE) as warper:
            while True:
                sent_ns, (wanted, passed_ns) = time.monotonic_ns(), view_now()
                frame = viewer.fetch(wanted, SIZE, passed_ns)
                if frame is None:
                    sys.exit(f"{address}: no frames come; start 'hmdwarp serve' there")
                there_ns, depth = time.monotonic_ns(), frame.inverse_depth(0).astype(np.float64)
                with np.errstate(divide="ignore"):
                    metres = np.where(depth < 0, np.nan, 1 / depth)
                shown = warper.warp(
                    frame.light(0).astype(np.float32), metres, frame.views[0], view_now()[0], result="srgb8"
                )
                frames += 1
                self.tell(shown.colour, {
                    "latency_ms": round((there_ns - sent_ns) / 1e6, 1),
                    "render_ms": round(frame.render_ns / 1e6, 1),
                    "age_ms": round((time.monotonic_ns() - sent_ns) / 1e6, 1),
                    "rate_hz": round(frames / (time.monotonic_ns() - begun_ns) * 1e9, 1),
                    "frames": frames,
                })  # fmt: skip

    def tell(self, picture: np.ndarray, figures: dict[str, float]) -> None:
        """Give the next picture to all that wait."""
        made = io.BytesIO()
        Image.fromarray(picture).save(made, "JPEG", quality=85)
        with self.changed:
            self.jpeg, self.figures = made.getvalue(), figures
            self.changed.notify_all()


def handler_of(session: Session) -> type[BaseHTTPRequestHandler]:
    """Return what a browser gets: the page, pictures as MJPEG, figures as server-sent events."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            kinds = {"/shown.mjpeg": "multipart/x-mixed-replace; boundary=next", "/figures": "text/event-stream"}
            if self.path not in ("/", *kinds):
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", kinds.get(self.path, "text/html; charset=utf-8"))
            self.end_headers()
            if self.path == "/":
                self.wfile.write(PAGE)
                return
            while True:
                with session.changed:
                    session.changed.wait()
                    jpeg, figures = session.jpeg, json.dumps(session.figures)
                picture = (
                    b"--next\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg) + jpeg + b"\r\n"
                )
                try:
                    self.wfile.write(picture if self.path == "/shown.mjpeg" else f"data: {figures}\n\n".encode())
                except OSError:  # the page is closed
                    return

        def log_message(self, *_: object) -> None:
            """Say nothing of each request."""

    return Handler


if __name__ == "__main__":
    session, port = Session(), int(sys.argv[2]) if len(sys.argv) > 2 else 8080
    server = ThreadingHTTPServer(("127.0.0.1", port), handler_of(session))
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    print(f"open http://127.0.0.1:{server.server_port}/", flush=True)
    session.run(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:5570")
