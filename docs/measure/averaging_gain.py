"""What averaging late frames gains, or loses, where it could fail: a table of results-warps.md.

Lost frames, other rates, and frames of a renderer that accumulates by itself: recursive temporal
antialiasing as engines have it, made here from the scenes. Each row is the default warp less one
bilinear frame, paired over the refreshes of a replay 200 ms late.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from apparatus import options, print_table
from scipy import ndimage

import hmdwarp
from hmdwarp.base import srgb8_from_linear
from hmdwarp.geometry import Fov, View
from hmdwarp.gpu import Gpu, download
from hmdwarp.poses import load_trace
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

COMMON = {
    "latency": 200.0, "warp": "iterative", "fill": "memory+pyramid", "images": 0, "force": True,
    "against": "iterative:frames=1,resample=bilinear+memory+pyramid",
}  # fmt: skip
WALK = {"trace": "walk", "scene": "room", "headset": "rift-dk1", "size": "320x400", "seconds": 0.8, "metrics_every": 2}
LINKS: dict[str, dict[str, object]] = {
    "`room`": {},
    "`room`, 10 % lost": {"loss": "0.1"},
    "`room`, 10 % lost, three in a row": {"loss": "0.1", "loss_burst": 3.0},
    "`room`, 90 Hz": {"rate": 90.0},
    "`room`, renderer of 30 Hz": {"server_rate": 30.0},
}
SIZE, RATE_HZ, FRAMES, BEGINS_S = (400, 320), 30, 36, 2.0
FOV = Fov.from_tangents((-1.0, 1.0, -SIZE[1] / SIZE[0], SIZE[1] / SIZE[0]))
SHARE = 0.1  # of each new frame
JITTERED = 8  # frames until the jitter repeats


def halton(number: int, base: int) -> float:
    """Return a number of the low-discrepancy sequence (Halton 1960), 0 to 1."""
    found, part = 0.0, 1.0
    while number:
        number, digit = divmod(number, base)
        part /= base
        found += part * digit
    return found


def jittered(view: View, number: int) -> View:
    """Return the view that draws everything up to half a pixel beside."""
    left, right, down, up = view.fov.tangents
    x = (halton(number % JITTERED + 1, 2) - 0.5) * (right - left) / SIZE[0]
    y = (halton(number % JITTERED + 1, 3) - 0.5) * (up - down) / SIZE[1]
    return View(view.pose, Fov.from_tangents((left - x, right - x, down - y, up - y)))


def carried(history: np.ndarray, then: View, view: View, inverse_depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the picture before where the surfaces of `view` were in it, and where that was."""
    left, right, down, up = FOV.tangents
    x, y = np.meshgrid(*(np.arange(side) + 0.5 for side in SIZE))
    rays = np.stack([left + x * (right - left) / SIZE[0], up - y * (up - down) / SIZE[1], np.full_like(x, -1)], -1)
    places = view.pose.relative_to(then.pose).transform(rays / np.maximum(inverse_depth, 1e-6)[..., None])
    across, high = places[..., 0] / -places[..., 2], places[..., 1] / -places[..., 2]
    at = (up - high) / (up - down) * SIZE[1] - 0.5, (across - left) / (right - left) * SIZE[0] - 0.5
    inside = (at[0] >= 0) & (at[0] <= SIZE[1] - 1) & (at[1] >= 0) & (at[1] <= SIZE[0] - 1)
    looked = [ndimage.map_coordinates(history[..., k], at, order=1, mode="nearest") for k in range(3)]
    return np.stack(looked, axis=-1), inside


def write_accumulated(scene: str, folder: Path) -> None:
    """Write frames of a walk, each a tenth of its own; of those before, what 3 x 3 texels allow."""
    track, history, then = load_trace("walk").track, None, None
    folder.mkdir()
    with Gpu() as gpu:
        server = Server(gpu, load_scene(scene))
        for number in range(FRAMES):
            since_ns = round(number / RATE_HZ * 1e9)
            view = View(track.at(track.start_ns + round(BEGINS_S * 1e9) + since_ns).pose, FOV)
            inverse = np.array(download(server.draw(view, SIZE, time_ns=since_ns).inverse_depth), np.float64)
            drawn = server.draw(jittered(view, number), SIZE, time_ns=since_ns).colour
            shown = now = np.array(download(drawn)[..., :3], np.float64)
            if history is not None:
                least, most = (each(now, size=(3, 3, 1)) for each in (ndimage.minimum_filter, ndimage.maximum_filter))
                before, inside = carried(history, then, view, inverse)
                mixed = (1 - SHARE) * np.clip(before, least, most) + SHARE * now
                shown = np.where(inside[..., None], mixed, now)
            history, then = shown, view
            with np.errstate(divide="ignore"):
                depth = np.where(inverse < 0, np.nan, 1 / inverse)
            position, turn = view.pose.position_m, view.pose.orientation_xyzw
            fov, time_s = np.arctan(FOV.tangents), since_ns / 1e9
            about = {"fov": fov, "position_m": position, "orientation_xyzw": turn, "time_s": time_s}
            np.savez(folder / f"{number:03d}.npz", colour=srgb8_from_linear(shown), depth_m=depth, **about)


def main() -> None:
    options(__doc__)
    rows = []
    with tempfile.TemporaryDirectory() as place:
        cases = {label: {**WALK, **more} for label, more in LINKS.items()}
        for scene in ("room", "parade", "workshop"):
            write_accumulated(scene, Path(place) / scene)
            more = {"frames": str(Path(place) / scene), "guard": "1.25", "metrics_every": 1}
            cases[f"`{scene}`, recursive antialiasing"] = more
        for label, more in cases.items():
            done = hmdwarp.replay(hmdwarp.RunOptions.of({**COMMON, **more, "out": Path(place) / "out"}))
            found = done.summary["against"][0]["difference"]
            texts = [(found[name], digits) for name, digits in (("psnr_db", 2), ("flip", 3))]
            rows.append([label, *(f"{each['mean']:+.{digits}f}" for each, digits in texts)])
    print_table(["", "PSNR", "FLIP"], rows)


if __name__ == "__main__":
    main()
