"""nerfstudio: transforms.json with depth files."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import attrs

from ....errors import InputError, listed
from ....geometry import Pose
from ....options.named_files import enter, named_in
from ....poses.assumptions import Assumption, By, first_stated
from ....poses.reading.axes import parse_axes
from ..camera import Camera, camera_of, number_of, read_json, scale_of, seconds_of, unread_notes
from ..options import RATE_HZ, SequenceOptions
from ..picture_files import PICTURES, read_depth, size_of
from ..recorded import AXES, CLOCK, INTRINSICS, NO_DEPTH, POSE, RecordedFrame, Sequence
from . import readers
from ._base import SequenceReader, intrinsics_fact, poses_of, reading, scale_fact
from ._dataset import clock_of

FILE = "transforms.json"
# z up; the camera looks along -z, as in OpenGL.
_AXES = "world=x,z,y head=x,y,-z"
_UNIT = 1e-3  # of depth, where nothing says another: nerfstudio's own default
_CENTRE = 0.5  # of the first pixel
# Keys of a frame's depth, of nerfstudio, instant-ngp and others, the first that is there.
_DEPTHS = ("depth_file_path", "depth_path", "depth_file", "depth_image_path", "depth")
# Keys of metres per unit of depth, of nerfstudio and instant-ngp.
_SCALES = ("depth_unit_scale_factor", "integer_depth_scale")
# What else is read here, and what changes the scene for training, or the world, for all alike.
_READ = (*_DEPTHS, *_SCALES, "applied_scale", "transform_matrix", "timestamp", "time", "frames", "file_path")
_SAME_FOR_ALL = ("aabb_scale", "scale", "offset", "applied_transform", "orientation_override", "scene_scale")
# Cameras that are no pinhole, and axes that are others, where the key is true.
_REFUSED = ("is_fisheye", "fisheye", "ortho", "is_ortho", "latlong", "equirectangular", "from_mitsuba")
_SHARE_WITHIN = 1e-6


@readers.register
class NerfstudioReader(SequenceReader):
    """Data sets of nerfstudio and instant-ngp that have depth.

    Source: nerfstudio documentation, data conventions; depth_unit_scale_factor and applied_scale as
    its parser of these files has them; instant-ngp's nerf_loader (integer_depth_scale, depth_path).
    """

    name = "nerfstudio"
    summary = f"nerfstudio, instant-ngp: {FILE}, whose frames have depth_file_path or depth_path"
    assumes = (
        Assumption(INTRINSICS, "of the file or of each frame", By.FILE, "--intrinsics"),
        attrs.evolve(scale_fact(_UNIT, By.FORMAT), value=f"{' or '.join(_SCALES)}, else {_UNIT:g} m per unit"),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        Assumption(AXES, "x right, y up, -z forward, in a world of z up", By.FORMAT),
        Assumption(POSE, "world from camera, matrices by rows", By.FORMAT),
        attrs.evolve(clock_of(SequenceOptions()), value=f"timestamp or time, else {RATE_HZ:g} frames per second"),
    )

    def fits(self, path: Path) -> int:
        return 90 if _file(path).exists() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        file = _file(path)
        data = read_json(file)
        enter(file.parent)
        listed = data.get("frames")
        if not isinstance(listed, list) or not all(isinstance(entry, dict) for entry in listed):
            raise InputError(f"{file}: frames is {reprlib.repr(listed)}; expected a list of frames")
        _refuse_other_cameras(file, [data, *listed])
        whole = [entry for entry in listed if _depth_of(entry)]
        if not whole:
            raise InputError(
                f"{file}: none of its {len(listed)} frames has a depth_file_path; expected depth for a warp"
                f"{_others_named(listed)}"
            )
        every = {key: value for part in (data, *whole) for key, value in part.items()}
        notes = unread_notes(file, every, (*_READ, *_SAME_FOR_ALL))
        if len(whole) < len(listed):
            notes.insert(0, f"{len(listed) - len(whole)} frames were left out: they have no depth_file_path.")
        scale, scale_by = _scale_of(file, data, whole, options)
        unit = 1 / (_positive(file, "applied_scale", data) or 1.0)
        wheres = [f"{file}, frame {number}" for number in range(len(whole))]
        matrices = [(where, one.get("transform_matrix")) for where, one in zip(wheres, whole, strict=True)]
        poses, way = poses_of(parse_axes(_AXES), matrices, unit)
        times, clock = _times(wheres, whole, options)
        camera, camera_by = first_stated(options.intrinsics, camera_of(file, {**data, **whole[0]}, _CENTRE), None)
        frames = [
            _frame(file, where, {**data, **own}, options.intrinsics, scale, pose, time_ns)
            for where, own, pose, time_ns in zip(wheres, whole, poses, times, strict=True)
        ]
        assert camera is not None, "each frame has one"
        facts = [intrinsics_fact(camera, camera_by), scale_fact(scale, scale_by), way, clock]
        return self.made(path, frames, notes=notes, assumptions=facts)


def _file(path: Path) -> Path:
    return path / FILE if path.is_dir() else path if path.name == FILE else path / FILE


def _refuse_other_cameras(file: Path, parts: list[Mapping[str, Any]]) -> None:
    """Raise InputError for a camera or for axes that are not read."""
    for key in _REFUSED:
        if any(part.get(key) for part in parts):
            raise InputError(f"{file}: {key} is true; expected the pinhole camera and the axes of nerfstudio")


def _depth_of(own: Mapping[str, Any]) -> Any:
    return next((own[key] for key in _DEPTHS if own.get(key)), None)


def _others_named(listed: list[Mapping[str, Any]]) -> str:
    """Return what frames have in place of a depth file, in words."""
    found = dict.fromkeys(key for entry in listed for key in entry if "depth" in key.lower())
    return f": {', '.join(found)} is not read, {' or '.join(_DEPTHS[:2])} is" if found else ""


def _scale_of(
    file: Path, data: Mapping[str, Any], whole: list[Mapping[str, Any]], options: SequenceOptions
) -> tuple[float, By]:
    """Return the metres per unit of depth, and who says so.

    Errors: InputError for two that differ.
    """
    stated = {key: _positive(file, key, data) for key in _SCALES if data.get(key) is not None}
    if data.get("depth_scale") is not None:
        stated["depth_scale"] = scale_of(file, data["depth_scale"])
    if len(set(stated.values())) > 1 and options.depth_scale is None:
        both = listed([f"{key} {value:g}" for key, value in stated.items()])
        raise InputError(f"{file}: {both} differ; expected one scale: give --depth-scale")
    scale, by = first_stated(options.depth_scale, next(iter(stated.values()), None), None)
    if scale is None:
        # By default in nerfstudio; instant-ngp has none.
        return _UNIT, By.FORMAT if whole[0].get(_DEPTHS[0]) else By.NOBODY
    return scale, by


def _frame(
    file: Path, where: str, facts: Mapping[str, Any], stated: Camera | None, scale: float, pose: Pose, time_ns: int
) -> RecordedFrame:
    camera = stated or camera_of(where, facts, _CENTRE)
    if camera is None:
        raise InputError(f"{where}: no fl_x and no camera_angle_x; expected intrinsics in the file, or --intrinsics")
    if camera.is_y_up:
        raise InputError(f"{where}: fy is {camera.fy:g}; expected above 0, as nerfstudio has it")
    colour, depth = (_picture(file, where, name) for name in (facts.get("file_path"), _depth_of(facts)))
    size = size_of(colour)
    read = reading(colour, depth, scale, size)
    return RecordedFrame(colour.name, time_ns, pose, camera.fov(size, where), size, read, partial(read_depth, depth))


def _picture(file: Path, where: str, name: object) -> Path:
    if not isinstance(name, str) or not name:
        raise InputError(f"{where}: file_path is {name!r}; expected the name of a picture")
    path = named_in(file.parent, name)
    tried = [path, *(path.with_name(path.name + ending) for ending in PICTURES)] if not path.suffix else [path]
    return next((path for path in tried if path.exists()), path)


def _positive(where: str | Path, key: str, data: Mapping[str, Any]) -> float | None:
    value = data.get(key)
    return None if value is None else number_of(where, key, value, "a number above 0", above=0)


def _times(wheres: list[str], whole: list[Mapping[str, Any]], options: SequenceOptions) -> tuple[list[int], Assumption]:
    """Return the instants of all frames, and who says so.

    timestamp is in seconds. time is a share of the whole recording, from 0 to 1, in data sets of
    moving scenes, or a count, which then have the default rate; any other is taken for seconds.
    """
    step_ns = 1e9 / (options.frames_rate_hz or RATE_HZ)
    key = next((key for key in ("timestamp", "time") if whole[0].get(key) is not None), "")
    if not key or options.frames_rate_hz is not None and key == "timestamp":
        return [round(number * step_ns) for number in range(len(whole))], clock_of(options)
    values = [entry.get(key) for entry in whole]
    found = [seconds_of(where, key, one) for where, one in zip(wheres, values, strict=True)]
    if key == "time" and _is_share(found):
        last, spread = len(found) - 1, max(found) - min(found)
        times = [round((value - min(found)) / (spread or 1) * last * step_ns) for value in found]
        fact = clock_of(options)
        return times, attrs.evolve(fact, value=f"{fact.value}; time is a share of the recording")
    steps = {b - a for a, b in zip(found, found[1:], strict=False)}
    if options.frames_rate_hz is not None or steps == {0.0} or key == "time" and steps == {1.0}:
        return [round(number * step_ns) for number in range(len(whole))], clock_of(options)
    by = By.FORMAT if key == "timestamp" else By.NOBODY
    return [round(value * 1e9) for value in found], Assumption(CLOCK, f"{key}, in seconds", by, "--frames-rate")


def _is_share(times: list[float]) -> bool:
    """Return whether these are shares of a whole: from 0 to 1, or to a step before 1."""
    if len(times) < 2 or min(times) < 0 or max(times) > 1 + _SHARE_WITHIN:
        return False
    ends = max(times), max(times) + (max(times) - min(times)) / (len(times) - 1)
    return min(times) < _SHARE_WITHIN and any(abs(end - 1) < _SHARE_WITHIN for end in ends)
