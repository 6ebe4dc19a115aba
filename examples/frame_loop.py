# Shows: a loop over many frames with one Warper, each shown for a head that went on moving.
# Writes: loop.gif

import sys
from pathlib import Path

import numpy as np
from PIL import Image

from hmdwarp import Fov, Pose, View, Warper

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/frame_loop")
out.mkdir(parents=True, exist_ok=True)

fov = Fov.symmetric(np.deg2rad(90), np.deg2rad(90))
rows, columns = np.mgrid[0:128, 0:128]
depth_m = np.where((rows - 64) ** 2 + (columns - 64) ** 2 < 30**2, 1.0, 3.0)  # a disc before a wall


def render(number: int) -> np.ndarray:
    """Return the picture of frame `number`: stripes that wander over the wall."""
    stripes = np.where((columns + 2 * number) // 16 % 2, 200, 80)
    return np.dstack([np.where(depth_m < 2, 255, stripes), stripes, stripes]).astype(np.uint8)


pictures = []
with Warper((128, 128)) as warper:  # compiles and allocates once
    for number in range(24):
        sway = 0.15 * np.sin(2 * np.pi * np.array([number, number + 4]) / 24)  # now, and 4 frames later
        rendered, shown = (View(Pose(position_m=(x, 0, 0)), fov) for x in sway)
        warped = warper.warp(render(number), depth_m, rendered, shown)
        pictures.append(Image.fromarray(warped.colour))

pictures[0].save(out / "loop.gif", save_all=True, append_images=pictures[1:], duration=80, loop=0)
