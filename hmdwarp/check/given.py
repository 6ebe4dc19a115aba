"""Read the frames that are to be checked."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import attrs
import numpy as np

from ..colour import srgb8_from_linear
from ..errors import InputError
from ..sources import sequences
from ..sources.sequences import RecordedFrame, SequenceOptions
from ..sources.sequences.recorded import in_metres
from .stated_frames import LEFT, RIGHT, StatedFrame

MOST = 24  # frames that are compared
_APART_NS = 10**8  # between two of them, where there are more
_FILES = (".npz", ".exr", ".png")


def read_stated(paths: Sequence[Path], options: SequenceOptions | None = None) -> list[StatedFrame]:
    """Return the frames of a folder, of two folders (left and right eye) or of files.

    Of more than MOST, those where the camera moves most. options: facts that the files do not say.
    Errors: InputError; as sequences.open.
    """
    if len(paths) > 1 and all(path.suffix.lower() in _FILES for path in paths):
        return [_of_file(path, options or SequenceOptions()) for path in paths]
    if len(paths) > 2:
        raise InputError(
            f"{' '.join(map(str, paths))}: expected a folder, two folders (the left and the right eye), or files"
        )
    found = [sequences.open(path, options).frames for path in paths]
    chosen = _chosen(found[0])
    if len(paths) == 1:
        return [_stated(found[0][k], None) for k in chosen]
    if len(found[0]) != len(found[1]):
        raise InputError(
            f"{paths[0]} has {len(found[0])} frames and {paths[1]} {len(found[1])}: expected one of each eye for "
            "each instant"
        )
    return [_stated(found[eye][k], eye) for k in chosen for eye in (LEFT, RIGHT)]


def _stated(frame: RecordedFrame, eye: int | None) -> StatedFrame:
    colour, depth = frame.read()
    return StatedFrame(frame.name, colour, depth.astype(np.float64), frame.view, frame.time_ns, eye)


def _of_file(path: Path, options: SequenceOptions) -> StatedFrame:
    found = sequences.read_frame(path)
    scale = options.depth_scale or found.depth_scale
    if scale is None and found.depth_m.dtype.kind != "f":
        raise InputError(
            f"{path}: depth is {found.depth_m.dtype}, of unknown unit: give --depth-scale, 1 to find it out"
        )
    colour = found.colour[..., :3]
    if colour.dtype != np.uint8:
        encoded = found.encoding == "srgb"
        colour = np.rint(255 * np.clip(colour, 0, 1)).astype(np.uint8) if encoded else srgb8_from_linear(colour)
    pictures = colour, in_metres(found.depth_m, scale or 1.0)
    view, size = found.view, colour.shape[1::-1]
    frame = RecordedFrame(path.name, 0, view.pose, view.fov, size, lambda: pictures).cropped(options.crop)
    return attrs.evolve(_stated(frame, None), time_ns=None)  # a file has no instant


def _chosen(frames: Sequence[RecordedFrame]) -> range:
    """Return the places of at most MOST frames, evenly apart, where the camera moves most."""
    if len(frames) <= MOST:
        return range(len(frames))
    between = float(np.median(np.diff([one.time_ns for one in frames])))
    step = min(max(1, round(_APART_NS / max(between, 1.0))), len(frames) // MOST)
    place = np.array([one.pose.position_m for one in frames])
    turn = np.array([one.pose.rotation_matrix.ravel() for one in frames])
    moved, turned = (np.linalg.norm(np.diff(one, axis=0), axis=1) for one in (place, turn))
    ways = sum(one / max(one.mean(), sys.float_info.min) for one in (moved, turned))
    way = np.concatenate([[0.0], np.cumsum(ways)])
    span = (MOST - 1) * step
    start = int(np.argmax(way[span:] - way[: len(way) - span]))
    return range(start, start + span + 1, step)
