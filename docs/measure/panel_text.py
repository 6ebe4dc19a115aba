"""Print how sharp text is: warped in the late frame, and as a panel; `make docs OPTIONS=panels`.

Stripes of one, two and four pixels stand for text, 1 m away, before a grey wall, seen by ten late
and ten newest eyes that are no whole pixels apart. Contrast is the standard deviation of their
light, error the root mean square of what differs, both as shares of the contrast of the scene drawn
at the newest pose.
"""

from __future__ import annotations

import numpy as np
from apparatus import options, print_table
from client_scene import ClientScene
from worlds import read

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Gpu
from hmdwarp.scenes import Panel, Quad, Scene

SIZE, PIXELS = (384, 320), (1, 2, 4)
FOV = Fov.from_tangents((-0.48, 0.48, -0.4, 0.4))
# Steps of the eye of 4 cm at most, and turns of 1 degree: late, and newest.
LATE, NEWEST = (
    [Pose((0.004 * k * s, 0.0017 * k, 0.003 * k), (0.0005 * k, 0.0008 * k * s, 0.0003 * k, 1.0)) for k in range(1, 11)]
    for s in (-1, 1)
)
WAYS = (
    ("in the late frame, warped by `rotation`", "rotation", ()),
    ("in the late frame, warped by `forward`", "forward", ()),
    ("in the late frame, warped by `iterative`", "iterative", ()),
    ("the same, `resample=catmull-rom`", "iterative:resample=catmull-rom", ()),
    ("a panel, whatever the warp", "iterative", ("panels",)),
)


def stripes(pixels: int) -> Panel:
    """Return columns of that width in the shown view: 400 pixels a metre at 1 m."""
    bright = (np.arange(320) // pixels) % 2
    image = np.repeat(np.broadcast_to(255 * bright, (240, 320)).astype(np.uint8)[..., None], 3, axis=2)
    return Panel(image, Pose((0, 0, -1.0)), (0.8, 0.6))


def middle(texture) -> np.ndarray:
    """Return the part of a picture that the panel covers."""
    return read(texture)[100:-100, 110:-110, 0]


def shares(gpu: Gpu, panel: Panel, poses: int) -> np.ndarray:
    """Return contrast and error of each way (rows), as shares of the drawn pictures' contrast."""
    wall = Quad((0.0, 0.0, -3.0), (4.0, 0, 0), (0, 4.0, 0), -1, (0.2, 0.2, 0.2)).mesh("wall")
    client = ClientScene(gpu, Scene("stripes", "", (wall,), panels=[panel]))
    found = np.zeros((len(WAYS), 2))
    for number, (_, warp, effects) in enumerate(WAYS):
        plan = build_plan(effects, warp, "none", "none", client_geometry=True)
        compensator = Compensator(gpu, plan, None, SIZE, SIZE, client)
        for late, newest in zip(LATE[:poses], NEWEST[:poses], strict=True):
            frame = client.server.draw_frame([View(late, FOV)], 0, SIZE, needs=plan.needs)
            client.receive(frame)
            drawn = middle(client.server.draw(View(newest, FOV), SIZE).colour)
            shown = compensator.run(PassInputs(frame.eyes[0], View(newest, FOV))).shown
            assert shown is not None
            picture = middle(shown.texture)
            off = np.sqrt(np.mean((picture - drawn) ** 2))
            found[number] += np.array([np.std(picture), off]) / np.std(drawn) / poses
            client.server.recycle(frame)
        compensator.close()
    client.close()
    return found


def main() -> None:
    """Print the table."""
    poses = options(__doc__, poses=(len(LATE), "late and newest eyes")).poses
    with Gpu() as gpu:
        found = np.hstack([shares(gpu, stripes(pixels), poses) for pixels in PIXELS])
    heads = ["text", *(f"stripes of {pixels} px: {what} %" for pixels in PIXELS for what in ("contrast", "error"))]
    rows = [[way, *(f"{100 * share:.0f}" for share in each)] for (way, *_), each in zip(WAYS, found, strict=True)]
    print_table(heads, rows)


if __name__ == "__main__":
    main()
