"""Layouts of numbered or named pictures with a list of poses."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ....errors import InputError, TraceError, are_digits
from ....options.named_files import TABLE, named_in, text_in
from ....poses import Origin, TraceOptions, load_trace
from ....poses.assumptions import AXES_BY, Assumption, By
from ....poses.formats import find_format
from ....poses.reading.cleaning import LoadedTrace
from ....poses.reading.text_table import read_head
from ..camera import Camera, camera_of, number_of, read_json, refuse_distortion, unread_notes
from ..options import RATE_HZ
from ..picture_files import NPY, VideoPictures, read_colour, read_depth
from ..recorded import AXES, CLOCK, POSE
from . import _base
from ._base import CAMERA, COLOURS, DEPTHS, MATRICES, VGA, Folder, Row, layout

# What the authors advise for all sequences, whose depth is registered with it; those of freiburg3
# are undistorted already and have a camera of their own.
ADVISED, FREIBURG3 = Camera(525.0, 525.0, 319.5, 239.5, VGA), Camera(535.4, 539.2, 320.1, 247.6, VGA)
_WITHIN_NS = 20_000_000  # of colour and depth of one frame, as the data set's own script has it
_SECONDS = Assumption(CLOCK, "seconds in the lists of pictures", By.FILE)


@layout(
    "tum", "TUM RGB-D: rgb.txt, depth.txt, groundtruth.txt and the pictures that they name",
    (95, "rgb.txt", "depth.txt", "groundtruth.txt"), world="x,z,y", camera=ADVISED, unit=1 / 5000, by=By.DEFAULT,
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
    at.state(FREIBURG3 if "freiburg3" in name else ADVISED, own=own, by=by)
    at.only_for = None if own else VGA
    try:
        trace = load_trace(at.path / "groundtruth.txt", TraceOptions(format="tum", axes=at.axes.words()))
    except TraceError as error:
        raise InputError(str(error)) from error
    colours, depths = (sorted(map(_listed, at.rows(file))) for file in ("rgb.txt", "depth.txt"))
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
                at.pairs.append(_base.Pair(*files, sample.time_ns, sample.pose))
    # Axes are the layout's, and no option changes them.
    by_layout = (str(defect).replace(AXES_BY[By.USER], AXES_BY[By.FORMAT]) for defect in trace.defects)
    at.notes += [note.replace("--axes '", "axes '") for note in by_layout]
    if at.camera is ADVISED and re.search("freiburg[12]", name):
        at.notes.append(
            "The lens of this camera distorts a little; the intrinsics that its authors advise leave it in."
        )
    if lost:
        at.notes.append(f"{lost} frames were left out: groundtruth.txt has no pose at their instants.")


def _span(trace: LoadedTrace) -> tuple[int, int]:
    track = trace.track
    return track.epoch_ns + track.start_ns, track.epoch_ns + track.end_ns


def _listed(row: Row) -> tuple[int, str]:
    if len(row.words) != 2:
        raise row.wrong("seconds and the name of a file")
    return row.nanoseconds(), row.words[1]


@layout(
    "icl_nuim", "ICL-NUIM: rgb/N.png, depth/N.png and *.gt.freiburg", (90, "*.gt.freiburg", "rgb"),
    camera=Camera(481.2, -480.0, 319.5, 239.5, VGA), unit=1 / 5000, only_for=VGA,
    looks="x right, y up, z forward, in a left-handed world", clock=f"{RATE_HZ:g} frames per second",
)  # fmt: skip
def icl_nuim(at: Folder) -> None:
    """Source: Handa et al. 2014, A benchmark for RGB-D visual odometry (its page)."""
    at.state()
    colours, depths = ({one.stem: one for one in _base.pictures_in(at.path / side)} for side in ("rgb", "depth"))
    file = min(at.path.glob("*.gt.freiburg"), default=at.path / "trajectory.gt.freiburg")
    for row in at.rows(file.name):
        number = int(row.floats(8)[0])
        if (stem := str(number)) in colours and stem in depths:
            at.add(colours[stem], depths[stem], number, row.pose(at.axes, 1))
    at.left_out(len(colours), "they have no depth or no pose")


@layout(
    "redwood", "Redwood, Open3D: color/, depth/, trajectory.log, and maybe camera_intrinsic.json",
    lambda path: 85 if path.is_dir() and _log(path) is not None and (path / "depth").is_dir() else 0,
    camera=ADVISED, unit=1e-3, by=By.DEFAULT, looks="x right, y down, z forward", pose=MATRICES,
    takes=("frames_camera",),
)  # fmt: skip
def redwood(at: Folder) -> None:
    """Source: Choi et al. 2015, Robust reconstruction of indoor scenes; Open3D documentation."""
    file = _log(at.path)
    if file is None:
        raise InputError(f"{at.path}: no trajectory.log; expected {at.layout.summary}")
    own, scale = None, None
    if named := at.first("camera_intrinsic.json", "intrinsic.json", "camera_primesense.json"):
        stated = read_json(named)
        own, scale = camera_of(named, stated), stated.get("depth_scale")
        if scale is not None:  # Open3D states units per metre
            scale = number_of(named, "depth_scale", scale, "units per metre, above 0", above=0)
            scale = 1 / scale if scale >= 1 else scale
        known = ("fps", "stream_length_usec", "color_format", "depth_format", "device_name", "serial_number")
        at.notes += unread_notes(named, stated, known)
    at.state(own=own, own_scale=scale)
    files, rows, found = at.paired(), at.rows(str(file.relative_to(at.path))), []
    if len(rows) % 5:
        raise InputError(f"{file}: {len(rows)} lines; expected five for each pose, a line of numbers and a matrix")
    for head, *matrix in zip(*[iter(rows)] * 5, strict=True):
        if len(head.words) not in (1, 2, 3) or not are_digits(head.words[0].lstrip("-")):
            raise head.wrong("the numbers of a frame")
        found.append((int(head.words[0]), (head.where, [row.floats(4) for row in matrix])))
    numbers = [number for number, _ in found]
    whole = list(range(len(files)))
    if len(found) == len(files) and [number - numbers[0] for number in numbers] in (whole, [0] * len(whole)):
        numbers = whole
    elif len(set(numbers)) < len(numbers) or not all(0 <= number < len(files) for number in numbers):
        raise InputError(
            f"{file}: {len(found)} poses for {len(files)} pictures; expected one for each, or their numbers"
        )
    for number, pose in zip(numbers, at.poses(matrix for _, matrix in found), strict=True):
        at.add(*files[number], number, pose)


def _log(path: Path) -> Path | None:
    named = [path / name for name in ("trajectory.log", "scene/trajectory.log") if (path / name).exists()]
    others = list(path.glob("*.log"))
    return named[0] if named else others[0] if len(others) == 1 else None


def _fits_numbered(path: Path) -> int:
    file = next((path / name for name in ("pose.txt", "poses.txt") if (path / name).exists()), None)
    if file is None or not (path / "depth").is_dir():
        return 0
    return 80 if all(len(row.words) == 7 for row in _base.rows_of(file)[:1]) else 20


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
            number_of(file, key, data.get(key), "a number above 0", above=0) for key in ("w", "h", "fx", "fy", "scale")
        )
        cx, cy = (number_of(file, key, data.get(key)) for key in ("cx", "cy"))
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
    found = _base.pictures_in(at.path / f"depth_{side}", DEPTHS)
    depths = {int(picture.name.split("_")[0]): picture for picture in found}
    for number in _with_a_line(colours, depths, rows, f"{at.path}: "):
        at.add(colours[number], depths[number], number, rows[number].pose(at.axes))


def _depth_of_tartanair(path: Path) -> NDArray[Any]:
    """Return metres: of an .npy file, or floats of the bytes blue, green, red, alpha."""
    if path.suffix == NPY:
        return read_depth(path)
    pixels = read_colour(path)
    if pixels.shape[2] != 4 or pixels.dtype != np.uint8:
        raise InputError(f"{path}: {pixels.shape[2]} channels; expected four bytes a pixel, of one float")
    return np.ascontiguousarray(pixels[..., [2, 1, 0, 3]]).view("<f4")[..., 0]


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
    matrix, video = _base.matrix_in(at.path / "camera_matrix.csv", 3), VideoPictures(at.path / "rgb.mp4")
    cameras = [Camera.of(row.floats(4, 9, whole=False)) for row in rows if len(row.words) >= 13]
    shared, at.notes = _base.shared_camera(cameras, video.size)
    at.state(own=shared or Camera.of(matrix[(0, 1, 0, 1), (0, 1, 2, 2)]))
    own = shared is None and len(cameras) == len(rows) and at.options.camera is None
    depths = {int(one.stem): one for one in _base.pictures_in(at.path / "depth", (".png", NPY)) if are_digits(one.stem)}
    at.size = video.size
    for number, row in enumerate(rows):
        pose = row.pose(at.axes, 2, whole=False)
        if (depth := depths.get(int(float(row.words[1])))) is not None:
            more = {"camera": cameras[number]} if own else {}
            at.add(
                Path(f"rgb.mp4 {number}"), depth, number, pose, row.nanoseconds(),
                picture=partial(video.picture, number), **more,
            )  # fmt: skip
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
    colours, depths = ({picture.stem: picture for picture in _base.pictures_in(side)} for side in (rgb, depth))
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
    shared, at.notes = _base.shared_camera(cameras, cameras[0].size or (1, 1))
    at.state(own=shared or cameras[0])
    own = shared is None and at.options.camera is None
    for camera, (stem, number, row, matrix) in zip(cameras, found, strict=True):
        pose = _base.pose_of_square(at.axes, row.where, matrix)
        at.add(colours[stem], depths[stem], number, pose, row.nanoseconds(), camera=camera if own else None)
    at.left_out(len(colours), "no depth or no pose")


def _calibration(file: Path) -> tuple[Camera, NDArray[np.float64]]:
    text = text_in(file, attrs.evolve(TABLE, what="the calibration of its image"))
    try:
        lists = {name: [float(word) for word in numbers.split(",")] for name, numbers in _LIST.findall(text)}
    except ValueError as error:
        raise InputError(f"{file}: {error}; expected lists of numbers") from None
    sizes = {name: int(number) for name, number in _NUMBER.findall(text)}
    refuse_distortion(file, {"distortion_coefficients": lists.get("distortion_coefficients", [])})
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
    """Pictures whose names are instants on the clock of a trace, or that have a pose each."""
    files = at.paired(at.folder(*_TRACED_DEPTHS))
    at.state(unit=1.0 if read_depth(files[0][1]).dtype.kind == "f" else None, own=_camera_beside(at))
    found = _traces(at.path)
    if len(found) != 1:
        names = ", ".join(file.name for file in found) or "no file of poses"
        raise InputError(
            f"{at.path}: {names}; expected one head trace, called {_NAMES[0]}.csv, .txt or as its format has it"
        )
    try:
        trace, axes = _trace(found[0], at)
    except TraceError as error:
        raise InputError(str(error)) from error
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


def _trace(file: Path, at: Folder) -> tuple[LoadedTrace, Assumption]:
    reading, head = TraceOptions(axes=at.options.frames_axes), read_head(file)
    if find_format(head, reading).layout(head, reading).time is None:
        reading = attrs.evolve(reading, rate=at.options.frames_rate_hz or RATE_HZ)
    trace = load_trace(file, reading)
    said = next((fact for fact in trace.assumptions if fact.what == "axes"), Assumption("axes", trace.axes, By.DEFAULT))
    if said.by is By.DEFAULT:
        trace = load_trace(file, attrs.evolve(reading, axes="opencv"))
        said = Assumption(AXES, "x right, y down, z forward, of world and camera", By.DEFAULT)
    return trace, attrs.evolve(said, what=AXES, option="--frames-axes")


def _instants(at: Folder, files: list[tuple[Path, Path]], trace: LoadedTrace) -> tuple[list[int], str]:
    """Return the instant of each picture on the trace's clock, and how that is known."""
    track, whole = trace.track, [one for colour, _ in files if (one := _number(colour)) is not None]
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


def _number(picture: Path) -> Decimal | None:
    try:
        return Decimal(picture.stem)
    except InvalidOperation:
        return None


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
