"""Picture sizes of a run, and whether the machine has memory for them."""

from __future__ import annotations

import math
import os

from ..errors import InputError, MachineError
from ..frames import EyeSizes, Needs, frame_bytes
from ..geometry import Eyes, Pose, guarded_eyes
from ..gpu.context import Gpu
from ..gpu.textures import check_size

Size = tuple[int, int]


def guarded_size(guard: float, eyes: Eyes, size: Size) -> Size:
    """Return (w, h) of the picture that the server draws for one eye.

    Errors: InputError for a guard that leaves the half-space in front of the eye.
    """
    try:
        return guarded_eyes(eyes.views(Pose()), guard, size)[1]
    except InputError as error:
        raise InputError(f"--guard {guard:g} on {_named(eyes)}: {error}; use a smaller guard") from error


def _named(eyes: Eyes) -> str:
    name = getattr(eyes, "name", "")
    return f"headset '{name}'" if name else "these eyes"


def eye_sizes(guard: float, eyes: Eyes, size: Size) -> EyeSizes:
    """Return the sizes that every layer is derived from.

    size: of the shown picture. Errors: as guarded_size.
    """
    return EyeSizes(guarded_size(guard, eyes, size), size, tuple(view.fov for view in eyes.views(Pose())))


def check_room(gpu: Gpu, needs: Needs, sizes: EyeSizes, guard: float, frames: int, latency_ms: float) -> None:
    """Check the GL size limit and the memory.

    Errors: InputError beyond the GL limit; MachineError where the frames alone would fill the
    machine's memory.
    """
    check_size(gpu.gl, sizes.shown)
    rendered_size = sizes.rendered
    if max(rendered_size) > gpu.max_texture_size:
        found = f"--guard {guard:g} makes frames of {rendered_size[0]}x{rendered_size[1]} pixels"
        raise InputError(f"{found}: expected at most {gpu.max_texture_size} on each side (this GPU's limit)")
    needed = frames * sum(frame_bytes(needs, sizes).values())
    if gpu.is_software and needed > memory_bytes():
        raise MachineError(
            f"--latency {latency_ms:g} ms keeps {frames} frames of 2x{rendered_size[0]}x{rendered_size[1]} pixels, "
            f"{needed / 1e9:.1f} GB, and this machine has {memory_bytes() / 1e9:.1f} GB: "
            "use a smaller --size, a shorter --latency or a lower --rate"
        )


def memory_bytes() -> float:
    """Return the memory of the whole machine, infinite where unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return math.inf
