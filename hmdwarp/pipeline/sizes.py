"""Picture sizes of a run, and whether the machine has memory for them."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

from ..errors import InputError, MachineError
from ..frames import EyeSizes, Needs, frame_bytes
from ..geometry import Eyes, Guard, GuardBand, Pose, guarded_eyes
from ..gpu.context import Gpu
from ..gpu.textures import check_size

Size = tuple[int, int]


def guarded_size(guard: Guard, eyes: Eyes, size: Size) -> Size:
    """Return (w, h) of the picture that the server draws for one eye.

    Errors: InputError for a guard that leaves the half-space in front of the eye, and for a
    rendered size that does not hold the shown picture.
    """
    band = GuardBand.of(guard)
    band.check(size)
    try:
        return guarded_eyes(eyes.views(Pose()), band, size)[1]
    except InputError as error:
        raise InputError(f"{band} on {_named(eyes)}: {error}; use a smaller one") from error


def _named(eyes: Eyes) -> str:
    name = getattr(eyes, "name", "")
    return f"headset '{name}'" if name else "these eyes"


def eye_sizes(guard: Guard, eyes: Eyes, size: Size) -> EyeSizes:
    """Return the sizes that every layer is derived from.

    size: of the shown picture. Errors: as guarded_size.
    """
    return EyeSizes(guarded_size(guard, eyes, size), size, tuple(view.fov for view in eyes.views(Pose())))


def rendered_entry(guard: Guard, sizes: EyeSizes) -> dict[str, Any]:
    """Return the `rendered` of summary.json: what the server draws for one eye.

    size: [w, h]. pixels: how many times those of the shown picture. fov_deg: [across, down], of the
    left eye, on the whole.
    """
    (width, height), (shown_width, shown_height) = sizes.rendered, sizes.shown
    left, right, down, up = sizes.fovs[0].guarded(guard, sizes.shown, sizes.rendered)[0].tangents.tolist()
    degrees = [math.degrees(math.atan(high) - math.atan(low)) for low, high in ((left, right), (down, up))]
    return {
        "size": [width, height],
        "pixels": round(width * height / (shown_width * shown_height), 4),
        "fov_deg": [round(angle, 2) for angle in degrees],
    }


def rendered_text(entry: Mapping[str, Any]) -> str:
    """Return the entry in words: '1600x900, 1.41 times the pixels, 102.7 x 93.4 degrees'."""
    width, height = entry["size"]
    across, down = entry["fov_deg"]
    return f"{width}x{height}, {entry['pixels']:.2f} times the pixels, {across:.1f} x {down:.1f} degrees"


def check_room(gpu: Gpu, needs: Needs, sizes: EyeSizes, guard: Guard, frames: int, latency_ms: float) -> None:
    """Check the GL size limit and the memory.

    Errors: InputError beyond the GL limit; MachineError where the frames alone would fill the
    machine's memory.
    """
    check_size(gpu.gl, sizes.shown)
    rendered_size = sizes.rendered
    if max(rendered_size) > gpu.max_texture_size:
        found = f"{GuardBand.of(guard)} makes frames of {rendered_size[0]}x{rendered_size[1]} pixels"
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
