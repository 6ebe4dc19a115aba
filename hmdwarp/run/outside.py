"""Warps of other libraries, run on the CPU on the same frames as a bench's combinations."""

from __future__ import annotations

import importlib
import time

import numpy as np
from numpy.typing import NDArray

from ..client.compensator import EyeResult
from ..client.inputs import PassInputs
from ..client.plan import Plan
from ..colour import linear_from_srgb, picture_from_linear
from ..geometry import View
from ..gpu.context import Gpu
from ..gpu.textures import Canvas, download, upload
from ..resources import install_line

OPENCV = "cv2.warpFrame"
# By name: the system, as in the baselines of a warp.
OUTSIDE = {OPENCV: "OpenCV"}
FAR_M = 1e4  # for what is infinitely far, which OpenCV takes for a pixel without depth
# OpenCV's threads wait busily for more work, on the cores that the next method needs.
SPIN_S = 0.02


def missing(name: str) -> str:
    """Return why one of OUTSIDE cannot run here, "" if it can."""
    try:
        found = hasattr(importlib.import_module("cv2"), "warpFrame")
    except ImportError as error:
        return f"OpenCV is not installed ({error}): {install_line('bench')}"
    return "" if found else f"this OpenCV has no warpFrame ({name} came with 5.0): {install_line('bench')}"


def opencv_camera(view: View, size: tuple[int, int]) -> NDArray[np.float64]:
    """Return the 3x3 camera matrix of a view.

    OpenCV looks along +z with y down, and has pixel centres at whole numbers.
    """
    left, right, down, up = view.fov.tangents
    wide, high = size
    x, y = wide / (right - left), high / (up - down)
    return np.array([[x, 0, -left * x - 0.5], [0, y, up * y - 0.5], [0, 0, 1]])


def opencv_motion(rendered: View, shown: View) -> NDArray[np.float64]:
    """Return the 4x4 matrix that takes points from the rendered camera to the shown one."""
    to_camera = np.diag([1.0, -1.0, -1.0, 1.0])
    return to_camera @ rendered.pose.relative_to(shown.pose).matrix() @ to_camera


def _to_nearest(camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the 4x4 shear that moves what is seen by half a pixel to the right and down.

    warpFrame rounds places down to whole pixels; after this they are rounded to the nearest.
    """
    shear = np.eye(4)
    shear[0, 2], shear[1, 2] = 0.5 / camera[0, 0], 0.5 / camera[1, 1]
    return shear


def opencv_depth(inverse_depth: NDArray[np.floating]) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return depth in metres, and the mask of the pixels that have one."""
    known = np.isfinite(inverse_depth) & (inverse_depth >= 0)
    depth = 1 / np.maximum(np.where(known, inverse_depth, 1), 1 / FAR_M)
    return depth.astype(np.float32), np.where(known, 255, 0).astype(np.uint8)


class OpenCvWarp:
    """cv2.warpFrame in place of a compensator: its picture and its time, nothing else.

    The whole rendered picture is warped with one camera, as the function demands, and the shown
    view is cut out of it. plan: what it is compared beside, for what frames must carry.
    """

    def __init__(self, gpu: Gpu, plan: Plan, shown_size: tuple[int, int]) -> None:
        self._cv2 = importlib.import_module("cv2")
        self._gpu, self.plan, self._size = gpu, plan, shown_size
        self._canvases = [Canvas(gpu.gl, shown_size) for _ in range(2)]

    def run(self, inputs: PassInputs) -> EyeResult:
        """Warp one eye's picture; its time is that of the call to OpenCV alone."""
        rendered, canvas = inputs.rendered, self._canvases[inputs.eye]
        picture = picture_from_linear(download(rendered.colour))
        depth, mask = opencv_depth(download(rendered.inverse_depth))
        camera = opencv_camera(rendered.view, rendered.size)
        motion = _to_nearest(camera) @ opencv_motion(rendered.view, inputs.shown)
        started_ns = time.perf_counter_ns()
        _, warped, covered = self._cv2.warpFrame(depth, picture, mask, motion, camera)
        done_ns = time.perf_counter_ns()
        self._gpu.timer.add("warp", (done_ns - started_ns) * 1e-6)
        cut = self._shown_part(rendered.view, rendered.size, inputs.shown)
        coverage = covered[cut] > 0
        colour = linear_from_srgb(warped[cut]) * coverage[..., None]
        upload(canvas.texture, np.dstack([colour, coverage]))
        while time.perf_counter_ns() < done_ns + SPIN_S * 1e9:  # not asleep: a core that has slept is slow for a while
            pass
        return EyeResult(inputs.middle, canvas, canvas, canvas)

    def renew(self) -> None:
        """Nothing to do: it remembers nothing."""

    def _shown_part(self, rendered: View, size: tuple[int, int], shown: View) -> tuple[slice, slice]:
        """Return the rows from the top and the columns: a guard band adds whole pixels."""
        camera, (wide, high) = opencv_camera(rendered, size), self._size
        own = opencv_camera(shown, self._size)
        x, y = (round(camera[k, 2] - own[k, 2]) for k in (0, 1))
        return np.s_[y : y + high, x : x + wide]

    def close(self) -> None:
        """Free the pictures."""
        for canvas in self._canvases:
            canvas.release()
