"""Warp one's own RGB-D frame: one call, one eye, no scene, no headset."""

from __future__ import annotations

import atexit
import threading

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .client.compensator import Compensator
from .client.plan import build_plan
from .colour import linear_from_srgb
from .errors import InputError
from .frame import EyeImage
from .geometry import View, inverse_depth_from_metres
from .gpu.context import Gpu
from .gpu.textures import COLOUR, SCALAR, allocate, check_size, download, upload
from .scenes.effects import SceneEffect

NO_DEPTH = -1.0


@attrs.frozen(eq=False)
class WarpedImage:
    """colour (h, w, 3) linear float32, top row first; coverage (h, w) float32, 0 where nothing is known and colour is black;
    time_ms: stage name to milliseconds; hole_share: share of pixels without coverage after the warp and before the fill."""

    colour: NDArray[np.float32]
    coverage: NDArray[np.float32]
    time_ms: dict[str, float]
    hole_share: float


def warp_image(
    colour: ArrayLike,
    depth_m: ArrayLike,
    rendered: View,
    shown: View,
    warp: str = "forward",
    fill: str = "none",
    size: tuple[int, int] | None = None,
    gpu: Gpu | None = None,
) -> WarpedImage:
    """The picture `shown` should see, from a late picture drawn for `rendered`.

    colour: (h, w, 3), uint8 sRGB or float linear light, row 0 at the top. depth_m: (h, w) metres along -z; inf is infinitely far;
    0, negative or NaN is no depth: a hole, counted and never spread. size: (w, h) of the result, by default the late picture's.
    gpu: a context of one's own; by default one is made at the first call and kept. Two threads need two of them.
    Errors: InputError for arrays that do not fit; PlanError for a warp that needs more than a picture with depth;
    UnknownNameError; MachineError without OpenGL 4.3.
    """
    linear, inverse_depth = checked(colour, depth_m)
    plan = build_plan(SceneEffect.NONE, warp, fill, "none", client_geometry=False)
    gpu = gpu if gpu is not None else _shared_gpu()
    late_size = inverse_depth.shape[1::-1]
    shown_size = late_size if size is None else size
    check_size(gpu.gl, late_size)
    check_size(gpu.gl, shown_size)
    late = _uploaded(gpu, linear, inverse_depth, rendered)
    compensator = Compensator(gpu, plan, None, late_size, shown_size)
    try:
        gpu.timer.collect()
        result = compensator.run(late, shown)
        picture = download(result.shown.texture).astype(np.float32)
        warped = download(result.warped.texture)[..., 3]
        times = dict(gpu.timer.collect())
    finally:
        compensator.close()
        late.colour.release()
        late.inverse_depth.release()
    return WarpedImage(picture[..., :3].copy(), picture[..., 3].copy(), times, float((warped == 0).mean()))


def checked(colour: ArrayLike, depth_m: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(h, w, 4) linear colour with coverage and (h, w) inverse depth, top row first. Errors: InputError."""
    colour, depth_m = np.asarray(colour), np.asarray(depth_m)
    if colour.ndim != 3 or colour.shape[2] != 3 or 0 in colour.shape:
        raise InputError(f"colour has shape {colour.shape}: wanted (h, w, 3)")
    if colour.dtype != np.uint8 and colour.dtype.kind != "f":
        raise InputError(f"colour is {colour.dtype}: wanted uint8 (sRGB) or a float type (linear light)")
    if depth_m.shape != colour.shape[:2] or depth_m.dtype.kind not in "fiu":
        raise InputError(f"depth_m is {depth_m.dtype} {depth_m.shape}: wanted numbers of shape {colour.shape[:2]}, as colour has")
    linear = linear_from_srgb(colour) if colour.dtype == np.uint8 else colour
    if not np.isfinite(linear).all():
        y, x = np.argwhere(~np.isfinite(linear).all(axis=2))[0]
        raise InputError(f"colour at row {y}, column {x} is not a finite number")
    inverse = inverse_depth_from_metres(depth_m)
    covered = ~np.isnan(inverse)
    limit = float(np.finfo(np.float16).max)
    rgba = np.concatenate([np.clip(linear, -limit, limit) * covered[..., None], covered[..., None]], axis=2)
    return rgba.astype(np.float32), np.where(covered, inverse, NO_DEPTH).astype(np.float32)


def _uploaded(gpu: Gpu, linear: NDArray[np.float32], inverse_depth: NDArray[np.float32], view: View) -> EyeImage:
    size = inverse_depth.shape[1::-1]
    colour, depth = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
    upload(colour, linear)
    upload(depth, inverse_depth)
    return EyeImage(view, colour, depth)


_local = threading.local()


def _shared_gpu() -> Gpu:
    """One context per thread, closed at exit: GL contexts do not travel between threads."""
    if not hasattr(_local, "gpu"):
        _local.gpu = Gpu()
        atexit.register(_local.gpu.close)
    return _local.gpu
