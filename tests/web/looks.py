"""What the page showed, and the same by hmdwarp's own warp."""

from __future__ import annotations

import base64
from typing import Any

import attrs
import numpy as np

from hmdwarp import Fov, Pose, View, Warper
from hmdwarp.base import srgb8_from_linear
from hmdwarp.frames import Needs
from hmdwarp.frames.layers.panels import Panels
from hmdwarp.gpu import download
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server
from hmdwarp.web import STEPS

from .browser import PACKED, Browser


def _all(looks: str) -> str:
    """Return a script for what those looks found, with pixels as text."""
    return (
        f"(async () => {{ const all = []; {looks} const packed = {PACKED}; "
        "return all.map(({ pixels, ...rest }) => ({...rest, pixels: packed(pixels)})); })()"
    )


def looks(count: int) -> str:
    """Return a script for what so many refreshes in a row showed."""
    return _all(f"for (let k = 0; k < {count}; k += 1) all.push(await hmdwarp.session.look());")


# Before a page's own scripts: a clock that only `stepped` moves on, by a refresh at a time, once
# all that was asked for is there. So ages are those of a device that keeps up.
CLOCK = """
const virtual = { now: 0, refreshes: [] };
performance.now = () => virtual.now;
globalThis.requestAnimationFrame = (refresh) => virtual.refreshes.push(refresh);
globalThis.stepped = async (count) => {
  for (let k = 0; k < count; k += 1) {
    virtual.now += 1000 / 60;
    const { session } = globalThis.hmdwarp;
    globalThis.moved?.(virtual.now); // an emulated headset
    for (const refresh of virtual.refreshes.splice(0)) refresh(virtual.now);
    while (session.feed.asked.size || session.coming) await new Promise((go) => setTimeout(go, 1));
  }
};
"""


def enter_vr_at_once(browser: Browser) -> None:
    """Enter VR by CLOCK, once the window has shown something, until both eyes have."""
    browser.does("(async () => { while (!hmdwarp.session.shown) await stepped(1); await stepped(3); })()")
    browser.does("document.getElementById('enter').click()")
    browser.until("hmdwarp.session.xr")
    browser.does("(async () => { while (hmdwarp.session.shown.eyes.length < 2) await stepped(1); })()")


def look_after(browser: Browser, refreshes: int) -> dict[str, Any]:
    """Return what a refresh shows, so many later by CLOCK."""
    step = f"await stepped({refreshes - 1}); const look = hmdwarp.session.look(); await stepped(1);"
    return browser.does(_all(f"{step} all.push(await look);"))[0]


def view_of(told: dict[str, Any]) -> View:
    pose, head_from_eye = told["pose"], told.get("head_from_eye", {"position": (0, 0, 0), "orientation": (0, 0, 0, 1)})
    from_eye = Pose(head_from_eye["position"], head_from_eye["orientation"])
    return View(Pose(pose["position"], pose["orientation"]), Fov(*told["fov"]), from_eye)


def pictures_of(looked: dict[str, Any]) -> list[np.ndarray]:
    """(h, w, 3) sRGB of each eye from the top, as the canvas had it."""
    (width, height), pixels = looked["views"][0]["size"], np.frombuffer(base64.b64decode(looked["pixels"]), np.uint8)
    return [eye[::-1, :, :3] for eye in pixels.reshape(-1, height, width, 4)]


class Own:
    """hmdwarp's own warp of what the server drew for the views sent. Use it in a `with`."""

    def __init__(self, gpu, samples: int = 1, scene: str = "room") -> None:
        self._gpu, self._scene, self._warpers = gpu, load_scene(scene), {}
        self._server = Server(gpu, self._scene, samples=samples)
        self._needs = Needs(panels=Panels.something) if self._scene.panels else Needs()
        self._drawn: dict[str, list] = {}

    def _late(self, looked: dict[str, Any]) -> list:
        key = repr(looked["late"])
        if key not in self._drawn:
            views = tuple(map(view_of, looked["late"]))
            frame = self._server.draw_frame(
                views, round(looked["time"] * 1e6), tuple(looked["late"][0]["size"]), needs=self._needs
            )
            self._drawn[key] = []
            for eye in frame.eyes:
                light, depth = (download(texture) for texture in (eye.colour, eye.inverse_depth))
                colour = np.dstack([srgb8_from_linear(light[..., :3]), np.where(light[..., 3] > 0, 255, 0)])
                with np.errstate(divide="ignore"):
                    self._drawn[key].append((colour.astype(np.uint8), np.where(depth < 0, np.nan, 1 / depth)))
            self._server.recycle(frame)
        return self._drawn[key]

    def truth(self, looked: dict[str, Any], eye: int = 0) -> np.ndarray:
        """Return (h, w, 3) sRGB of the view that was shown, as the server draws it."""
        shown = looked["views"][eye]
        frame = self._server.draw_frame((view_of(shown),), round(looked["time"] * 1e6), tuple(shown["size"]))
        light = download(frame.eyes[0].colour)
        self._server.recycle(frame)
        return srgb8_from_linear(light[..., :3])

    def warped(self, looked: dict[str, Any], eye: int = 0):
        """Return what Warper returns for an eye of a refresh."""
        late, shown = looked["late"][eye], looked["views"][eye]
        colour, metres = self._late(looked)[eye]
        warp = f"iterative:frames=1,seed=rotation,steps={STEPS}"
        sizes = tuple(shown["size"]), tuple(late["size"])
        if sizes not in self._warpers:
            how = {"warp": warp, "fill": "none", "effects": "panels,occluded_panels" if self._scene.panels else "none"}
            self._warpers[sizes] = Warper(sizes[0], rendered_size=sizes[1], gpu=self._gpu, **how)
        showing = [(panel, panel.showing(round(looked["time"] * 1e6))) for panel in self._scene.panels]
        panels = [attrs.evolve(panel, pictures=panel.pictures[number]) for panel, number in showing]
        layers = {"panels": panels} if panels else {}
        return self._warpers[sizes].warp(colour, metres, view_of(late), view_of(shown), result="srgb8", layers=layers)

    def __enter__(self) -> Own:
        return self

    def __exit__(self, *_: object) -> None:
        for one in (*self._warpers.values(), self._server):
            one.close()
