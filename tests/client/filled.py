"""Rendered pictures made by hand, warped and filled as a run does it.

What the tests of several fills share.
"""

from __future__ import annotations

import numpy as np
from worlds import read

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, allocate

from .rendered_pictures import FOV


def filled(
    gpu, warp: str, fill: str, colour: np.ndarray, depth: np.ndarray, pose: Pose
) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 4) after the warp and after the fills, for an eye at `pose` through FOV.

    The rendered eye stands at the origin.
    """
    size = depth.shape[::-1]
    textures = [allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)]
    for texture, picture, dtype in zip(textures, (colour, depth), (np.float16, np.float32), strict=True):
        texture.write(np.ascontiguousarray(picture, dtype).tobytes(), alignment=1)
    compensator = Compensator(gpu, build_plan((), warp, fill, "none", client_geometry=False), None, size, size)
    result = compensator.run(PassInputs(EyeImage(View(Pose(), FOV), *textures), View(pose, FOV)))
    gpu.timer.collect()
    found = read(result.warped.texture), read(result.shown.texture)
    compensator.close()
    for texture in textures:
        texture.release()
    return found
