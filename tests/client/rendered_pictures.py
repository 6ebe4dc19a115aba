"""Rendered pictures made by hand, warped to a pose. What the tests of the gathers that search the
rendered depth share."""

from __future__ import annotations

import numpy as np
from reference.picture import GPU_SAMPLER_PIXELS, TwinInputs
from worlds import shown_by

from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, allocate

FOV = Fov.from_tangents([-1, 1, -1, 1])


def warped(
    gpu,
    spec: str,
    colour: np.ndarray,
    depth: np.ndarray,
    pose: Pose,
    rendered_pose: Pose | None = None,
    shown_size: tuple[int, int] | None = None,
    fov: Fov = FOV,
    client_depth: np.ndarray | None = None,
    depth_error: float = 0.0,
) -> np.ndarray:
    """(h, w, 4) what the eye at `pose` sees, as large as the rendered picture if nothing is said.
    All bottom row first. client_depth: what the client has drawn itself."""
    size = depth.shape[::-1]
    shown_size = shown_size or size
    textures = [allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR), allocate(gpu.gl, shown_size, SCALAR)]
    own = client_depth if client_depth is not None else np.zeros(shown_size[::-1])
    for texture, picture, dtype in zip(textures, (colour, depth, own), (np.float16, *[np.float32] * 2), strict=True):
        texture.write(np.ascontiguousarray(picture, dtype).tobytes(), alignment=1)
    rendered = EyeImage(View(rendered_pose or Pose(), fov), *textures[:2], depth_error=depth_error)
    out, _ = shown_by(gpu, spec, PassInputs(rendered, View(pose, fov), client_inverse_depth=textures[2]), shown_size)
    for texture in textures:
        texture.release()
    return out


def asked(gpu, spec: str, colour: np.ndarray, depth: np.ndarray, pose: Pose, fov: Fov = FOV) -> TwinInputs:
    """The same for a twin; half floats and floats as the GPU gets them."""
    size = depth.shape[::-1]
    stored = colour.astype(np.float16).astype(np.float64), depth.astype(np.float32).astype(np.float64)
    sampler = 4 * 2.0**-24 * max(size) if gpu.is_software else GPU_SAMPLER_PIXELS
    settings = parse_warp(spec).settings
    return TwinInputs(*stored, View(Pose(), fov), View(pose, fov), size, settings=settings, sampler_pixels=sampler)


def square_before_a_wall(thing: tuple[slice, slice], size: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Colour (its rendered inverse depth in red, x and y in green and blue) and depth. `thing` at 1
    m before a wall at 4 m."""
    y, x = np.mgrid[:size, :size]
    depth = np.full((size, size), 0.25)
    depth[thing] = 1.0
    return np.stack([depth, x / size, y / size, np.ones_like(depth)], axis=-1), depth
