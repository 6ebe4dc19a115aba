"""Layouts in which each frame has a camera, a matrix or a file of facts of its own."""

from __future__ import annotations

import io
import reprlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....colour import linear_from_srgb
from ....errors import InputError, TraceError, are_digits, listed
from ....options.named_files import FACTS, LIST, PICTURE_FILE, content_of, enter, named_in, opened
from ....poses.assumptions import Assumption, By, first_stated
from ....poses.reading.made_rows import ColmapCamera, read_cameras, read_images
from .. import camera as _camera
from ..camera import Camera, Size, camera_of, read_json
from ..frame_files import JSON, NPZ, OWN_FACTS, FrameFile, assumptions_of, find_frame, is_depth
from ..options import RATE_HZ
from ..picture_files import EXR, PICTURES, read_depth, size_of
from ..recorded import Pictures, RecordedFrame, as_pictures, in_metres
from . import _base
from ._base import CAMERA, COLOURS, DEPTHS, MATRICES, VGA, Folder, Pair, layout

_MATRIX = "camera-intrinsics.txt"


def _sequences_in(path: Path) -> list[str]:
    return sorted({pose.parent.name for pose in path.glob("seq-*/frame-*.pose.txt")})


@layout(
    "seven_scenes",
    "7-Scenes, 12-Scenes, BundleFusion, 3RScan, 3DMatch: frame-N.color.*, frame-N.depth.* and frame-N.pose.txt, "
    f"and maybe info.txt or {_MATRIX} there or above",
    lambda path: 90 if any(path.glob("frame-*.pose.txt")) else 40 if _sequences_in(path) else 0,
    # The data set's page gives them for depth and says that neither camera was calibrated.
    camera=Camera(585.0, 585.0, 320.0, 240.0, VGA), unit=1e-3, by=By.DEFAULT, no_depth="0 or 65535", pose=MATRICES,
)  # fmt: skip
def seven_scenes(at: Folder) -> None:
    """Source: Shotton et al. 2013, Scene coordinate regression forests (its page); 3DMatch."""
    if inner := _sequences_in(at.path):
        raise InputError(f"{at.path}: holds the sequences {', '.join(inner)}: name one of these folders")
    own, depth_camera, scale = None, None, None
    # What files there or above state.
    info, file = at.first("info.txt", "_info.txt", above=True), at.first(_MATRIX, above=True)
    text = "" if info is None else content_of(info, LIST).decode("utf-8", "replace")
    if info is not None and "m_calibrationColorIntrinsic" in text:
        own, depth_camera, scale = _of_info(info, text)
    elif file is not None:
        own = depth_camera = camera_of(file, {"intrinsic_matrix": _base.matrix_in(file, 3).tolist()})
    at.state(own=own, own_scale=scale)
    if not (own or at.options.camera):
        at.notes.append("Colour and depth of 7-Scenes are of two cameras and not registered to each other.")
    _add_matching(at, "frame-*[0-9].color.*", "frame-*[0-9].depth.*", "frame-*[0-9].pose.txt", depth_camera)


def _add_matching(at: Folder, colour: str, depth: str, pose: str, depth_camera: Camera | None) -> None:
    colours, depths = at.numbered(colour), at.numbered(depth)
    poses = at.poses_in(at.numbered(pose))
    whole = sorted(colours.keys() & depths.keys() & poses.keys())
    for number in whole:
        at.add(colours[number], depths[number], number, poses[number])
    if whole:
        sizes = size_of(colours[whole[0]]), size_of(depths[whole[0]])
        at.fit = _base.through_cameras(*sizes, at.camera, depth_camera)
    at.left_out(len(colours), "no depth, or no pose of finite numbers")


def _of_info(file: Path, text: str) -> tuple[Camera | None, Camera | None, float | None]:
    values = {key.strip(): value.split() for key, _, value in (line.partition("=") for line in text.splitlines())}

    def numbers(key: str, *counts: int) -> list[float]:
        try:
            found = [float(word) for word in values.get(key, [])]
        except ValueError:
            found = []
        if len(found) not in counts or not np.isfinite(found).all():
            said = " ".join(values.get(key, [])) or "missing"
            raise InputError(f"{file}: {key} is {said}; expected {counts[0]} numbers")
        return found

    def camera(side: str) -> Camera | None:
        at = numbers(f"m_calibration{side}Intrinsic", 16, 12)
        wide, high = (round(numbers(f"m_{side.lower()}{way}", 1)[0]) for way in ("Width", "Height"))
        if (moved := f"m_calibration{side}Extrinsic") in values:
            _base.refuse_moved(f"{file}, {moved}", np.reshape(numbers(moved, 16), (4, 4)))
        return camera_of(file, {"intrinsic_matrix": [at[0:3], at[4:7], at[8:11]], "w": wide, "h": high})

    shift = _camera.number_of(file, "m_depthShift", numbers("m_depthShift", 1)[0], "units per metre, above 0", above=0)
    return camera("Color"), camera("Depth"), 1 / shift


_OFF_CENTRE = 0.15  # of a picture's side, which no camera of the set's reaches


def _scannet_file(path: Path, name: str) -> Path | None:
    """Return a file of the calibration: of the full sets, or of their frames_25k."""
    places = (path / "intrinsic" / f"{name}.txt", path / f"{name.replace('intrinsic_', 'intrinsics_')}.txt")
    return next((place for place in places if place.exists()), None)


@layout(
    "scannet", "ScanNet, extracted: color/N.jpg, depth/N.png, pose/N.txt, intrinsic/intrinsic_color.txt",
    lambda path: 88 * all((path / name).is_dir() for name in ("color", "depth", "pose"))
    * (_scannet_file(path, "intrinsic_color") is not None),
    intrinsics=("intrinsic/intrinsic_color.txt", By.FILE), unit=1e-3, world="x,z,y", pose=MATRICES,
    clock=f"{RATE_HZ:g} frames per second",
)  # fmt: skip
def scannet(at: Folder) -> None:
    """Source: Dai et al. 2017, ScanNet: richly-annotated 3D reconstructions (SensReader)."""
    for side in ("color", "depth"):
        if (file := _scannet_file(at.path, f"extrinsic_{side}")) is not None:
            _base.refuse_moved(file, _base.matrix_in(file))
    colours = {int(one.stem): one for one in _base.pictures_in(at.path / "color") if are_digits(one.stem)}
    depths = at.numbered("depth/*.png")
    first = min(colours.keys() & depths.keys(), default=None)
    if first is None:
        raise InputError(f"{at.path}: no number in both color and depth; expected {at.layout.summary}")
    stated: list[Camera | None] = []
    for file in (_scannet_file(at.path, f"intrinsic_{side}") for side in ("color", "depth")):
        matrix = np.eye(4) if file is None else _base.matrix_in(file)
        fx, fy, cx, cy = map(float, matrix[(0, 1, 0, 1), (0, 1, 2, 2)])
        if not np.isfinite(matrix).all() or min(fx, fy) <= 0:
            raise InputError(f"{file}: focal lengths {fx:g}, {fy:g}; expected a 4x4 matrix, both above 0, in pixels")
        stated.append(None if file is None else Camera(fx, fy, cx, cy))
    own, of_depth = stated
    size, depth_size = size_of(colours[first]), size_of(depths[first])
    # Sets that shrank their colour to the depth's pixels left the file of the larger one.
    if own is not None and not _centred(own, size) and size == depth_size:
        own = of_depth
    if own is not None and at.options.camera is None and not _centred(own, size):
        raise InputError(
            f"{at.path}: intrinsic_color.txt has its centre at {own.cx:g},{own.cy:g}, which is not the middle of "
            f"pictures of {size[0]}x{size[1]}: give those of the pictures by --intrinsics FX,FY,CX,CY"
        )
    at.state(own=own)
    _add_matching(at, "color/[0-9]*.*", "depth/*.png", "pose/*.txt", of_depth)


def _centred(camera: Camera, size: Size) -> bool:
    sides = zip((camera.cx, camera.cy), size, strict=True)
    return all(abs((centre + 0.5) / side - 0.5) < _OFF_CENTRE for centre, side in sides)


_CLASS, _TRAJECTORIES = "PinholeCameraTrajectory", ("camera_trajectory.json", "trajectory.json", "key.json")
_ENDS = 4096  # bytes at each end that are searched for the class


def _trajectory(path: Path) -> Path | None:
    def is_one(file: Path) -> bool:
        with opened(file, FACTS) as stream:
            head = stream.read(_ENDS)
            stream.seek(max(0, stream.seek(0, io.SEEK_END) - _ENDS))
            return _CLASS.encode() in head + stream.read()

    fitting = [file for file in sorted(path.glob("*.json")) if is_one(file)] if path.is_dir() else []
    named = [file for file in fitting if file.name in _TRAJECTORIES]
    return named[0] if named else fitting[0] if len(fitting) == 1 else None


@layout(
    "open3d", f"Open3D: color/, depth/ and {_TRAJECTORIES[0]} of class {_CLASS}",
    lambda path: 87 if (path / "depth").is_dir() and _trajectory(path) is not None else 0,
    intrinsics=("intrinsic_matrix of each frame", By.FILE), unit=1e-3, by=By.DEFAULT,
    pose="camera from world, inverted; matrices by columns", takes=("frames_camera",),
)  # fmt: skip
def open3d(at: Folder) -> None:
    """Source: Open3D documentation, io.write_pinhole_camera_trajectory, geometry.RGBDImage."""
    file = _trajectory(at.path)
    if file is None:
        raise InputError(f"{at.path}: no JSON file of class {_CLASS}; expected {at.layout.summary}")
    data, files = read_json(file), at.paired()
    cameras = data.get("parameters")
    if cameras is None and isinstance(data.get("extrinsic"), list):
        # The first Open3D wrote one intrinsic and all extrinsics.
        cameras = [{"extrinsic": one, "intrinsic": data.get("intrinsic")} for one in data["extrinsic"]]
    if not isinstance(cameras, list) or len(cameras) != len(files):
        count = len(cameras) if isinstance(cameras, list) else "no list of"
        raise InputError(f"{file}: {count} parameters for {len(files)} pictures; expected one for each")
    places = [f"{file}, parameters {number}" for number in range(len(cameras))]
    own: list[Camera] = []
    for where, parameters in zip(places, cameras, strict=True):
        intrinsic = parameters.get("intrinsic") if isinstance(parameters, dict) else None
        if not isinstance(intrinsic, dict) or (camera := camera_of(where, intrinsic)) is None:
            raise InputError(f"{where}: no intrinsic_matrix; expected intrinsic and extrinsic")
        own.append(camera)
    at.state(own=own[0])
    poses = at.poses(((place, one.get("extrinsic")) for place, one in zip(places, cameras, strict=True)), inverse=True)
    for number, (pair, pose, camera) in enumerate(zip(files, poses, own, strict=True)):
        at.add(*pair, number, pose, camera=camera if at.options.camera is None else None)


_SPARSE = ("sparse/0", "sparse", ".", "colmap/sparse/0")
_MAPS = ("depth", "depths", "depth_maps", "stereo/depth_maps")
_OWN = (".geometric.bin", ".photometric.bin")  # depth of COLMAP's stereo, in the model's unit
_CENTRE = 0.5  # of the first pixel, in COLMAP and nerfstudio
_KINDS = {"SIMPLE_PINHOLE": "f cx cy", "PINHOLE": "fx fy cx cy"}
_KINDS |= {"SIMPLE_RADIAL": "f cx cy k1", "RADIAL": "f cx cy k1 k2"}
_KINDS |= {"OPENCV": "fx fy cx cy k1 k2 p1 p2", "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"}


def _first(path: Path, places: Any) -> Path | None:
    return next((path / place for place in places if (path / place).exists()), None)


def _images(path: Path) -> Path | None:
    return _first(path, [f"{place}/images{ending}" for place in _SPARSE for ending in (".txt", ".bin")])


@layout(
    "colmap", "COLMAP: images/, sparse/0/images.txt and cameras.txt (or .bin), and depth/ or stereo/depth_maps/",
    lambda path: 70 if path.is_dir() and _images(path) is not None and _first(path, _MAPS) is not None else 0,
    intrinsics=("cameras.txt or cameras.bin, for each image", By.FILE),
    scale="1 unit of the model in its own depth maps, else to be stated",
    pose="camera from world, inverted; qw qx qy qz tx ty tz", takes=("frames_camera",),
)  # fmt: skip
def colmap(at: Folder) -> None:
    """Source: COLMAP documentation, output format (cameras, images, depth maps), camera models."""
    model = _images(at.path)
    if model is None:
        raise InputError(
            f"{at.path}: no images.txt or images.bin in {', '.join(_SPARSE)}; expected {at.layout.summary}"
        )
    try:
        images, cameras = read_images(model), read_cameras(model.with_name(f"cameras{model.suffix}"))
    except TraceError as error:
        raise InputError(str(error)) from error
    pictures, maps, chosen = at.folder("images", *COLOURS), _first(at.path, _MAPS) or at.path / _MAPS[0], []
    for number, image in enumerate(images):
        names = [maps / f"{image.name}{ending}" for ending in _OWN]
        names += [named_in(maps, image.name).with_suffix(ending) for ending in DEPTHS]
        depth = next((file for file in names if file.exists()), None)
        if depth is not None and named_in(pictures, image.name).exists():
            chosen.append((number, image, depth))
    per = Counter(str(image.camera_id) for _, image, _ in chosen)
    held, wanted = ", ".join(f"{key}: {count} images" for key, count in sorted(per.items())), at.options.frames_camera
    if wanted is not None and wanted not in per:
        raise InputError(f"{model}: --frames-camera is {wanted}; expected one of its cameras: {held}")
    if wanted or 1 < len(per) < len(chosen):  # not a camera for each image: several that moved together
        key = wanted or per.most_common(1)[0][0]
        chosen = [one for one in chosen if str(one[1].camera_id) == key]
        by = "" if wanted else ", as it has most images; --frames-camera reads another"
        left = per.total() - len(chosen)
        at.notes += [f"{left} frames of other cameras than {key} were left out{by} ({held})."] if left else []
    own = {key: _camera_of_colmap(cameras, key, model) for key in {image.camera_id for _, image, _ in chosen}}
    of_stereo = bool(chosen) and chosen[0][2].name.endswith(_OWN)
    at.state(unit=1.0 if of_stereo else None, own=next(iter(own.values()), None))
    at.depth_of = _depth_of_colmap
    for number, image, depth in chosen:
        camera = own[image.camera_id] if at.options.camera is None else None
        pose = _base.pose_of(at.axes, image.position, image.rotation)
        at.add(pictures / image.name, depth, number, pose, camera=camera)
    at.facts.append(Assumption("length", "1 m per unit of the model, whose own is any", By.DEFAULT))
    at.left_out(len(images) - per.total() + len(chosen), "no picture or no depth")


def _camera_of_colmap(cameras: dict[int, ColmapCamera], key: int, model: Path) -> Camera:
    if key not in cameras:
        raise InputError(f"{model}: its images name camera {key}; expected it in cameras{model.suffix}")
    camera = cameras[key]
    _camera.refuse_distortion(camera.where, {"camera_model": camera.model})
    names, found = _KINDS.get(camera.model, "").split(), camera.parameters
    if len(names) != len(found):
        raise InputError(f"{camera.where}: {len(found)} parameters of {camera.model}; expected {len(names)}")
    facts: dict[str, Any] = dict(zip(names, found, strict=True))
    _camera.refuse_distortion(camera.where, facts)
    fx, fy = (facts["f"], facts["f"]) if "f" in facts else (facts["fx"], facts["fy"])
    return Camera(fx, fy, facts["cx"], facts["cy"], camera.size, _CENTRE)


def _depth_of_colmap(path: Path) -> NDArray[Any]:
    """Return depth; that of COLMAP's stereo is 'width&height&channels&' and then floats by rows."""
    if not path.name.endswith(_OWN):
        return read_depth(path)
    try:
        wide, high, channels, *rest = content_of(path, PICTURE_FILE).split(b"&", 3)
        values = np.frombuffer(rest[0], "<f4").reshape(int(high), int(wide))
    except (ValueError, IndexError):
        raise InputError(f"{path}: not a depth map of COLMAP; expected width&height&1& and as many floats") from None
    if channels != b"1":
        raise InputError(f"{path}: {channels.decode('ascii', 'replace')} channels; expected 1, of depth")
    return values


_FILE, _UNIT = "transforms.json", 1e-3  # nerfstudio's own default of depth
# Keys of a frame's depth, of nerfstudio, instant-ngp and others, the first that is there; of metres
# per unit; what else is read or changes the scene for training, or the world, for all alike.
_DEPTH_KEYS = ("depth_file_path", "depth_path", "depth_file", "depth_image_path", "depth")
_SCALE_KEYS = ("depth_unit_scale_factor", "integer_depth_scale")
_READ_KEYS = (
    *(*_DEPTH_KEYS, *_SCALE_KEYS, "applied_scale", "transform_matrix", "timestamp", "time", "frames", "file_path"),
    *("aabb_scale", "scale", "offset", "applied_transform", "orientation_override", "scene_scale"),
)
# Cameras that are no pinhole, and axes that are others, where the key is true.
_REFUSED = ("is_fisheye", "fisheye", "ortho", "is_ortho", "latlong", "equirectangular", "from_mitsuba")
_SHARE_WITHIN = 1e-6


def _transforms(path: Path) -> Path:
    return path if path.name == _FILE and not path.is_dir() else path / _FILE


@layout(
    "nerfstudio", f"nerfstudio, instant-ngp: {_FILE}, whose frames have depth_file_path or depth_path",
    lambda path: 90 if _transforms(path).exists() else 0, intrinsics=("of the file or of each frame", By.FILE),
    scale=f"{' or '.join(_SCALE_KEYS)}, else {_UNIT:g} m per unit", pose=MATRICES,
    clock=(f"timestamp or time, else {RATE_HZ:g} frames per second", By.DEFAULT),
    axes="world=x,z,y head=x,y,-z",  # z up; the camera looks along -z, as in OpenGL
    looks="x right, y up, -z forward, in a world of z up",
)  # fmt: skip
def nerfstudio(at: Folder) -> None:
    """Source: nerfstudio documentation, data conventions, and its parser; nerf_loader."""
    file = _transforms(at.path)
    data = read_json(file)
    enter(file.parent)
    entries = data.get("frames")
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"{file}: frames is {reprlib.repr(entries)}; expected a list of frames")
    for key in _REFUSED:
        if any(part.get(key) for part in (data, *entries)):
            raise InputError(f"{file}: {key} is true; expected the pinhole camera and the axes of nerfstudio")
    whole = [entry for entry in entries if _depth_key(entry)]
    if not whole:
        other = dict.fromkeys(key for entry in entries for key in entry if "depth" in key.lower())
        named = f": {', '.join(other)} is not read, {' or '.join(_DEPTH_KEYS[:2])} is" if other else ""
        raise InputError(
            f"{file}: none of its {len(entries)} frames has a depth_file_path; expected depth for a warp{named}"
        )
    every = {key: value for part in (data, *whole) for key, value in part.items()}
    at.notes = _camera.unread_notes(file, every, _READ_KEYS)
    if len(whole) < len(entries):
        at.notes.insert(0, f"{len(entries) - len(whole)} frames were left out: they have no depth_file_path.")
    stated = {key: _positive(file, key, data) for key in _SCALE_KEYS if data.get(key) is not None}
    if data.get("depth_scale") is not None:
        stated["depth_scale"] = _camera.scale_of(file, data["depth_scale"])
    if len(set(stated.values())) > 1 and at.options.depth_scale is None:
        both = listed([f"{key} {value:g}" for key, value in stated.items()])
        raise InputError(f"{file}: {both} differ; expected one scale: give --depth-scale")
    scale, scale_by = first_stated(at.options.depth_scale, next(iter(stated.values()), None), None)
    if scale is None:  # by default in nerfstudio; instant-ngp has none
        scale, scale_by = _UNIT, By.FORMAT if whole[0].get(_DEPTH_KEYS[0]) else By.DEFAULT
    at.scale = scale
    unit = 1 / (_positive(file, "applied_scale", data) or 1.0)
    wheres = [f"{file}, frame {number}" for number in range(len(whole))]
    poses = at.poses(((where, one.get("transform_matrix")) for where, one in zip(wheres, whole, strict=True)), unit)
    times = _times(at, wheres, whole)
    camera, camera_by = first_stated(at.options.camera, camera_of(file, {**data, **whole[0]}, _CENTRE), None)
    for number, (where, entry, pose) in enumerate(zip(wheres, whole, poses, strict=True)):
        facts = {**data, **entry}
        own = at.options.camera or camera_of(where, facts, _CENTRE)
        if own is None:
            raise InputError(
                f"{where}: no fl_x and no camera_angle_x; expected intrinsics in the file, or --intrinsics"
            )
        if own.is_y_up:
            raise InputError(f"{where}: fy is {own.fy:g}; expected above 0, as nerfstudio has it")
        colour, depth = (_picture(file, where, name) for name in (facts.get("file_path"), _depth_key(facts)))
        at.pairs.append(Pair(colour, depth, times[number], pose, own))
    assert camera is not None, "each frame has one"
    at.facts += [_base.intrinsics_fact(camera, camera_by), _base.scale_fact(at.scale, scale_by)]


def _depth_key(entry: Mapping[str, Any]) -> Any:
    return next((entry[key] for key in _DEPTH_KEYS if entry.get(key)), None)


def _picture(file: Path, where: str, name: object) -> Path:
    if not isinstance(name, str) or not name:
        raise InputError(f"{where}: file_path is {name!r}; expected the name of a picture")
    path = named_in(file.parent, name)
    tried = [path, *(path.with_name(path.name + ending) for ending in PICTURES)] if not path.suffix else [path]
    return next((path for path in tried if path.exists()), path)


def _positive(where: str | Path, key: str, data: Mapping[str, Any]) -> float | None:
    value = data.get(key)
    return None if value is None else _camera.number_of(where, key, value, "a number above 0", above=0)


def _times(at: Folder, wheres: list[str], whole: list[Mapping[str, Any]]) -> list[int]:
    """Return the instants of all frames, and state how they are known.

    timestamp is in seconds. time is a share of the whole recording, from 0 to 1, in data sets of
    moving scenes, or a count, which then have the default rate; any other is taken for seconds.
    """
    rated = at.options.frames_rate_hz is not None
    key = next((key for key in ("timestamp", "time") if whole[0].get(key) is not None), "")
    counted = [at.instant_ns(number) for number in range(len(whole))]
    if not key or rated and key == "timestamp":
        at.clock()
        return counted
    found = [_camera.seconds_of(where, key, entry.get(key)) for where, entry in zip(wheres, whole, strict=True)]
    spread, count = max(found) - min(found), len(found) - 1
    # Shares of a whole go from 0 to 1, or to a step before 1.
    ends_at_1 = any(abs(end - 1) < _SHARE_WITHIN for end in (max(found), max(found) + spread / max(1, count)))
    if key == "time" and count and 0 <= min(found) < _SHARE_WITHIN and ends_at_1:
        at.clock(f"{RATE_HZ:g} frames per second; time is a share of the recording")
        step_ns = 1e9 / (at.options.frames_rate_hz or RATE_HZ)
        return [round((value - min(found)) / (spread or 1) * count * step_ns) for value in found]
    steps = {b - a for a, b in zip(found, found[1:], strict=False)}
    if rated or steps == {0.0} or key == "time" and steps == {1.0}:
        at.clock()
        return counted
    at.clock(f"{key}, in seconds", By.FORMAT if key == "timestamp" else By.DEFAULT)
    return [round(value * 1e9) for value in found]


def _frames_in(path: Path) -> list[Path]:
    found = [picture for picture in _base.pictures_in(path, (NPZ, EXR, *PICTURES)) if not is_depth(picture)]
    return [path for path in found if path.suffix.lower() == NPZ] or found


@layout(
    "folder",
    f"NAME.npz, NAME.exr + NAME.json, or NAME.png + NAME.depth.png + NAME.json; {CAMERA} for what all share",
    lambda path: 60 * any(one.suffix.lower() == NPZ or one.with_suffix(JSON).exists() for one in _frames_in(path)[:1]),
    intrinsics=("fov or intrinsics in each frame", By.FILE),
    scale=("depth_scale; floats without one are metres", By.DEFAULT), no_depth=OWN_FACTS[0], looks=OWN_FACTS[1],
    pose=OWN_FACTS[2], clock=(f"time_s or time_ns, else {RATE_HZ:g} frames per second", By.DEFAULT),
)  # fmt: skip
def folder(at: Folder) -> None:
    """Read frames in the axes of OpenXR, each as `hmdwarp warp` takes it."""
    shared = read_json(at.path / CAMERA) if (at.path / CAMERA).exists() else {}
    found = [find_frame(frame, shared=shared) for frame in _frames_in(at.path)]
    stated = [frame for frame in found if frame.facts.keys() & {"time_ns", "time_s"}]
    if stated and len(stated) < len(found):
        lacking = next(frame for frame in found if frame not in stated)
        raise InputError(
            f"{lacking.where}: no time_s, which {stated[0].where.name} has; expected it in all frames or in none"
        )
    own = [_time_ns(frame) for frame in stated] if at.options.frames_rate_hz is None else []
    times = [time - min(own) for time in own] or [at.instant_ns(number) for number in range(len(found))]
    at.frames = [_own_frame(at, one, time_ns) for one, time_ns in zip(found, times, strict=True)]
    if found:
        at.facts = assumptions_of(found[0], at.options.camera, at.options.depth_scale)
        at.clock(*(("time_s or time_ns of each frame", By.FILE) if stated else ()))
        at.notes = list(dict.fromkeys(note for frame in found for note in frame.notes))[:1]


def _time_ns(found: FrameFile) -> int:
    key = "time_ns" if "time_ns" in found.facts else "time_s"
    value: Any = found.facts[key]
    value = value.item() if isinstance(value, np.ndarray | np.generic) and value.size == 1 else value
    if key == "time_s":
        return round(_camera.seconds_of(found.where, key, value) * 1e9)
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) >= 2**63:
        raise InputError(f"{found.where}: {key} is {reprlib.repr(value)}; expected a whole number")
    return value


def _own_frame(at: Folder, found: FrameFile, time_ns: int) -> RecordedFrame:
    scale, camera = at.options.depth_scale or found.depth_scale, at.options.camera
    if scale is not None:
        _camera.scale_of(found.where, scale)
    if found.encoding not in (None, "srgb", "linear"):
        raise InputError(f"{found.where}: encoding is {found.encoding!r}; expected srgb or linear")

    def read() -> Pictures:
        colour, depth = found.arrays()
        if depth.dtype.kind != "f" and scale is None:
            raise InputError(
                f"{found.path}: depth is {depth.dtype}, of unknown unit: give --depth-scale, the metres per unit, or "
                f"depth_scale in {CAMERA}"
            )
        is_light, wrong = colour.dtype == np.uint8 or colour.dtype.kind == "f", ""
        if not is_light or colour.ndim != 3 or colour.shape[2] not in (3, 4):
            wrong = f"colour is {colour.dtype} {colour.shape}; expected (h, w, 3) uint8 or floats"
        elif depth.shape != colour.shape[:2]:
            wrong = f"depth_m has shape {depth.shape}; expected {colour.shape[:2]}, as colour has"
        if wrong:
            raise InputError(f"{found.path}: {wrong}")
        if found.encoding == "srgb" and colour.dtype != np.uint8:
            colour = np.concatenate([linear_from_srgb(colour[..., :3]), colour[..., 3:]], axis=2)
        return as_pictures(colour, in_metres(depth, scale or 1.0))

    fov = found.view.fov if camera is None else camera.fov(found.size, str(found.path))
    return RecordedFrame(found.path.name, time_ns, found.view.pose, fov, found.size, read, lambda: found.arrays()[1])
