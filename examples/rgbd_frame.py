# Shows: one RGB-D frame of your own, warped to where the head is now.
# Writes: rendered.png, shown.png

import sys
from pathlib import Path

import numpy as np
from PIL import Image

import hmdwarp
from hmdwarp import Fov, Pose, View

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/rgbd_frame")
out.mkdir(parents=True, exist_ok=True)

# A wall with a grid, 4 m away, and a blue box 1 m away. Row 0 is the top row.
height, width = 200, 320
colour = np.full((height, width, 3), 60, np.uint8)  # sRGB bytes, or floats for linear light
colour[::20], colour[:, ::20] = 255, (255, 128, 0)
depth_m = np.full((height, width), 4.0)  # metres along -z; inf is far away, 0 or NaN is no depth
colour[60:140, 120:200], depth_m[60:140, 120:200] = (40, 90, 200), 1.0

# Since it was rendered, the head has moved 8 cm to the right and turned 5 degrees to the left.
fov = Fov.symmetric(np.deg2rad(90), np.deg2rad(64))
rendered = View(Pose(position_m=(0, 1.6, 0)), fov)
turned = (0, np.sin(np.deg2rad(2.5)), 0, np.cos(np.deg2rad(2.5)))
shown = View(Pose(position_m=(0.08, 1.6, 0), orientation_xyzw=turned), fov)

warped = hmdwarp.warp_image(colour, depth_m, rendered=rendered, shown=shown, warp="iterative", fill="pyramid")
print(f"{warped.hole_share:.1%} of the pixels are new to the eye; the fill guessed them")
print({stage: f"{ms:.2f} ms" for stage, ms in warped.time_ms.items()})

Image.fromarray(colour).save(out / "rendered.png")
Image.fromarray(warped.colour).save(out / "shown.png")
