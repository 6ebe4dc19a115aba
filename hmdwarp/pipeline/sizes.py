"""How large the pictures of a run are, and whether this machine has room for them."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from ..client.weight import EyeSizes, eye_bytes
from ..errors import InputError, MachineError
from ..frames.frame import Needs
from ..geometry import Eyes, Pose, guarded_eyes
from ..geometry.cube import cube_size
from ..geometry.wide import wide_size
from ..gpu.context import Gpu
from ..gpu.textures import check_size

Size = tuple[int, int]


def guarded_size(guard: float, eyes: Eyes, size: Size) -> Size:
    """(w, h) of what the server draws for one eye. Errors: InputError for a guard that leaves the half-space in front of the eye."""
    try:
        return guarded_eyes(eyes.views(Pose()), guard, size)[1]
    except InputError as error:
        raise InputError(f"guard {guard:g} on {_named(eyes)}: {error}; use a smaller guard") from error


def _named(eyes: Eyes) -> str:
    name = getattr(eyes, "name", "")
    return f"headset '{name}'" if name else "these eyes"


def eye_sizes(guard: float, eyes: Eyes, size: Size) -> EyeSizes:
    """What one eye's pictures measure, the larger eye's where they differ. size: as shown. Errors: as guarded_size."""
    views = eyes.views(Pose())
    cubes = [cube_size(view.fov, size) for view in views]
    return EyeSizes(
        guarded_size(guard, eyes, size), size, max(cubes), _largest([wide_size(view.fov, size) for view in views])
    )


def _largest(sizes: Sequence[Size]) -> Size:
    return max(w for w, _ in sizes), max(h for _, h in sizes)


def check_room(gpu: Gpu, needs: Needs, sizes: EyeSizes, guard: float, frames: int, latency_ms: float) -> None:
    """Errors: InputError beyond the GL limit; MachineError where the frames under way alone would fill the machine's memory."""
    check_size(gpu.gl, sizes.shown)
    rendered_size = sizes.rendered
    if max(rendered_size) > gpu.max_texture_size:
        found = f"guard {guard:g} makes frames of {rendered_size[0]}x{rendered_size[1]} pixels"
        raise InputError(f"{found}: wanted at most {gpu.max_texture_size} on each side (this GPU's limit)")
    needed = frames * 2 * sum(eye_bytes(needs, sizes).values())
    if gpu.is_software and needed > memory_bytes():
        raise MachineError(
            f"latency {latency_ms:g} ms keeps {frames} frames of 2x{rendered_size[0]}x{rendered_size[1]} pixels, {needed / 1e9:.1f} GB, "
            f"and this machine has {memory_bytes() / 1e9:.1f} GB: use a smaller size, a shorter latency or a lower rate"
        )


def memory_bytes() -> float:
    """Of the whole machine; infinite where it does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return math.inf
