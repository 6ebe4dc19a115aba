"""Layouts: a list of poses beside pictures, or a camera, matrix or file of facts for each frame."""

from __future__ import annotations

import io
import re
import reprlib
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from decimal import Decimal, InvalidOperation
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ....base import InputError, are_digits, linear_from_srgb, listed
from ....base.named_files import FACTS, LIST, PICTURE_FILE, TABLE, content_of, enter, named_in, opened, text_in
from ....poses import LoadedTrace, Origin, TraceOptions, load_trace
from ....poses.assumptions import AXES_BY, Assumption, By, first_stated
from ....poses.formats import find_format
from ....poses.reading.made_rows import ColmapCamera, read_cameras, read_images
from ....poses.reading.text_table import read_head
from .. import frame_files as _files
from ..frame_files import JSON, NPZ, OWN_FACTS, Camera, FrameFile, Size, camera_of, read_json
from ..options import RATE_HZ
from ..picture_files import EXR, NPY, PICTURES, VideoPictures, fitted_depth, read_colour, read_depth, size_of
from ..recorded import AXES, CLOCK, POSE, Pictures, RecordedFrame, as_pictures, in_metres
from . import CAMERA, COLOURS, DEPTHS, MATRICES, VGA, Folder, Pair, Row, images_in, layout, matrix_in, pose_of, rows_of

# What the authors advise for all sequences, whose depth is registered with it; those of freiburg3
# are undistorted already and have a camera of their own.
_ADVISED, FREIBURG3 = Camera(525.0, 525.0, 319.5, 239.5, VGA), Camera(535.4, 539.2, 320.1, 247.6, VGA)
_WITHIN_NS = 20_000_000  # of colour and depth of one frame, as the data set's own script has it
_SECONDS = Assumption(CLOCK, "seconds in the lists of pictures", By.FILE)


@layout(
    "tum", "TUM RGB-D: rgb.txt, depth.txt, groundtruth.txt and the pictures that they name",
    (95, "rgb.txt", "depth.txt", "groundtruth.txt"), world="x,z,y", camera=_ADVISED, unit=1 / 5000, by=By.DEFAULT,
    only_for=VGA, looks="x right, y down, z forward, in a world of z up", clock=_SECONDS,
)  # fmt: skip
def tum(at: Folder) -> None:
    """Source: Sturm et al. 2012, A benchmark for RGB-D SLAM; Schöps et al. 2019, BAD SLAM."""
    name, own = at.path.resolve().name, None
    if (file := at.path / "calibration.txt").exists():
        if len(rows := at.rows(file.name)) != 1:
            raise InputError(f"{file}: {len(rows)} lines; expected one of fx fy cx cy")
        own = Camera.of(rows[0].floats(4))
    by = By.FORMAT if own or "freiburg" in name else By.DEFAULT
    at.state(FREIBURG3 if "freiburg3" in name else _ADVISED, own=own, by=by)
    at.only_for = None if own else VGA
    trace = load_trace(at.path / "groundtruth.txt", TraceOptions(format="tum", axes=at.axes.words()))
    lists = []
    for rows in (at.rows("rgb.txt"), at.rows("depth.txt")):
        if wrong := next((row for row in rows if len(row.words) != 2), None):
            raise wrong.wrong("seconds and the name of a file")
        lists.append(sorted((row.nanoseconds(), row.words[1]) for row in rows))
    colours, depths = lists
    at.track, times, lost = trace.track, np.array([time_ns for time_ns, _ in depths]), 0
    if colours and depths:
        at.clocks = {"rgb.txt": (colours[0][0], colours[-1][0]), "depth.txt": (depths[0][0], depths[-1][0])}
        at.clocks["groundtruth.txt"] = _span(trace)
    for time_ns, colour in colours:
        nearest = int(np.abs(times - time_ns).argmin()) if depths else 0
        if depths and abs(int(times[nearest]) - time_ns) <= _WITHIN_NS:
            sample = trace.track.at(time_ns - trace.track.epoch_ns)
            if sample.origin is Origin.HELD:
                lost += 1
            else:
                files = named_in(at.path, colour), named_in(at.path, depths[nearest][1])
                at.pairs.append(Pair(*files, sample.time_ns, sample.pose))
    # Axes are the layout's, and no option changes them.
    by_layout = (str(defect).replace(AXES_BY[By.USER], AXES_BY[By.FORMAT]) for defect in trace.defects)
    at.notes += [note.replace("--axes '", "axes '") for note in by_layout]
    if at.camera is _ADVISED and re.search("freiburg[12]", name):
        at.notes += ["The lens of this camera distorts a little; the intrinsics that its authors advise leave it in."]
    if lost:
        at.notes.append(f"{lost} frames were left out: groundtruth.txt has no pose at their instants.")


def _span(trace: LoadedTrace) -> tuple[int, int]:
    track = trace.track
    return track.epoch_ns + track.start_ns, track.epoch_ns + track.end_ns


@layout(
    "icl_nuim", "ICL-NUIM: rgb/N.png, depth/N.png and *.gt.freiburg", (90, "*.gt.freiburg", "rgb"),
    camera=Camera(481.2, -480.0, 319.5, 239.5, VGA), unit=1 / 5000, only_for=VGA,
    looks="x right, y up, z forward, in a left-handed world", clock=f"{RATE_HZ:g} frames per second",
)  # fmt: skip
def icl_nuim(at: Folder) -> None:
    """Source: Handa et al. 2014, A benchmark for RGB-D visual odometry (its page)."""
    at.state()
    colours, depths = ({one.stem: one for one in images_in(at.path / side)} for side in ("rgb", "depth"))
    file = min(at.path.glob("*.gt.freiburg"), default=at.path / "trajectory.gt.freiburg")
    for row in at.rows(file.name):
        number = int(row.floats(8)[0])
        if (stem := str(number)) in colours and stem in depths:
            at.add(colours[stem], depths[stem], number, row.pose(at.axes, 1))
    at.left_out(len(colours), "they have no depth or no pose")


@layout(
    "redwood", "Redwood, Open3D: color/, depth/, trajectory.log, and maybe camera_intrinsic.json",
    lambda path: 85 if path.is_dir() and _log(path) is not None and (path / "depth").is_dir() else 0,
    camera=_ADVISED, unit=1e-3, by=By.DEFAULT, looks="x right, y down, z forward", pose=MATRICES,
    takes=("frames_camera",),
)  # fmt: skip
def redwood(at: Folder) -> None:
    """Source: Choi et al. 2015, Robust reconstruction of indoor scenes; Open3D documentation."""
    file = _log(at.path)
    if file is None:
        raise InputError(f"{at.path}: no trajectory.log; expected {at.layout.summary}")
    own = scale = None
    if named := at.first("camera_intrinsic.json", "intrinsic.json", "camera_primesense.json"):
        stated = read_json(named)
        own, scale = camera_of(named, stated), stated.get("depth_scale")
        if scale is not None:  # Open3D states units per metre
            scale = _files.number_of(named, "depth_scale", scale, "units per metre, above 0", above=0)
            scale = 1 / scale if scale >= 1 else scale
        known = ("fps", "stream_length_usec", "color_format", "depth_format", "device_name", "serial_number")
        at.notes += _files.unread_notes(named, stated, known)
    at.state(own=own, own_scale=scale)
    files, rows, found = at.paired(), at.rows(str(file.relative_to(at.path))), []
    if len(rows) % 5:
        raise InputError(f"{file}: {len(rows)} lines; expected five for each pose, a line of numbers and a matrix")
    for head, *matrix in zip(*[iter(rows)] * 5, strict=True):
        if len(head.words) not in (1, 2, 3) or not are_digits(head.words[0].lstrip("-")):
            raise head.wrong("the numbers of a frame")
        found.append((int(head.words[0]), (head.where, [row.floats(4) for row in matrix])))
    numbers, whole = [number for number, _ in found], list(range(len(files)))
    if len(found) == len(files) and [number - numbers[0] for number in numbers] in (whole, [0] * len(whole)):
        numbers = whole
    elif len(set(numbers)) < len(numbers) or not all(0 <= number < len(files) for number in numbers):
        counts = f"{len(found)} poses for {len(files)} pictures"
        raise InputError(f"{file}: {counts}; expected one for each, or their numbers")
    for number, pose in zip(numbers, at.poses(matrix for _, matrix in found), strict=True):
        at.add(*files[number], number, pose)


def _log(path: Path) -> Path | None:
    named = [file for name in ("trajectory.log", "scene/trajectory.log") if (file := path / name).exists()]
    found = named[:1] or list(path.glob("*.log"))
    return found[0] if len(found) == 1 else None


def _fits_numbered(path: Path) -> int:
    file = next((path / name for name in ("pose.txt", "poses.txt") if (path / name).exists()), None)
    if file is None or not (path / "depth").is_dir():
        return 0
    return 80 if all(len(row.words) == 7 for row in rows_of(file)[:1]) else 20


@layout(
    "numbered", "color/N.png, depth/N.png or .pgm, and pose.txt: x y z qx qy qz qw, a line for each; --intrinsics",
    _fits_numbered, no_depth=("0", By.DEFAULT), looks=("x right, y down, z forward", By.DEFAULT),
    pose=("world from camera, x y z qx qy qz qw", By.DEFAULT), takes=("frames_camera",),
)  # fmt: skip
def numbered(at: Folder) -> None:
    """Pictures by number. Source: Gao and Zhang 2021, Introduction to visual SLAM (ch5/rgbd)."""
    at.state()
    file = at.first("pose.txt", "poses.txt") or at.path / "pose.txt"
    rows, files = at.rows(file.name), at.paired()
    if len(rows) != len(files):
        raise InputError(f"{file}: {len(rows)} poses for {len(files)} pictures; expected one for each")
    for number, (row, pair) in enumerate(zip(rows, files, strict=True)):
        at.add(*pair, number, row.pose(at.axes))


@layout(
    "replica",
    "Replica of NICE-SLAM: results/frameN.jpg, results/depthN.png, traj.txt, and cam_params.json there or above",
    (90, "traj.txt", "results/frame*.*"), world="x,z,y", camera=Camera(600.0, 600.0, 599.5, 339.5, (1200, 680)),
    unit=1 / 6553.5, pose=MATRICES,
)  # fmt: skip
def replica(at: Folder) -> None:
    """Scenes of Replica. Source: Zhu et al. 2022, NICE-SLAM (cam_params.json, depth * 6553.5)."""
    camera, scale = None, None
    if file := at.first("cam_params.json", above=True):
        data: Any = read_json(file).get("camera")
        if not isinstance(data, dict):
            raise InputError(f"{file}: no object 'camera'; expected w, h, fx, fy, cx, cy and scale in it")
        wide, high, fx, fy, units = (
            _files.number_of(file, key, data.get(key), "a number above 0", above=0)
            for key in ("w", "h", "fx", "fy", "scale")
        )
        cx, cy = (_files.number_of(file, key, data.get(key)) for key in ("cx", "cy"))
        camera, scale = Camera(fx, fy, cx, cy, (round(wide), round(high))), 1 / units
    at.state(own=camera, own_scale=scale)
    rows = at.rows("traj.txt")
    colours, depths = at.numbered("results/frame*.*"), at.numbered("results/depth*.png")
    whole = _with_a_line(colours, depths, rows, f"{at.path / 'traj.txt'}: ", lambda last: colours[last].name)
    for number, pose in zip(whole, at.poses((rows[n].where, rows[n].floats(16)) for n in whole), strict=True):
        at.add(colours[number], depths[number], number, pose)
    at.left_out(len(colours), "no depth")


def _with_a_line(colours: Any, depths: Any, rows: list[Row], where: str, name: Any = str) -> list[int]:
    whole = sorted(colours.keys() & depths.keys())
    if whole and whole[-1] >= len(rows):
        raise InputError(f"{where}{len(rows)} poses, and a picture {name(whole[-1])}; expected a line for each")
    return whole


# 90 degrees across, so that the middle of 640 pixels is at 320: it counts from the first's edge.
_FIRST, _SECOND = Camera(320.0, 320.0, 320.0, 240.0, VGA, 0.5), Camera(320.0, 320.0, 320.0, 320.0, (640, 640), 0.5)
_SIDES = {"left": (_FIRST, None), "right": (_FIRST, None), "lcam_front": (_SECOND, 10.0), "rcam_front": (_SECOND, 10.0)}


def _side(path: Path) -> str:
    needed = ("pose_{}.txt", "image_{}", "depth_{}")
    return next((side for side in _SIDES if all((path / one.format(side)).exists() for one in needed)), "")


@layout(
    "tartanair", "TartanAir: image_left/N.png, depth_left/N.npy, pose_left.txt; V2: image_lcam_front/, ..",
    lambda path: 92 if _side(path) else 0, camera=_FIRST, unit=1.0,
    axes="world=y,-z,x head=y,-z,x",  # x forward, y right, z down, of the world and of the camera
)  # fmt: skip
def tartanair(at: Folder) -> None:
    """Source: Wang et al. 2020, TartanAir (its data_type.md); tartanair.org, modalities (V2)."""
    side = _side(at.path)
    if not side:
        raise InputError(f"{at.path}: no camera with pictures, depth and poses; expected {at.layout.summary}")
    camera, rate_hz = _SIDES[side]
    at.state(camera)
    at.depth_of = _depth_of_tartanair
    if rate_hz:
        at.rate_hz = rate_hz
        at.clock(by=By.FORMAT)
    rows, colours = at.rows(f"pose_{side}.txt"), at.numbered(f"image_{side}/*.png")
    found = images_in(at.path / f"depth_{side}", DEPTHS)
    depths = {int(picture.name.split("_")[0]): picture for picture in found}
    for number in _with_a_line(colours, depths, rows, f"{at.path}: "):
        at.add(colours[number], depths[number], number, rows[number].pose(at.axes))


def _depth_of_tartanair(path: Path) -> NDArray[Any]:
    if path.suffix == NPY:
        return read_depth(path)
    pixels = read_colour(path)
    if pixels.shape[2] != 4 or pixels.dtype != np.uint8:
        raise InputError(f"{path}: {pixels.shape[2]} channels; expected four bytes a pixel, of one float")
    return np.ascontiguousarray(pixels[..., [2, 1, 0, 3]]).view("<f4")[..., 0]


_BREATHES = 0.005  # of the width: telephones focus within it


def _shared_camera(cameras: Sequence[Camera], size: Size) -> tuple[Camera | None, list[str]]:
    """Return the median camera, with a note, where focus breathes by 0.5 % of the width."""
    if not cameras:
        return None, []
    numbers = np.array([(camera.fx, camera.fy, camera.cx, camera.cy) for camera in cameras])
    fx, fy, cx, cy = middle = np.median(numbers, axis=0)
    apart = np.abs(numbers - middle)
    moved = (apart[:, :2] / (fx, fy) * size / 2 + apart[:, 2:]).max()
    if moved > _BREATHES * size[0]:
        return None, []
    note = f"Intrinsics differ from frame to frame, by up to {moved:.2g} px at the border: their median is taken."
    return attrs.evolve(cameras[0], fx=fx, fy=fy, cx=cx, cy=cy), [note] if moved > 0 else []


_STRAY_HEADER = ["timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw"]


@layout(
    "stray_scanner", "Stray Scanner: rgb.mp4, depth/N.png, odometry.csv and camera_matrix.csv",
    (93, "odometry.csv", "rgb.mp4"), intrinsics=("camera_matrix.csv", By.FILE), unit=1e-3,
    clock=("seconds in odometry.csv", By.FILE),
    axes="world=x,y,-z head=x,-y,z",  # the world is ARKit's, y up; the camera was turned to x right, y down, z forward
)  # fmt: skip
def stray_scanner(at: Folder) -> None:
    """Source: Stray Robots documentation, data specification; the app's OdometryEncoder."""
    head, *rows = at.rows("odometry.csv") or [Row(str(at.path / "odometry.csv"), ["nothing"])]
    if head.words[: len(_STRAY_HEADER)] != _STRAY_HEADER:
        raise head.wrong(f"the header {', '.join(_STRAY_HEADER)}")
    matrix, video = matrix_in(at.path / "camera_matrix.csv", 3), VideoPictures(at.path / "rgb.mp4")
    cameras = [Camera.of(row.floats(4, 9, whole=False)) for row in rows if len(row.words) >= 13]
    shared, at.notes = _shared_camera(cameras, video.size)
    at.state(own=shared or Camera.of(matrix[(0, 1, 0, 1), (0, 1, 2, 2)]))
    own = shared is None and len(cameras) == len(rows) and at.options.camera is None
    depths = {int(one.stem): one for one in images_in(at.path / "depth", (".png", NPY)) if are_digits(one.stem)}
    at.size = video.size
    for number, row in enumerate(rows):
        pose = row.pose(at.axes, 2, whole=False)
        if (depth := depths.get(int(float(row.words[1])))) is not None:
            more = {"picture": partial(video.picture, number)} | ({"camera": cameras[number]} if own else {})
            at.add(Path(f"rgb.mp4 {number}"), depth, number, pose, row.nanoseconds(), **more)
    at.left_out(len(rows), "no depth")


_LIST = re.compile(r"^(\w+):[^\n]*\n(?:\s+(?:rows|cols|dt):[^\n]*\n)*\s+data:\s*\[([^\]]*)\]", re.MULTILINE)
_NUMBER = re.compile(r"^(image_width|image_height):\s*([0-9]+)\s*$", re.MULTILINE)


def _rtabmap_poses(path: Path) -> Path | None:
    found = [*path.glob("*_camera_poses.txt"), *path.glob("*_poses.txt")] if path.is_dir() else []
    return next((file for file in found if not file.name.endswith("_scan_poses.txt")), None)


@layout(
    "rtabmap", "RTAB-Map export: NAME_rgb/, NAME_depth/, NAME_calib/ and NAME_camera_poses.txt of format 11",
    lambda path: 91 if _rtabmap_poses(path) is not None and any(path.glob("*_rgb")) else 0,
    intrinsics=("NAME_calib/ID.yaml, of each image", By.FILE), unit=1e-3,
    clock=("seconds in the file of poses", By.FILE),
    axes="world=-y,z,x head=x,-y,z",  # the world is that of ROS, x forward and z up; the camera is optical
)  # fmt: skip
def rtabmap(at: Folder) -> None:
    """Source: RTAB-Map, tools/Export (folders, format 11) and CameraModel (local_transform)."""
    file = _rtabmap_poses(at.path)
    if file is None:
        raise InputError(f"{at.path}: no NAME_camera_poses.txt and no NAME_poses.txt; expected {at.layout.summary}")
    rgb, depth, calib = (min(at.path.glob(f"*_{one}"), default=at.path / one) for one in ("rgb", "depth", "calib"))
    colours, depths = ({picture.stem: picture for picture in images_in(side)} for side in (rgb, depth))
    found, cameras = [], []
    for number, row in enumerate(at.rows(file.name)):
        if len(row.words) != 9:
            raise row.wrong("nine numbers, stamp x y z qx qy qz qw id, as rtabmap-export --poses_format 11 writes them")
        stem = next((one for one in (row.words[8], row.words[0]) if one in colours), "")
        if stem in colours and stem in depths:
            camera, local = _calibration(calib / f"{stem}.yaml")
            matrix = row.matrix(1, more=1)
            found.append((stem, number, row, matrix if file.stem.endswith("_camera_poses") else matrix @ local))
            cameras.append(camera)
    if not cameras:
        raise InputError(f"{at.path}: no row of {file.name} has a picture and depth; expected {at.layout.summary}")
    shared, at.notes = _shared_camera(cameras, cameras[0].size or (1, 1))
    at.state(own=shared or cameras[0])
    own = shared is None and at.options.camera is None
    for camera, (stem, number, row, matrix) in zip(cameras, found, strict=True):
        pose = at.pose_in(row.where, matrix)
        at.add(colours[stem], depths[stem], number, pose, row.nanoseconds(), camera=camera if own else None)
    at.left_out(len(colours), "no depth or no pose")


def _calibration(file: Path) -> tuple[Camera, NDArray[np.float64]]:
    text = text_in(file, attrs.evolve(TABLE, what="the calibration of its image"))
    try:
        lists = {name: [float(word) for word in numbers.split(",")] for name, numbers in _LIST.findall(text)}
    except ValueError as error:
        raise InputError(f"{file}: {error}; expected lists of numbers") from None
    sizes = {name: int(number) for name, number in _NUMBER.findall(text)}
    _files.refuse_distortion(file, {"distortion_coefficients": lists.get("distortion_coefficients", [])})
    matrix = lists.get("camera_matrix", [])
    if len(matrix) != 9 or len(sizes) != 2:
        raise InputError(f"{file}: no image_width, image_height and camera_matrix of 9 numbers in it; expected them")
    camera = Camera(matrix[0], matrix[4], matrix[2], matrix[5], (sizes["image_width"], sizes["image_height"]))
    local = np.reshape(lists.get("local_transform", np.eye(4)[:3].ravel()), (3, 4))
    return camera, np.vstack([local, [0, 0, 0, 1]])


_TRACES = (".csv", ".txt", ".tum", ".tsv", ".json", ".jsonl", ".log", ".mcap", ".bag", ".db3")
_NAMES = ("trajectory", "traj", "trace", "groundtruth", "odometry", "poses", "pose", "camera_poses", "images")
_CAMERAS = ("intrinsics.json", "camera_intrinsic.json", "camera_intrinsics.json", "camera_info.json", "intrinsic.json")
_MATRICES = ("intrinsics.txt", "intrinsic.txt", "camera_matrix.txt", "camera_matrix.csv", "K.txt")
_LISTS = {*_CAMERAS, *_MATRICES, CAMERA, "rgb.txt", "depth.txt", "associations.txt", "readme.txt"}
_TRACED_DEPTHS = ("depth", "depths", "depth_maps")
_WHOLE = {"ns": 1, "us": 10**3, "ms": 10**6}
_COVERED = 0.05  # of the trace, at least


def _traces(path: Path) -> list[Path]:
    files = path.iterdir() if path.is_dir() else ()
    found = [file for file in files if file.suffix.lower() in _TRACES and file.name not in _LISTS]
    return sorted([file for file in found if file.stem.lower() in _NAMES] or found)


@layout(
    "traced", "color/, depth/ and one head trace of any format; pictures named by its clock, or a pose for each",
    lambda path: 30 * all(any((path / one).is_dir() for one in side) for side in (COLOURS, _TRACED_DEPTHS))
    * bool(_traces(path)), intrinsics=(f"{_CAMERAS[0]}, {_MATRICES[0]} or {CAMERA}", By.FILE), by=By.DEFAULT,
    scale=("to be stated; floats are metres", By.DEFAULT), no_depth=("0", By.DEFAULT),
    looks=Assumption(AXES, "those of the trace, else x right, y down, z forward", By.DEFAULT, "--frames-axes"),
    pose=("world from camera", By.DEFAULT), takes=("frames_axes", "frames_camera"),
    clock=Assumption(CLOCK, "names of pictures on the trace's clock, else a pose for each", By.FILE),
)  # fmt: skip
def traced(at: Folder) -> None:
    files = at.paired(at.folder(*_TRACED_DEPTHS))
    at.state(unit=1.0 if read_depth(files[0][1]).dtype.kind == "f" else None, own=_camera_beside(at))
    found = _traces(at.path)
    if len(found) != 1:
        names = ", ".join(file.name for file in found) or "no file of poses"
        expected = f"expected one head trace, called {_NAMES[0]}.csv, .txt or as its format has it"
        raise InputError(f"{at.path}: {names}; {expected}")
    reading, head = TraceOptions(axes=at.options.frames_axes), read_head(found[0])
    if find_format(head, reading).layout(head, reading).time is None:
        reading = attrs.evolve(reading, rate=at.options.frames_rate_hz or RATE_HZ)
    trace = load_trace(found[0], reading)
    said = next((fact for fact in trace.assumptions if fact.what == "axes"), Assumption("axes", trace.axes, By.DEFAULT))
    if said.by is By.DEFAULT:  # then those of a camera
        trace = load_trace(found[0], attrs.evolve(reading, axes="opencv"))
        said = Assumption(AXES, "x right, y down, z forward, of world and camera", By.DEFAULT)
    axes = attrs.evolve(said, what=AXES, option="--frames-axes")
    instants, clock = _instants(at, files, trace)
    by = By.FILE if "named" in clock else By.DEFAULT
    rated = at.options.frames_rate_hz is not None
    at.facts += [axes, Assumption(CLOCK, clock, by, "--frames-rate" if rated else "")]
    at.facts += [attrs.evolve(fact, what=POSE) for fact in trace.assumptions if fact.what == "pose"]
    at.track, at.notes = None if rated else trace.track, [*map(str, trace.defects)]
    for number, (pair, time_ns) in enumerate(zip(files, instants, strict=True)):
        sample = trace.track.at(time_ns - trace.track.epoch_ns)
        if sample.origin is not Origin.HELD:
            at.add(*pair, number, sample.pose, sample.time_ns)
    at.left_out(len(files), "the trace has no pose at their instants")


def _instants(at: Folder, files: list[tuple[Path, Path]], trace: LoadedTrace) -> tuple[list[int], str]:
    track, whole = trace.track, []
    for colour, _ in files:
        with suppress(InvalidOperation):
            whole.append(Decimal(colour.stem))
    first, last = _span(trace)
    in_seconds = any("." in colour.name.removesuffix(colour.suffix) for colour, _ in files)
    if len(whole) == len(files) and any(b - a != 1 for a, b in zip(whole, whole[1:], strict=False)):
        # Whole numbers are seconds of no clock but a count, and a count covers little of a trace.
        for unit, size in (({"s": 10**9} if in_seconds else {}) | _WHOLE).items():
            instants = [int(stem * size) for stem in whole]
            inside = sum(first <= instant <= last for instant in instants)
            if 2 * inside > len(instants) and max(instants) - min(instants) > _COVERED * (last - first):
                return instants, f"pictures are named by the trace's clock, in {unit}"
    if len(track) == len(files):
        return (track.time_ns + track.epoch_ns).tolist(), "the trace's, a pose for each picture in order"
    if len(whole) == len(files) and in_seconds:
        at.clocks = {"pictures": (float(min(whole)) * 1e9, float(max(whole)) * 1e9), trace.path.name: (first, last)}
        at.refuse_apart()
    raise InputError(
        f"{at.path}: {len(track)} poses in {trace.path.name} for {len(files)} pictures, whose names are no instants of "
        f"it ({files[0][0].stem}, and {first / 1e9:.6f} to {last / 1e9:.6f} s); expected a pose for each, or such names"
    )


def _camera_beside(at: Folder) -> Camera | None:
    if file := at.first(*_CAMERAS):
        return camera_of(file, read_json(file))
    if (file := at.first(*_MATRICES)) is None:
        return None
    numbers = [number for row in at.rows(file.name) for number in row.floats(len(row.words))]
    if len(numbers) == 4:
        return Camera.of(numbers)
    if len(numbers) not in (9, 12, 16):
        raise InputError(f"{file}: {len(numbers)} numbers; expected fx fy cx cy, or a matrix of 3 rows")
    wide = 3 if len(numbers) == 9 else 4
    return camera_of(file, {"intrinsic_matrix": [numbers[row : row + 3] for row in range(0, 3 * wide, wide)]})


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
    own = depth_camera = scale = None
    info, file = at.first("info.txt", "_info.txt", above=True), at.first(_MATRIX, above=True)
    text = "" if info is None else content_of(info, LIST).decode("utf-8", "replace")
    if info is not None and "m_calibrationColorIntrinsic" in text:
        own, depth_camera, scale = _of_info(info, text)
    elif file is not None:
        own = depth_camera = camera_of(file, {"intrinsic_matrix": matrix_in(file, 3).tolist()})
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
    at.left_out(len(colours), "no depth, or no pose of finite numbers")
    is_same = bool(whole) and size_of(colours[whole[0]]) == size_of(depths[whole[0]])

    def through(depth: NDArray[Any], colour: NDArray[Any], where: object) -> NDArray[Any]:
        """Return depth of another camera in the same place at the colour's pixels."""
        (high, wide), (rows, columns), camera = colour.shape[:2], depth.shape, at.camera
        if is_same and (high, wide) != (rows, columns):
            raise InputError(f"{where}: depth of {depth.shape[::-1]} pixels; expected as many as its colour has")
        if is_same or depth_camera is None:
            return fitted_depth(depth, colour, where)
        row = np.rint((np.arange(high) - camera.cy) / camera.fy * depth_camera.fy + depth_camera.cy).astype(int)
        column = np.rint((np.arange(wide) - camera.cx) / camera.fx * depth_camera.fx + depth_camera.cx).astype(int)
        found = depth[row.clip(0, rows - 1)[:, None], column.clip(0, columns - 1)]
        inside = ((row >= 0) & (row < rows))[:, None] & (column >= 0) & (column < columns)
        return np.asarray(np.where(inside, found, found.dtype.type(0)))

    at.fit = through


def _refuse_moved(where: object, matrix: NDArray[np.float64]) -> None:
    if np.abs(matrix - np.eye(4)).max() > 1e-3:
        raise InputError(f"{where}: no unit matrix; expected depth that is registered to the colour")


def _of_info(file: Path, text: str) -> tuple[Camera | None, Camera | None, float | None]:
    values = {key.strip(): value.split() for key, _, value in (line.partition("=") for line in text.splitlines())}

    def numbers(key: str, *counts: int) -> list[float]:
        found = _files.floats_in(values.get(key, []))
        if len(found) not in counts or not np.isfinite(found).all():
            said = " ".join(values.get(key, [])) or "missing"
            raise InputError(f"{file}: {key} is {said}; expected {counts[0]} numbers")
        return found

    def camera(side: str) -> Camera | None:
        at = numbers(f"m_calibration{side}Intrinsic", 16, 12)
        wide, high = (round(numbers(f"m_{side.lower()}{way}", 1)[0]) for way in ("Width", "Height"))
        if (moved := f"m_calibration{side}Extrinsic") in values:
            _refuse_moved(f"{file}, {moved}", np.reshape(numbers(moved, 16), (4, 4)))
        return camera_of(file, {"intrinsic_matrix": [at[0:3], at[4:7], at[8:11]], "w": wide, "h": high})

    shift = _files.number_of(file, "m_depthShift", numbers("m_depthShift", 1)[0], "units per metre, above 0", above=0)
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
            _refuse_moved(file, matrix_in(file))
    colours = {int(one.stem): one for one in images_in(at.path / "color") if are_digits(one.stem)}
    depths = at.numbered("depth/*.png")
    first = min(colours.keys() & depths.keys(), default=None)
    if first is None:
        raise InputError(f"{at.path}: no number in both color and depth; expected {at.layout.summary}")
    stated: list[Camera | None] = []
    for file in (_scannet_file(at.path, f"intrinsic_{side}") for side in ("color", "depth")):
        matrix = np.eye(4) if file is None else matrix_in(file)
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
        places = ", ".join(_SPARSE)
        raise InputError(f"{at.path}: no images.txt or images.bin in {places}; expected {at.layout.summary}")
    images, cameras = read_images(model), read_cameras(model.with_name(f"cameras{model.suffix}"))
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
        taken = wanted or per.most_common(1)[0][0]
        chosen = [one for one in chosen if str(one[1].camera_id) == taken]
        by = "" if wanted else ", as it has most images; --frames-camera reads another"
        left = per.total() - len(chosen)
        at.notes += [f"{left} frames of other cameras than {taken} were left out{by} ({held})."] if left else []
    own = {}
    for key in {image.camera_id for _, image, _ in chosen}:
        if key not in cameras:
            raise InputError(f"{model}: its images name camera {key}; expected it in cameras{model.suffix}")
        own[key] = _plain(cameras[key])
    of_stereo = bool(chosen) and chosen[0][2].name.endswith(_OWN)
    at.state(unit=1.0 if of_stereo else None, own=next(iter(own.values()), None))
    at.depth_of = _depth_of_colmap
    for number, image, depth in chosen:
        camera = own[image.camera_id] if at.options.camera is None else None
        pose = pose_of(at.axes, image.position, image.rotation)
        at.add(pictures / image.name, depth, number, pose, camera=camera)
    at.facts.append(Assumption("length", "1 m per unit of the model, whose own is any", By.DEFAULT))
    at.left_out(len(images) - per.total() + len(chosen), "no picture or no depth")


def _plain(camera: ColmapCamera) -> Camera:
    _files.refuse_distortion(camera.where, {"camera_model": camera.model})
    names, found = _KINDS.get(camera.model, "").split(), camera.parameters
    if len(names) != len(found):
        raise InputError(f"{camera.where}: {len(found)} parameters of {camera.model}; expected {len(names)}")
    facts: dict[str, Any] = dict(zip(names, found, strict=True))
    _files.refuse_distortion(camera.where, facts)
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
        expected = f"expected depth for a warp{named}"
        raise InputError(f"{file}: none of its {len(entries)} frames has a depth_file_path; {expected}")
    every = {key: value for part in (data, *whole) for key, value in part.items()}
    at.notes = _files.unread_notes(file, every, _READ_KEYS)
    if len(whole) < len(entries):
        at.notes.insert(0, f"{len(entries) - len(whole)} frames were left out: they have no depth_file_path.")
    positive = partial(_files.number_of, expected="a number above 0", above=0)
    stated = {key: positive(file, key, data[key]) for key in _SCALE_KEYS if data.get(key) is not None}
    if data.get("depth_scale") is not None:
        stated["depth_scale"] = _files.scale_of(file, data["depth_scale"])
    if len(set(stated.values())) > 1 and at.options.depth_scale is None:
        both = listed([f"{key} {value:g}" for key, value in stated.items()])
        raise InputError(f"{file}: {both} differ; expected one scale: give --depth-scale")
    scale, scale_by = first_stated(at.options.depth_scale, next(iter(stated.values()), None), None)
    if scale is None:  # by default in nerfstudio; instant-ngp has none
        scale, scale_by = _UNIT, By.FORMAT if whole[0].get(_DEPTH_KEYS[0]) else By.DEFAULT
    at.scale = scale
    applied = data.get("applied_scale")
    unit = 1.0 if applied is None else 1 / positive(file, "applied_scale", applied)
    wheres = [f"{file}, frame {number}" for number in range(len(whole))]
    poses = at.poses(((where, one.get("transform_matrix")) for where, one in zip(wheres, whole, strict=True)), unit)
    times = _times(at, wheres, whole)
    camera, camera_by = first_stated(at.options.camera, camera_of(file, {**data, **whole[0]}, _CENTRE), None)
    for number, (where, entry, pose) in enumerate(zip(wheres, whole, poses, strict=True)):
        facts = {**data, **entry}
        own = at.options.camera or camera_of(where, facts, _CENTRE)
        if own is None:
            expected = "expected intrinsics in the file, or --intrinsics"
            raise InputError(f"{where}: no fl_x and no camera_angle_x; {expected}")
        if own.is_y_up:
            raise InputError(f"{where}: fy is {own.fy:g}; expected above 0, as nerfstudio has it")
        colour, depth = (_picture(file, where, name) for name in (facts.get("file_path"), _depth_key(facts)))
        at.pairs.append(Pair(colour, depth, times[number], pose, own))
    assert camera is not None, "each frame has one"
    at.say(camera, camera_by, scale_by)


def _depth_key(entry: Mapping[str, Any]) -> Any:
    return next((entry[key] for key in _DEPTH_KEYS if entry.get(key)), None)


def _picture(file: Path, where: str, name: object) -> Path:
    if not isinstance(name, str) or not name:
        raise InputError(f"{where}: file_path is {name!r}; expected the name of a picture")
    path = named_in(file.parent, name)
    tried = [path, *(path.with_name(path.name + ending) for ending in PICTURES)] if not path.suffix else [path]
    return next((path for path in tried if path.exists()), path)


def _times(at: Folder, wheres: list[str], whole: list[Mapping[str, Any]]) -> list[int]:
    """Return the instants of all frames: timestamp in seconds; time a share, a count or seconds."""
    rated = at.options.frames_rate_hz is not None
    key = next((key for key in ("timestamp", "time") if whole[0].get(key) is not None), "")
    counted = [at.instant_ns(number) for number in range(len(whole))]
    if not key or rated and key == "timestamp":
        at.clock()
        return counted
    found = [_files.seconds_of(where, key, entry.get(key)) for where, entry in zip(wheres, whole, strict=True)]
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
    found = [picture for picture in images_in(path, (NPZ, EXR, *PICTURES)) if not _files.is_depth(picture)]
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
    found = [_files.find_frame(frame, shared=shared) for frame in _frames_in(at.path)]
    stated = [frame for frame in found if frame.facts.keys() & {"time_ns", "time_s"}]
    if stated and len(stated) < len(found):
        lacking = next(frame for frame in found if frame not in stated)
        expected = "expected it in all frames or in none"
        raise InputError(f"{lacking.where}: no time_s, which {stated[0].where.name} has; {expected}")
    own = [_time_ns(frame) for frame in stated] if at.options.frames_rate_hz is None else []
    times = [time - min(own) for time in own] or [at.instant_ns(number) for number in range(len(found))]
    at.frames = [_own_frame(at, one, time_ns) for one, time_ns in zip(found, times, strict=True)]
    if found:
        at.facts = _files.assumptions_of(found[0], at.options.camera, at.options.depth_scale)
        at.clock(*(("time_s or time_ns of each frame", By.FILE) if stated else ()))
        at.notes = list(dict.fromkeys(note for frame in found for note in frame.notes))[:1]


def _time_ns(found: FrameFile) -> int:
    key = "time_ns" if "time_ns" in found.facts else "time_s"
    value: Any = found.facts[key]
    value = value.item() if isinstance(value, np.ndarray | np.generic) and value.size == 1 else value
    if key == "time_s":
        return round(_files.seconds_of(found.where, key, value) * 1e9)
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) >= 2**63:
        raise InputError(f"{found.where}: {key} is {reprlib.repr(value)}; expected a whole number")
    return value


def _own_frame(at: Folder, found: FrameFile, time_ns: int) -> RecordedFrame:
    scale, camera = at.options.depth_scale or found.depth_scale, at.options.camera
    if scale is not None:
        _files.scale_of(found.where, scale)
    if found.encoding not in (None, "srgb", "linear"):
        raise InputError(f"{found.where}: encoding is {found.encoding!r}; expected srgb or linear")

    def read() -> Pictures:
        colour, depth = found.arrays()
        if depth.dtype.kind != "f" and scale is None:
            hint = f"give --depth-scale, the metres per unit, or depth_scale in {CAMERA}"
            raise InputError(f"{found.path}: depth is {depth.dtype}, of unknown unit: {hint}")
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
