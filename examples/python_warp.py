# Shows: a warp in Python, on NumPy arrays, in a replay, in a bench and on one frame.
# Writes: replay (a replay's folder), bench (a bench's folder), frame.png

import sys
from pathlib import Path

import numpy as np
from PIL import Image

import hmdwarp
from hmdwarp import Fov, Pose, RunOptions, View, WarpMap
from hmdwarp.client.warp_kinds import ArrayWarp
from hmdwarp.client.warps import warps


@warps.register
class Median(ArrayWarp):
    """Moves the rendered image as a wall at its median depth."""

    name, summary, source = "median", "moves the image as a wall at its median depth", "examples/python_warp.py"
    exact_when, gets_wrong = "everything lies on the wall", "what is nearer moves too little, what is farther too much"

    def warp(self, colour, depth_m, rendered, shown):
        high, wide = depth_m.shape
        x, y = np.meshgrid(*(np.arange(side) + 0.5 for side in self.shown_size))
        to_rendered = WarpMap.between(shown, self.shown_size, rendered, (wide, high))
        pixels = np.dstack([x, y[::-1]])  # pixel coordinates run upwards, rows of arrays downwards
        place, _, _ = to_rendered.apply(pixels, np.nanmedian(1 / depth_m))
        column, row = place[..., 0] // 1, high - 1 - place[..., 1] // 1
        seen = (column >= 0) & (column < wide) & (row >= 0) & (row < high)
        return colour[np.where(seen, row, 0).astype(int), np.where(seen, column, 0).astype(int)], seen


out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/python_warp")
few = {"headset": "rift-dk1", "seconds": 0.3, "workers": 0}
print(hmdwarp.replay(RunOptions(trace="walk", warp="median", size=(96, 120), out=out / "replay", **few)))

case = {"recordings": ("walk",), "scenes": ("planes",), "latencies_ms": (100.0,), "sizes": ((64, 80),), "instants": 2}
case |= {"warps": ("median", "rotation"), "fills": ("none",), "out": out / "bench"}
hmdwarp.bench.bench(hmdwarp.bench.BenchOptions(**case, **few))
print({row["warp"]: round(row["flip"], 3) for row in hmdwarp.bench.read(out / "bench")})
colour = np.random.default_rng(1).integers(0, 255, (80, 120, 3), np.uint8)
views = (View(Pose((x, 0, 0)), Fov.symmetric(*np.radians((90, 60)))) for x in (0, 0.1))
frame = hmdwarp.warp_image(colour, np.full((80, 120), 2.0), *views, warp="median")
Image.fromarray(frame.colour).save(out / "frame.png")
