# Shows: a robot's RGB-D recording, served as a renderer and shown to a head that looks around.
# Writes: recording (frames with depth), live (a live run's folder)

import sys
from pathlib import Path

import numpy as np

import hmdwarp
from hmdwarp import Fov, Pose, View
from hmdwarp.run import LiveOptions, live

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/robot_recording")
(out / "recording").mkdir(parents=True, exist_ok=True)

# What a robot would have recorded: 10 frames a second of a drive along a corridor with stripes.
size, fov = (96, 72), Fov.symmetric(*np.radians((100, 84)))
rays = View(Pose(), fov).rays(size)[::-1]  # (h, w, 3), row 0 at the top; z is -1
for number in range(12):
    x, z = 0.02 * number, -0.05 * number  # metres to the right, and ahead
    sides = np.where(rays[..., 0] > 0, 1.2 - x, 1.2 + x) / np.maximum(np.abs(rays[..., 0]), 1e-9)
    floor = np.where(rays[..., 1] < 0, 1.6, 0.9) / np.maximum(np.abs(rays[..., 1]), 1e-9)
    depth_m = np.minimum(np.minimum(sides, floor), 8.0)  # along -z, as z of the rays is -1
    stripes = 130 + 60 * np.sign(np.sin(6 * (z - depth_m)))
    colour = np.dstack([stripes, 0.7 * stripes, np.where(sides < floor, 160, 60)]).astype(np.uint8)
    pose = {"position_m": (x, 1.6, z), "orientation_xyzw": (0, 0, 0, 1)}
    facts = {"fov": (fov.left, fov.right, fov.down, fov.up), "time_s": number / 10, **pose}
    np.savez(out / "recording" / f"{number:03}.npz", colour=colour, depth_m=depth_m, **facts)

recording = hmdwarp.sequences.open(out / "recording")  # or a folder of yours: hmdwarp list layouts
print(recording)


def render(views, time_ns):
    """Return the newest frame for each eye, as many pixels as asked for, and where it was taken."""
    newest = [frame for frame in recording if frame.time_ns <= time_ns % recording[-1].time_ns][-1]
    (wide, high), (across, down) = views.size, newest.size
    at = np.ix_(np.arange(high) * down // high, np.arange(wide) * across // wide)
    return [newest.colour[at]] * len(views), [newest.depth_m[at]] * len(views), [newest.view] * len(views)


run = {"source": "offscreen", "trace": "look-around", "seconds": 2, "size": (96, 120), "out": out / "live"}
run |= {"headset": "rift-dk1"}
with hmdwarp.feed.serving(render) as address:
    print(live(LiveOptions(feed=hmdwarp.feed.FeedOptions(connect=address), **run)))
