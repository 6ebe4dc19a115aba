"""A folder of frames, each a file as `hmdwarp warp` takes it, with its pose."""

from __future__ import annotations

import reprlib
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ....colour import linear_from_srgb
from ....errors import InputError
from ....geometry import Fov
from ....poses.assumptions import Assumption, By
from ..camera import read_json, scale_of, seconds_of
from ..frame_files import JSON, NPZ, OWN_FACTS, FrameFile, assumptions_of, find_frame, is_depth
from ..options import RATE_HZ, SequenceOptions
from ..picture_files import EXR, PICTURES
from ..recorded import DEPTH_SCALE, INTRINSICS, Pictures, RecordedFrame, Sequence, as_pictures, in_metres
from . import readers
from ._base import CAMERA, SequenceReader, at_rate, pictures_in
from ._dataset import clock_of

_TIMES = ("time_ns", "time_s")
_ENCODINGS = ("srgb", "linear")  # of float colour


@readers.register
class FolderReader(SequenceReader):
    """Frames in the axes of OpenXR, with instants in time_s or time_ns, or one after the other."""

    name = "folder"
    summary = f"NAME.npz, NAME.exr + NAME.json, or NAME.png + NAME.depth.png + NAME.json; {CAMERA} for what all share"
    assumes = (
        Assumption(INTRINSICS, "fov or intrinsics in each frame", By.FILE, "--intrinsics"),
        Assumption(DEPTH_SCALE, "depth_scale; floats without one are metres", By.NOBODY, "--depth-scale"),
        *OWN_FACTS,
        attrs.evolve(clock_of(SequenceOptions()), value=f"time_s or time_ns, else {RATE_HZ:g} frames per second"),
    )

    def fits(self, path: Path) -> int:
        found = _frames_in(path)
        return 60 if found and (found[0].suffix.lower() == NPZ or found[0].with_suffix(JSON).exists()) else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        shared = read_json(path / CAMERA) if (path / CAMERA).exists() else {}
        found = [find_frame(frame, shared=shared) for frame in _frames_in(path)]
        times = _times(path, found, options)
        frames = [_frame(one, time_ns, options) for one, time_ns in zip(found, times, strict=True)]
        if not found:
            return self.made(path, frames)
        has_clock = any(key in found[0].facts for key in _TIMES)
        facts = assumptions_of(found[0], options.intrinsics, options.depth_scale)
        facts.append(clock_of(options, file="time_s or time_ns of each frame" if has_clock else ""))
        notes = dict.fromkeys(note for frame in found for note in frame.notes)
        return self.made(path, frames, assumptions=facts, notes=list(notes)[:1])


def _frames_in(path: Path) -> list[Path]:
    found = [picture for picture in pictures_in(path, (NPZ, EXR, *PICTURES)) if not is_depth(picture)]
    whole = [path for path in found if path.suffix.lower() == NPZ]
    return whole or found


def _times(path: Path, found: list[FrameFile], options: SequenceOptions) -> list[int]:
    """Return the instants that the frames state, or those of their rate. Errors: InputError."""
    stated = [frame for frame in found if any(key in frame.facts for key in _TIMES)]
    if stated and len(stated) < len(found):
        lacking = next(frame for frame in found if frame not in stated)
        raise InputError(
            f"{lacking.where}: no time_s, which {stated[0].where.name} has; expected it in all frames or in none"
        )
    if not stated or options.frames_rate_hz is not None:
        return [at_rate(options, number) for number in range(len(found))]
    times = [_time_ns(frame) for frame in found]
    return [time - min(times) for time in times]


def _time_ns(found: FrameFile) -> int:
    key = "time_ns" if "time_ns" in found.facts else "time_s"
    value: Any = found.facts[key]
    value = value.item() if isinstance(value, np.ndarray | np.generic) and value.size == 1 else value
    if key == "time_s":
        return round(seconds_of(found.where, key, value) * 1e9)
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) >= 2**63:
        raise InputError(f"{found.where}: {key} is {reprlib.repr(value)}; expected a whole number")
    return value


def _frame(found: FrameFile, time_ns: int, options: SequenceOptions) -> RecordedFrame:
    view, scale = found.view, options.depth_scale or found.depth_scale
    if scale is not None:
        scale_of(found.where, scale)
    if found.encoding not in (None, *_ENCODINGS):
        raise InputError(f"{found.where}: encoding is {found.encoding!r}; expected {' or '.join(_ENCODINGS)}")
    fov: Fov = view.fov if options.intrinsics is None else options.intrinsics.fov(found.size, str(found.path))

    def read() -> Pictures:
        colour, depth = found.arrays()
        if depth.dtype.kind != "f" and scale is None:
            raise InputError(
                f"{found.path}: depth is {depth.dtype}, of unknown unit: give --depth-scale, the metres per unit, or "
                f"depth_scale in {CAMERA}"
            )
        return _checked(found, colour, in_metres(depth, scale or 1.0))

    return RecordedFrame(found.path.name, time_ns, view.pose, fov, found.size, read, lambda: found.arrays()[1])


def _checked(found: FrameFile, colour: Any, depth: Any) -> Pictures:
    """Return the pictures of an .npz file as they must be. Errors: InputError."""
    if colour.ndim != 3 or colour.shape[2] not in (3, 4) or (colour.dtype != np.uint8 and colour.dtype.kind != "f"):
        raise InputError(f"{found.path}: colour is {colour.dtype} {colour.shape}; expected (h, w, 3) uint8 or floats")
    if depth.shape != colour.shape[:2]:
        raise InputError(f"{found.path}: depth_m has shape {depth.shape}; expected {colour.shape[:2]}, as colour has")
    if found.encoding == "srgb" and colour.dtype != np.uint8:
        light = linear_from_srgb(colour[..., :3])
        colour = np.concatenate([light, colour[..., 3:]], axis=2)
    return as_pictures(colour, depth)
