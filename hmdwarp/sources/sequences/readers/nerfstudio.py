"""nerfstudio: transforms.json with depth files."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ....errors import InputError
from ....poses.reading.axes import parse_axes
from ..camera import camera_of, number_of, read_json
from ..options import SequenceOptions
from ..picture_files import PICTURES, size_of
from ..recorded import RecordedFrame, Sequence
from . import readers
from ._base import SequenceReader, at_rate, made, pose_of_matrix, reading

FILE = "transforms.json"
# z up; the camera looks along -z, as in OpenGL.
_AXES = "world=x,z,y head=x,y,-z"
_UNIT = 1e-3  # of depth, where nothing says another: nerfstudio's own default
_CENTRE = 0.5  # of the first pixel


class NerfstudioReader(SequenceReader):
    """Data sets of nerfstudio that have depth.

    Source: nerfstudio documentation, data conventions; depth_unit_scale_factor and applied_scale as
    its parser of these files has them.
    """

    name = "nerfstudio"
    summary = f"nerfstudio: {FILE}, whose frames have depth_file_path"

    def fits(self, path: Path) -> int:
        return 90 if _file(path).is_file() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        file = _file(path)
        data = read_json(file)
        listed = data.get("frames")
        if not isinstance(listed, list) or not all(isinstance(entry, dict) for entry in listed):
            raise InputError(f"{file}: frames is {reprlib.repr(listed)}; expected a list of frames")
        whole = [entry for entry in listed if entry.get("depth_file_path")]
        if not whole:
            raise InputError(
                f"{file}: none of its {len(listed)} frames has a depth_file_path; expected depth for a warp"
            )
        notes = [f"{len(listed) - len(whole)} frames were left out: they have no depth_file_path."]
        frames = [_frame(file, data, one, i, options) for i, one in enumerate(whole)]
        return made(self, path, frames, notes=notes if len(whole) < len(listed) else ())


def _file(path: Path) -> Path:
    return path / FILE if path.is_dir() else path if path.name == FILE else path / FILE


def _frame(
    file: Path, data: Mapping[str, Any], own: Mapping[str, Any], number: int, options: SequenceOptions
) -> RecordedFrame:
    where = f"{file}, frame {number}"
    facts = {**data, **own}
    camera = options.intrinsics or camera_of(where, facts, _CENTRE)
    if camera is None:
        raise InputError(f"{where}: no fl_x and no camera_angle_x; expected intrinsics in the file, or --intrinsics")
    if camera.is_y_up:
        raise InputError(f"{where}: fy is {camera.fy:g}; expected above 0, as nerfstudio has it")
    colour, depth = (_picture(file, where, own.get(key)) for key in ("file_path", "depth_file_path"))
    size = size_of(colour)
    scale = options.depth_scale or _positive(where, "depth_unit_scale_factor", facts) or _UNIT
    unit = 1 / (_positive(where, "applied_scale", data) or 1.0)
    pose = pose_of_matrix(parse_axes(_AXES), where, own.get("transform_matrix"), unit)
    return RecordedFrame(
        colour.name,
        _time_ns(where, own, number, options),
        pose,
        camera.fov(size, where),
        size,
        reading(colour, depth, scale, size),
    )


def _picture(file: Path, where: str, name: object) -> Path:
    if not isinstance(name, str) or not name:
        raise InputError(f"{where}: file_path is {name!r}; expected the name of a picture")
    path = file.parent / name
    tried = [path, *(path.with_name(path.name + ending) for ending in PICTURES)] if not path.suffix else [path]
    return next((path for path in tried if path.is_file()), path)


def _positive(where: str, key: str, data: Mapping[str, Any]) -> float | None:
    value = data.get(key)
    return None if value is None else number_of(where, key, value, "a number above 0", above=0)


def _time_ns(where: str, own: Mapping[str, Any], number: int, options: SequenceOptions) -> int:
    value = own.get("timestamp", own.get("time"))
    if value is None or options.frames_rate_hz is not None:
        return at_rate(options, number)
    return round(number_of(where, "its time", value, "seconds") * 1e9)


readers.register(NerfstudioReader())
