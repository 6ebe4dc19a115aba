"""Warp one's own RGB-D frame: one call, one eye, no scene, no headset."""

from __future__ import annotations

import atexit
import math
import operator
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from numbers import Real
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..client.compensator import Compensator
from ..client.fills import fills
from ..client.inputs import PassInputs
from ..client.plan import PICTURE, SHOWN, SHOWN_DEPTH, Plan, build_plan
from ..client.warps import warps
from ..colour import linear_from_srgb
from ..errors import InputError, PlanError
from ..frames import EyeImage
from ..geometry import Fov, Pose, View, inverse_depth_from_metres
from ..gpu.context import Gpu
from ..gpu.textures import COLOUR, SCALAR, allocate, check_size, download, upload

NO_DEPTH = -1.0
# What float colour may be.
SRGB, LINEAR = "srgb", "linear"
ENCODINGS = (SRGB, LINEAR)
# Light above it is rare, and a picture is not lit like that in most places, nor in whole numbers:
# 8-bit values are, as floats.
_BRIGHTEST = 64.0


@attrs.frozen(eq=False)
class WarpedImage:
    """A warped picture; row 0 is at the top."""

    # (h, w, 3) in linear light; black in holes.
    colour: NDArray[np.float32]
    # (h, w), 0 in holes.
    coverage: NDArray[np.float32]
    # Milliseconds by stage name.
    time_ms: dict[str, float]
    # Share of pixels without coverage after the warp and before the fill.
    hole_share: float


def warp_image(
    colour: ArrayLike,
    depth_m: ArrayLike,
    rendered: View,
    shown: View,
    warp: str = "iterative",
    fill: str = "pyramid",
    size: tuple[int, int] | None = None,
    gpu: Gpu | None = None,
    *,
    depth_scale: float | None = None,
    encoding: str | None = None,
) -> WarpedImage:
    """Return the view `shown`, warped from a picture with depth drawn for `rendered`.

    colour: (h, w, 3), uint8 sRGB or float linear light, row 0 at the top; see `encoding`. depth_m:
    (h, w) metres along -z; inf is infinitely far; 0, negative or NaN marks a hole, which is counted
    and never spread. A pixel that a numpy.ma mask hides, in colour or depth, is a hole too. size:
    (w, h) of the result, by default the size of `colour`. gpu: a context made in the calling
    thread; by default one is made at the first call and shared by all threads, one at a time.
    depth_scale: metres per unit of depth_m, which integers must have: 0.001 for millimetres.
    encoding: "linear" or "srgb" (0..1) of float colour; by default it is linear, and values that
    look like 8 bits as floats are refused.
    Errors: InputError for arguments that do not fit; PlanError for a warp that needs more than a
    picture with depth; UnknownNameError; MachineError without OpenGL 4.3.
    """
    linear, inverse_depth = checked(colour, depth_m, depth_scale, encoding)
    for name, view in (("rendered", rendered), ("shown", shown)):
        if not isinstance(view, View):
            raise InputError(f"{name} is a {type(view).__name__}: expected a hmdwarp.View")
        if not (isinstance(view.pose, Pose) and isinstance(view.fov, Fov)):
            found = f"{type(view.pose).__name__}, {type(view.fov).__name__}"
            raise InputError(f"{name} is a View of {found}: expected View(pose, fov), a hmdwarp.Pose and a hmdwarp.Fov")
    plan = _plan(warp, fill)
    rendered_size = inverse_depth.shape[1::-1]
    shown_size = rendered_size if size is None else checked_size(size)
    with _shared_gpu() if gpu is None else gpu.current() as current:
        warped = _warp(current, plan, _Late(linear, inverse_depth, rendered), shown, shown_size)
        current.check_not_lost()
        return warped


def usable_warps() -> list[str]:
    """Return the names of warps that need no more than one picture with depth."""
    return [entry.name for entry in warps if set(entry.reads) <= set(PICTURE)]


def usable_fills() -> list[str]:
    """Return the names of fills that need no more than one picture with depth."""
    return [entry.name for entry in fills if set(entry.reads) <= {*PICTURE, SHOWN, SHOWN_DEPTH}]


def _plan(warp: str, fill: str) -> Plan:
    for kind, name, usable in (("warp", warp, usable_warps), ("fill", fill, usable_fills)):
        if not isinstance(name, str):
            raise InputError(f"{kind} is {name!r}: expected a name: {', '.join(usable())}")
    if warp == "auto":
        raise InputError(
            "warp 'auto' chooses during a run, by time and error over many pictures; for a single picture name one: "
            f"{', '.join(usable_warps())}"
        )
    try:
        return build_plan((), warp, fill, "none", client_geometry=False, brings=PICTURE)
    except PlanError as error:
        able = f"warps {', '.join(usable_warps())}; fills {', '.join(usable_fills())}"
        raise PlanError(f"{error}; a single picture has none. Usable are {able}") from error


@attrs.frozen(eq=False)
class _Late:
    linear: NDArray[np.float32]
    inverse_depth: NDArray[np.float32]
    view: View

    @property
    def size(self) -> tuple[int, int]:
        return self.inverse_depth.shape[1::-1]

    def upload(self, gpu: Gpu) -> EyeImage:
        colour, depth = allocate(gpu.gl, self.size, COLOUR), allocate(gpu.gl, self.size, SCALAR)
        upload(colour, self.linear)
        upload(depth, self.inverse_depth)
        return EyeImage(self.view, colour, depth)


def _warp(gpu: Gpu, plan: Plan, inputs: _Late, shown: View, shown_size: tuple[int, int]) -> WarpedImage:
    check_size(gpu.gl, inputs.size)
    check_size(gpu.gl, shown_size)
    rendered = inputs.upload(gpu)
    compensator = Compensator(gpu, plan, None, inputs.size, shown_size)
    try:
        gpu.timer.collect()
        result = compensator.run(PassInputs(rendered, shown))
        assert result.shown is not None and result.warped is not None, "only a fused plan lacks them"
        picture = download(result.shown.texture).astype(np.float32)
        warped = download(result.warped.texture)[..., 3]
        times = dict(gpu.timer.collect())
    finally:
        compensator.close()
        rendered.colour.release()
        rendered.inverse_depth.release()
    return WarpedImage(picture[..., :3].copy(), picture[..., 3].copy(), times, float((warped == 0).mean()))


def checked(
    colour: ArrayLike, depth_m: ArrayLike, depth_scale: float | None = None, encoding: str | None = None
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return linear colour with coverage (h, w, 4) and inverse depth (h, w), top row first.

    What a mask hides, in colour or in depth, has neither. Errors: InputError.
    """
    (colour, colour_mask), (depth_m, depth_mask) = _array("colour", colour), _array("depth_m", depth_m)
    if colour.ndim != 3 or colour.shape[2] != 3 or 0 in colour.shape:
        raise InputError(f"colour has shape {colour.shape}: expected (h, w, 3)")
    if colour.dtype != np.uint8 and colour.dtype.kind != "f":
        raise InputError(f"colour is {colour.dtype}: expected uint8 (sRGB) or a float type (linear light)")
    if depth_m.shape != colour.shape[:2] or depth_m.dtype.kind not in "fiu":
        raise InputError(
            f"depth_m is {depth_m.dtype} {depth_m.shape}: expected numbers of shape {colour.shape[:2]}, as colour has"
        )
    hidden = depth_mask | colour_mask.any(axis=2)
    colour = np.where(hidden[..., None], 0, colour).astype(colour.dtype)
    if not np.isfinite(colour).all():
        y, x = np.argwhere(~np.isfinite(colour).all(axis=2))[0]
        raise InputError(f"colour at row {y}, column {x} is not a finite number")
    linear = _in_linear_light(colour, encoding)
    metres = _in_metres(depth_m, depth_scale)
    known = metres[np.isfinite(metres) & (metres != 0) & ~hidden]
    if len(known) and (known < 0).all() or (metres < 0).all():
        raise InputError("depth_m is negative everywhere: expected metres along -z, which are above 0: negate it")
    inverse = inverse_depth_from_metres(metres)
    covered = ~(np.isnan(inverse) | hidden)
    limit = float(np.finfo(np.float16).max)
    rgba = np.concatenate([np.clip(linear, -limit, limit) * covered[..., None], covered[..., None]], axis=2)
    return rgba.astype(np.float32), np.where(covered, inverse, NO_DEPTH).astype(np.float32)


def _in_linear_light(colour: NDArray[Any], encoding: str | None) -> NDArray[Any]:
    """Return colour as linear light. Errors: InputError where the encoding is wrong or unclear."""
    if encoding not in (None, *ENCODINGS):
        raise InputError(f"encoding is {encoding!r}: expected {' or '.join(ENCODINGS)}")
    if colour.dtype == np.uint8:
        if encoding == LINEAR:
            raise InputError("colour is uint8, which is sRGB, and encoding is linear: give linear light as floats")
        return linear_from_srgb(colour)
    most = float(colour.max())
    if encoding == SRGB:
        if most > 1:
            raise InputError(f"colour goes up to {most:g}: expected sRGB as floats of 0 to 1, or as uint8")
        return linear_from_srgb(colour)
    if encoding is None and most > _BRIGHTEST and (np.median(colour) > 1 or (colour == np.rint(colour)).all()):
        raise InputError(
            f"colour is {colour.dtype} and goes up to {most:g}, where linear light has 1 for white: give 8-bit values "
            'as uint8; divide encoded ones by their white and say encoding="srgb"; or say encoding="linear" if it is '
            "light"
        )
    return colour


def _in_metres(depth: NDArray[Any], scale: float | None) -> NDArray[Any]:
    """Return depth in metres. Errors: InputError for integers of unknown unit, and a bad scale."""
    if scale is None:
        if depth.dtype.kind != "f":
            raise InputError(
                f"depth_m is {depth.dtype}, of unknown unit: give depth_scale, the metres per unit (0.001 for "
                "millimetres, 1/5000 for TUM RGB-D, 1 for whole metres), or metres as floats"
            )
        return depth
    if isinstance(scale, bool) or not isinstance(scale, Real) or not (math.isfinite(scale) and scale > 0):
        raise InputError(f"depth_scale is {scale!r}: expected metres per unit, a number above 0, such as 0.001")
    if scale > 1:
        raise InputError(
            f"depth_scale is {scale:g}: expected metres per unit, at most 1; where a metre has {scale:g} units it is "
            f"1/{scale:g}"
        )
    return depth.astype(np.float64) * float(scale)


def _array(name: str, value: ArrayLike) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return the values, and where a mask of numpy.ma hides them."""
    try:
        array = np.asanyarray(value)
    except ValueError as error:
        raise InputError(f"{name} is no array: {error}") from error
    return np.asarray(array), np.ma.getmaskarray(array)


def checked_size(size: object) -> tuple[int, int]:
    """Return (w, h) as plain integers.

    Errors: InputError for anything else; the GPU's limit is checked later.
    """
    try:
        width, height = (operator.index(side) for side in size)  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise InputError(f"size is {size!r}: expected (width, height) in whole pixels") from error
    return width, height


_shared: Gpu | None = None
_turn = threading.Lock()


@contextmanager
def _shared_gpu() -> Iterator[Gpu]:
    """Lend the shared context to this thread for the duration of the block."""
    global _shared  # noqa: PLW0603 (made late, because importing must not start a GL driver)
    with _turn:
        if _shared is None:
            _shared = Gpu()
            _shared.step_aside()
            atexit.register(_shared.close)
        with _shared.current():
            yield _shared
