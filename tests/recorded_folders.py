"""Recorded frames for tests: a wall and a nearer strip, in the forms of data sets and recorders.
Each writer follows its format's own documentation. It turns a pose by its three directions, column
by column; the readers by a change of basis."""

from __future__ import annotations

import importlib.util
import json
import struct
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

import attrs
import av
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial.transform import Rotation

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.sequences import SequenceOptions, parse_intrinsics

SIZE = (36, 24)
FX, FY, CX, CY = 40.0, 42.0, 17.3, 11.1
RATE_HZ = 30.0
WALL_M, STRIP_M = 3.0, 1.5
# Real frames, not shipped: intrinsics, metres per unit, and the share of depths that agree.
REAL = Path(__file__).resolve().parents[2] / "shared" / "rgbd"
REAL_CAMERAS = {"camera": ("518,519,325.5,253.5", 1 / 1000, 0.41), "icl": ("481.2,-480,319.5,239.5", 1 / 5000, 0.95)}
HAS_EXR = importlib.util.find_spec("OpenEXR") is not None
Vectors = NDArray[np.float64]
# Directions of a camera that a file has as columns.
OPTICAL, OPENGL, NED = ("right", "down", "forward"), ("right", "up", "back"), ("forward", "right", "down")


@attrs.frozen(eq=False)
class Taken:
    """One frame, as a reader should give it back."""

    colour: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    pose: Pose
    time_ns: int

    @property
    def basis(self) -> dict[str, Vectors]:
        """Directions of the camera in the world."""
        right, up, back = self.pose.rotation_matrix.T
        return {"right": right, "up": up, "back": back, "down": -up, "forward": -back}


def fov_of(size: tuple[int, int] = SIZE) -> Fov:
    """Return the field of view of the camera, whose intrinsics are for SIZE."""
    scale = size[0] / SIZE[0]
    return Fov.from_intrinsics(FX * scale, FY * scale, (CX + 0.5) * scale - 0.5, (CY + 0.5) * scale - 0.5, *size)


def taken(count: int, size: tuple[int, int] = SIZE, step_m: float = 0.02, step_deg: float = 1.0) -> list[Taken]:
    """Return frames of a camera that moves to the right and turns; pixel (0, 0) has no depth."""
    turns = (Rotation.from_euler("yx", (step_deg * i, 2), degrees=True).as_quat() for i in range(count))
    places = (Pose((step_m * i, 1.6, 0.1), turn) for i, turn in enumerate(turns))
    return [seen_from(place, round(i * 1e9 / RATE_HZ), size) for i, place in enumerate(places)]


def seen_from(pose: Pose, time_ns: int, size: tuple[int, int]) -> Taken:
    """Return what the camera sees from a place."""
    view = View(pose, fov_of(size))
    rays = np.flipud(view.rays(size)) @ pose.rotation_matrix.T
    depth = (-WALL_M - pose.position_m[2]) / rays[..., 2]
    strip = (-STRIP_M - pose.position_m[2]) / rays[..., 2]
    depth = np.where(np.abs((pose.position_m + strip[..., None] * rays)[..., 0] - 0.1) < 0.2, strip, depth)
    x, y, z = np.moveaxis(pose.position_m + depth[..., None] * rays, -1, 0)
    colour = np.stack([127 + 90 * np.sin(4 * x), 127 + 90 * np.sin(3 * y), 127 + 90 * np.cos(2 * x + 3 * z)], axis=2)
    depth[0, 0] = 0
    return Taken(colour.round().astype(np.uint8), depth.astype(np.float32), pose, time_ns)


# --- worlds and poses of files ---


def z_up(v: Vectors) -> Vectors:
    """World with x right, y forward, z up."""
    return np.array([v[0], -v[2], v[1]])


def y_down(v: Vectors) -> Vectors:
    """World of the first camera: x right, y down, z forward."""
    return np.array([v[0], -v[1], -v[2]])


def ned(v: Vectors) -> Vectors:
    """World with north forward and east to the right."""
    return np.array([-v[2], v[0], -v[1]])


def ros(v: Vectors) -> Vectors:
    """World of ROS: x forward, y left, z up."""
    return np.array([-v[2], -v[0], v[1]])


def camera_matrix(one: Taken, columns: tuple[str, str, str], world: Callable[[Vectors], Vectors]) -> Vectors:
    """Return camera to world with these directions as columns, in a file's world."""
    out = np.eye(4)
    out[:3, :3] = np.stack([world(one.basis[name]) for name in columns], axis=1)
    out[:3, 3] = world(one.pose.position_m)
    return out


def seven_numbers(matrix: Vectors) -> str:
    """Return x y z qx qy qz qw."""
    return " ".join(f"{x:.12g}" for x in (*matrix[:3, 3], *Rotation.from_matrix(matrix[:3, :3]).as_quat()))


def seconds(time_ns: int) -> str:
    """Return seconds with nine decimals."""
    return f"{time_ns // 10**9}.{time_ns % 10**9:09d}"


def _rows(matrix: Vectors) -> str:
    return "\n".join(" ".join(f"{x:.12g}" for x in row) for row in matrix) + "\n"


def _text(path: Path, text: str | Iterable[str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text if isinstance(text, str) else "\n".join(text) + "\n", encoding="utf-8")


def _json(path: Path, data: object) -> None:
    _text(path, json.dumps(data))


def _colour(path: Path, one: Taken) -> None:
    """Write the colour; a JPEG as near to it as one can be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    how = {"quality": 100, "subsampling": 0} if path.suffix == ".jpg" else {}
    Image.fromarray(one.colour).save(path, **how)


def _depth(path: Path, one: Taken, per_metre: float, stride: int = 1, none: int = 0) -> None:
    """Write whole numbers of 16 bits, or metres as an array. none: what stands for no depth."""
    path.parent.mkdir(parents=True, exist_ok=True)
    metres = one.depth_m[::stride, ::stride]
    if path.suffix == ".npy":
        np.save(path, metres)
        return
    units = np.where(metres > 0, np.rint(metres * per_metre), none).astype(np.uint16)
    Image.fromarray(units).save(path, "ppm" if path.suffix == ".pgm" else "png")


def _pairs(
    folder: Path, frames: list[Taken], colour: str, depth: str, per_metre: float = 1, first: int = 0, **how: int
) -> None:
    """Write both pictures of each frame, under names with its number."""
    for i, one in enumerate(frames, first):
        _colour(folder / colour.format(i), one)
        _depth(folder / depth.format(i), one, per_metre, **how)


def _pinhole(one: Taken) -> dict[str, int]:
    width, height = one.colour.shape[1::-1]
    return {"width": width, "height": height}


def _intrinsics(width: int = 4, step: int = 1) -> Vectors:
    """Return the camera as a square matrix, of pictures of every step-th pixel."""
    matrix = np.eye(width)
    matrix[:2, :3] = [[FX / step, 0, CX / step], [0, FY / step, CY / step]]
    return matrix


# --- layouts ---


def write_tum(folder: Path, frames: list[Taken]) -> None:
    """Write with clocks that begin at 1305031102 s, depth 5 ms after colour and poses at 90 Hz."""
    _pairs(folder, frames, "rgb/{}.png", "depth/{}.png", 5000)
    colours, depths, poses = ["# color images"], ["# depth maps"], ["# timestamp tx ty tz qx qy qz qw"]
    for i, one in enumerate(frames):
        time_ns = 1305031102_175304000 + one.time_ns
        colours.append(f"{seconds(time_ns)} rgb/{i}.png")
        depths.append(f"{seconds(time_ns + 5_000_000)} depth/{i}.png")
        for part in range(3) if i + 1 < len(frames) else (0,):
            pose = one.pose.towards(frames[i + 1].pose, part / 3) if part else one.pose
            matrix = camera_matrix(attrs.evolve(one, pose=pose), OPTICAL, z_up)
            poses.append(f"{seconds(time_ns + round(part * (1e9 / RATE_HZ) / 3))} {seven_numbers(matrix)}")
    for name, lines in (("rgb", colours), ("depth", depths), ("groundtruth", poses)):
        _text(folder / f"{name}.txt", lines)


def write_icl_nuim(folder: Path, frames: list[Taken]) -> None:
    """Write with y up and a left-handed world, as the renderer has it."""
    _pairs(folder, frames, "rgb/{}.png", "depth/{}.png", 5000)
    matrices = (camera_matrix(one, ("right", "up", "forward"), lambda v: v * np.array([1, 1, -1])) for one in frames)
    _text(folder / "livingRoom0.gt.freiburg", (f"{i} {seven_numbers(m)}" for i, m in enumerate(matrices)))


def write_numbered(folder: Path, frames: list[Taken]) -> None:
    """Write with a line of a pose for each picture."""
    _pairs(folder, frames, "color/{}.png", "depth/{}.png", 1000)
    _text(folder / "pose.txt", (seven_numbers(camera_matrix(frame, OPTICAL, y_down)) for frame in frames))


def write_redwood(folder: Path, frames: list[Taken]) -> None:
    """Write with matrices and the intrinsics that Open3D writes, by columns."""
    _pairs(folder, frames, "color/{}.png", "depth/{}.png", 1000)
    rows = (f"{i} {i} {i + 1}\n{_rows(camera_matrix(one, OPTICAL, y_down))}" for i, one in enumerate(frames))
    _text(folder / "trajectory.log", "".join(rows).rstrip("\n"))
    camera = {**_pinhole(frames[0]), "intrinsic_matrix": [FX, 0, 0, 0, FY, 0, CX, CY, 1]}
    _json(folder / "camera_intrinsic.json", camera)


def write_nerfstudio(folder: Path, frames: list[Taken]) -> None:
    """Write transforms.json; its pixel centres lie at 0.5."""
    _pairs(folder, frames, "images/{}.png", "depth/{}.png", 1000)
    listed = [
        {
            "file_path": f"images/{i}.png",
            "depth_file_path": f"depth/{i}.png",
            "transform_matrix": camera_matrix(one, OPENGL, z_up).tolist(),
        }
        for i, one in enumerate(frames)
    ]
    wide, high = frames[0].colour.shape[1::-1]
    camera = {"camera_model": "OPENCV", "fl_x": FX, "fl_y": FY, "cx": CX + 0.5, "cy": CY + 0.5, "w": wide, "h": high}
    _json(folder / "transforms.json", {**camera, "k1": 0, "frames": listed})


def _facts(one: Taken) -> dict[str, object]:
    place, turn = one.pose.position_m.tolist(), one.pose.orientation_xyzw.tolist()
    return {"position_m": place, "orientation_xyzw": turn, "time_s": one.time_ns * 1e-9}


def write_npz(folder: Path, frames: list[Taken]) -> None:
    """Write each frame as `hmdwarp warp` takes it."""
    for i, one in enumerate(frames):
        facts = {"fov": attrs.astuple(fov_of(one.colour.shape[1::-1]))[:4], **_facts(one)}
        np.savez(folder / f"frame-{i}.npz", colour=one.colour, depth_m=one.depth_m, **facts)


def write_pictures(folder: Path, frames: list[Taken]) -> None:
    """Write pictures with depth and a JSON beside each, and what all share in camera.json."""
    _pairs(folder, frames, "{}.png", "{}.depth.png", 1000)
    for i, one in enumerate(frames):
        _json(folder / f"{i}.json", _facts(one))
    _json(folder / "camera.json", {"intrinsics": [FX, FY, CX, CY], "depth_scale": 0.001})


def write_exrs(folder: Path, frames: list[Taken]) -> None:
    """Write EXR files with their own Z, and a JSON beside each."""
    import OpenEXR

    from hmdwarp.base import linear_from_srgb

    for i, one in enumerate(frames):
        light = linear_from_srgb(one.colour)
        channels = {name: np.ascontiguousarray(light[..., c]) for c, name in enumerate("RGB")} | {"Z": one.depth_m}
        OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, channels).write(str(folder / f"{i}.exr"))
        _json(folder / f"{i}.json", {"intrinsics": [FX, FY, CX, CY], **_facts(one)})


def write_seven_scenes(folder: Path, frames: list[Taken]) -> None:
    """Write with 65535 for no depth."""
    _pairs(folder, frames, "frame-{:06}.color.png", "frame-{:06}.depth.png", 1000, none=65535)
    for i, one in enumerate(frames):
        _text(folder / f"frame-{i:06}.pose.txt", _rows(camera_matrix(one, OPTICAL, y_down)))


def write_with_info(folder: Path, frames: list[Taken], depth: str = "png", stride: int = 1) -> None:
    """Write the files of 12-Scenes, BundleFusion and 3RScan. stride: of the depth's pixels."""
    _pairs(folder, frames, "frame-{:06}.color.jpg", "frame-{:06}.depth." + depth, 5000, stride=stride)
    lines = ["m_versionNumber = 4", "m_sensorName = StructureSensor"]
    for side, step in (("Color", 1), ("Depth", stride)):
        sides = {way.capitalize(): pixels // step for way, pixels in _pinhole(frames[0]).items()}
        lines += [f"m_{side.lower()}{way} = {pixels}" for way, pixels in sides.items()]
        for kind, matrix in (("Intrinsic", _intrinsics(4, step)), ("Extrinsic", np.eye(4))):
            lines.append(f"m_calibration{side}{kind} = {' '.join(map(str, matrix.ravel()))} ")
    for i, one in enumerate(frames):
        _text(folder / f"frame-{i:06}.pose.txt", _rows(camera_matrix(one, OPTICAL, y_down)))
    place = folder / "_info.txt" if depth == "pgm" else folder.parent / "info.txt"
    _text(place, [*lines, "m_depthShift = 5000", f"m_frames.size = {len(frames)}"])


def write_three_d_match(folder: Path, frames: list[Taken]) -> None:
    """Write the camera above the sequences."""
    write_seven_scenes(folder, frames)
    _text(folder.parent / "camera-intrinsics.txt", _rows(_intrinsics(3)))


def write_scannet(folder: Path, frames: list[Taken], stride: int = 1) -> None:
    """Write with intrinsics as 4x4 matrices. stride: of the depth's pixels."""
    _pairs(folder, frames, "color/{}.jpg", "depth/{}.png", 1000, stride=stride)
    for i, one in enumerate(frames):
        _text(folder / f"pose/{i}.txt", _rows(camera_matrix(one, OPTICAL, z_up)))
    for side, step in (("color", 1), ("depth", stride)):
        _text(folder / f"intrinsic/intrinsic_{side}.txt", _rows(_intrinsics(4, step)))
        _text(folder / f"intrinsic/extrinsic_{side}.txt", _rows(np.eye(4)))


def write_replica(folder: Path, frames: list[Taken]) -> None:
    """Write with cam_params.json above the scene, as the archive has it."""
    _pairs(folder, frames, "results/frame{:06}.jpg", "results/depth{:06}.png", 6553.5)
    matrices = (camera_matrix(one, OPTICAL, z_up).ravel() for one in frames)
    _text(folder / "traj.txt", (" ".join(f"{x:.18e}" for x in matrix) for matrix in matrices))
    wide, high = frames[0].colour.shape[1::-1]
    camera = {"w": wide, "h": high, "fx": FX, "fy": FY, "cx": CX, "cy": CY, "scale": 6553.5}
    _json(folder.parent / "cam_params.json", {"camera": camera})


def write_tartanair(folder: Path, frames: list[Taken]) -> None:
    """Write metres as arrays."""
    _pairs(folder, frames, "image_left/{:06}_left.png", "depth_left/{:06}_left_depth.npy")
    _text(folder / "pose_left.txt", (seven_numbers(camera_matrix(frame, NED, ned)) for frame in frames))


def write_tartanair_v2(folder: Path, frames: list[Taken]) -> None:
    """Write each metre's four bytes as the blue, green, red and alpha of a pixel."""
    (folder / "depth_lcam_front").mkdir()
    for i, one in enumerate(frames):
        _colour(folder / f"image_lcam_front/{i:06}_lcam_front.png", one)
        pixels = one.depth_m.astype("<f4")[..., None].view(np.uint8)[..., [2, 1, 0, 3]]
        Image.fromarray(pixels, "RGBA").save(folder / f"depth_lcam_front/{i:06}_lcam_front_depth.png")
    _text(folder / "pose_lcam_front.txt", (seven_numbers(camera_matrix(frame, NED, ned)) for frame in frames))


def write_stray_scanner(folder: Path, frames: list[Taken], stride: int = 1, focus: tuple[float, ...] = ()) -> None:
    """Write with the world of ARKit, which is OpenXR's, and every colour of the video as it is.
    stride: of the depth's pixels. focus: of each frame, as a share of FX, in the app's later
    form."""
    with av.open(str(folder / "rgb.mp4"), "w") as container:
        stream = container.add_stream("libx264rgb", rate=30, options={"qp": "0", "g": "10"})
        stream.pix_fmt = "rgb24"
        stream.height, stream.width = frames[0].colour.shape[:2]
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame.colour, format="rgb24")))
        container.mux(stream.encode())
    later = ", fx, fy, cx, cy, distortion_center_x, distortion_center_y" if focus else ""
    lines = [f"timestamp, frame, x, y, z, qx, qy, qz, qw{later}"]
    for i, one in enumerate(frames):
        _depth(folder / f"depth/{i:06}.png", one, 1000, stride)
        pose = seven_numbers(camera_matrix(one, OPTICAL, np.asarray)).replace(" ", ", ")
        camera = f", {FX * focus[i]}, {FY * focus[i]}, {CX}, {CY}, , " if focus else ""
        lines.append(f"{seconds(1000 * 10**9 + one.time_ns)}, {i:06}, {pose}{camera}")
    _text(folder / "odometry.csv", lines)
    _text(folder / "camera_matrix.csv", f"{FX}, 0.0, {CX}\n0.0, {FY}, {CY}\n0.0, 0.0, 1.0")


ROBOT = np.array([[0.0, 0, 1, 0.1], [-1, 0, 0, 0.02], [0, -1, 0, 0.3]])  # from the optical frame
_CALIBRATION = f"""%YAML:1.0
---
camera_name: "{{name}}"
image_width: {{width}}
image_height: {{height}}
camera_matrix:
   rows: 3
   cols: 3
   data: [ {FX}, 0., {CX}, 0.,
       {FY}, {CY}, 0., 0., 1. ]
distortion_coefficients:
   rows: 1
   cols: 5
   data: [ 0., 0., 0., 0., 0. ]
distortion_model: plumb_bob
local_transform:
   rows: 3
   cols: 4
   data: [ {", ".join(map(str, ROBOT.ravel()))} ]
"""


def write_rtabmap(folder: Path, frames: list[Taken], robot: bool = False) -> None:
    """Write with ids as names. robot: poses of its frame in place of the camera's."""
    _pairs(folder, frames, "map_rgb/{}.jpg", "map_depth/{}.png", 1000, first=7)
    lines, robot_from_camera = ["#timestamp x y z qx qy qz qw id"], np.linalg.inv(np.vstack([ROBOT, [0, 0, 0, 1]]))
    for i, one in enumerate(frames, 7):
        matrix = camera_matrix(one, OPTICAL, ros)
        matrix = matrix @ robot_from_camera if robot else matrix
        lines.append(f"{seconds(1_700_000_000 * 10**9 + one.time_ns)} {seven_numbers(matrix)} {i}")
        _text(folder / f"map_calib/{i}.yaml", _CALIBRATION.format(name=i, **_pinhole(one)))
    _text(folder / f"map_{'' if robot else 'camera_'}poses.txt", lines)


def write_open3d(folder: Path, frames: list[Taken], scale: float = 1.0, first: bool = False) -> None:
    """Write extrinsics, from world to camera, by columns. scale: of the camera's unit. first: in
    the form of the first versions, with one intrinsic and a list of extrinsics."""
    _pairs(folder, frames, "color/{:05}.png", "depth/{:05}.png", 1000)
    intrinsic = {**_pinhole(frames[0]), "intrinsic_matrix": [FX, 0, 0, 0, FY, 0, CX, CY, 1]}
    extrinsics = []
    for one in frames:
        extrinsic = np.linalg.inv(camera_matrix(one, OPTICAL, y_down))
        extrinsic[:3, :3] *= scale
        extrinsics.append(extrinsic.T.ravel().tolist())
    named = {"class_name": "PinholeCameraParameters", "version_major": 1, "version_minor": 0, "intrinsic": intrinsic}
    found = {"parameters": [{**named, "extrinsic": extrinsic} for extrinsic in extrinsics]}
    found = {"extrinsic": extrinsics, "intrinsic": intrinsic} if first else found
    _json(folder / "camera_trajectory.json", {"class_name": "PinholeCameraTrajectory", **found})


def _colmap_pose(one: Taken) -> list[float]:
    """Return QW QX QY QZ TX TY TZ of a camera: the world seen from it."""
    inverse = np.linalg.inv(camera_matrix(one, OPTICAL, y_down))
    x, y, z, w = Rotation.from_matrix(inverse[:3, :3]).as_quat()
    return [w, x, y, z, *inverse[:3, 3]]


def write_colmap(folder: Path, frames: list[Taken]) -> None:
    """Write a model as text, in another order than the names', one without points."""
    _pairs(folder, frames, "images/{:04}.png", "depth/{:04}.png", 1000)
    lines = ["# Image list with two lines of data per image:"]
    for i, one in reversed(list(enumerate(frames))):
        lines.append(f"{9 - i} {' '.join(map(repr, map(float, _colmap_pose(one))))} 1 {i:04}.png")
        lines.append("" if i == 1 else "10.5 12.5 -1 3.25 7.5 4")
    _text(folder / "sparse/0/images.txt", lines)
    wide, high = frames[0].colour.shape[1::-1]
    camera = f"1 PINHOLE {wide} {high} {FX} {FY} {CX + 0.5} {CY + 0.5}"
    _text(folder / "sparse/0/cameras.txt", f"# Camera list\n{camera}\n")


def write_colmap_dense(folder: Path, frames: list[Taken]) -> None:
    """Write a binary model and the depth of COLMAP's own stereo."""
    images, (wide, high) = [struct.pack("<Q", len(frames))], frames[0].colour.shape[1::-1]
    for part in ("stereo/depth_maps", "sparse"):
        (folder / part).mkdir(parents=True)
    for i, one in enumerate(frames):
        name = f"{i:04}.png"
        _colour(folder / f"images/{name}", one)
        depth = f"{wide}&{high}&1&".encode() + one.depth_m.astype("<f4").tobytes()
        (folder / f"stereo/depth_maps/{name}.geometric.bin").write_bytes(depth)
        images.append(struct.pack("<i7di", i + 1, *_colmap_pose(one), 3) + name.encode() + b"\0")
        images.append(struct.pack("<Q", 1) + struct.pack("<ddq", 1.5, 2.5, -1))
    (folder / "sparse/images.bin").write_bytes(b"".join(images))
    camera = struct.pack("<QiiQQ4d", 1, 3, 1, wide, high, FX, FY, CX + 0.5, CY + 0.5)
    (folder / "sparse/cameras.bin").write_bytes(camera)


def write_traced(folder: Path, frames: list[Taken]) -> None:
    """Write pictures named by the clock of a trace in TUM's format, which has more poses."""
    _text(folder / "intrinsics.txt", _rows(_intrinsics(3)))
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    for i, one in enumerate(frames):
        stamp = seconds(1_700_000_000 * 10**9 + one.time_ns)
        _colour(folder / f"rgb/{stamp}.png", one)
        _depth(folder / f"depth/{stamp}.png", one, 1000)
        lines.append(f"{stamp} {seven_numbers(camera_matrix(one, OPTICAL, y_down))}")
        if i + 1 < len(frames):
            between = attrs.evolve(one, pose=one.pose.towards(frames[i + 1].pose, 0.5))
            stamp = seconds(1_700_000_000 * 10**9 + (one.time_ns + frames[i + 1].time_ns) // 2)
            lines.append(f"{stamp} {seven_numbers(camera_matrix(between, OPTICAL, y_down))}")
    _text(folder / "trajectory.txt", lines)


def write_traced_matrices(folder: Path, frames: list[Taken]) -> None:
    """Write a matrix for each picture in the axes of OpenXR, and metres as floats."""
    _json(folder / "intrinsics.json", {"fx": FX, "fy": FY, "cx": CX, "cy": CY})
    _pairs(folder, frames, "color/{:04}.png", "depth/{:04}.npy")
    matrices = (camera_matrix(one, OPENGL, np.asarray)[:3] for one in frames)
    _text(folder / "poses.txt", (_rows(matrix).replace("\n", " ").rstrip() for matrix in matrices))


STATED = SequenceOptions(intrinsics=parse_intrinsics(f"{FX},{FY},{CX},{CY}"))
AS_TUM = attrs.evolve(STATED, depth_scale=1 / 5000)
MIRRORED = attrs.evolve(AS_TUM, intrinsics=parse_intrinsics(f"{FX},{-FY},{CX},{CY}"))
MILLIMETRES = attrs.evolve(STATED, depth_scale=0.001)
UNIT = SequenceOptions(depth_scale=0.001)


@attrs.frozen
class Form:
    """A folder of one layout: the reader that must recognise it, who writes it, what is stated."""

    reader: str
    write: Callable[..., None]
    options: SequenceOptions = SequenceOptions()
    colour_within: int = 0  # Largest difference of its colour, in steps of 255: that of a JPEG, or of a video


JPEG = 4
LAYOUTS = {
    "tum": Form("tum", write_tum, AS_TUM),
    "icl_nuim": Form("icl_nuim", write_icl_nuim, MIRRORED),
    "numbered": Form("numbered", write_numbered, MILLIMETRES),
    "redwood": Form("redwood", write_redwood),
    "nerfstudio": Form("nerfstudio", write_nerfstudio),
    "npz": Form("folder", write_npz),
    "pictures": Form("folder", write_pictures),
    "exr": Form("folder", write_exrs),
    "seven_scenes": Form("seven_scenes", write_seven_scenes, STATED),
    "twelve_scenes": Form("seven_scenes", write_with_info, colour_within=JPEG),
    "three_r_scan": Form("seven_scenes", partial(write_with_info, depth="pgm"), colour_within=JPEG),
    "three_d_match": Form("seven_scenes", write_three_d_match),
    "scannet": Form("scannet", write_scannet, colour_within=JPEG),
    "replica": Form("replica", write_replica, colour_within=JPEG),
    "tartanair": Form("tartanair", write_tartanair, STATED),
    "stray_scanner": Form("stray_scanner", write_stray_scanner),
    "stray_scanner_later": Form("stray_scanner", partial(write_stray_scanner, focus=(1.0,) * 9)),
    "rtabmap": Form("rtabmap", write_rtabmap, colour_within=JPEG),
    "rtabmap_robot": Form("rtabmap", partial(write_rtabmap, robot=True), colour_within=JPEG),
    "open3d": Form("open3d", write_open3d),
    "open3d_scaled": Form("open3d", partial(write_open3d, scale=2.5)),
    "open3d_first": Form("open3d", partial(write_open3d, first=True)),
    "colmap": Form("colmap", write_colmap, UNIT),
    "colmap_dense": Form("colmap", write_colmap_dense),
    "traced": Form("traced", write_traced, UNIT),
    "traced_matrices": Form(
        "traced", write_traced_matrices, SequenceOptions(frames_axes="openxr", frames_rate_hz=30.0)
    ),
    "tartanair_v2": Form("tartanair", write_tartanair_v2, attrs.evolve(STATED, frames_rate_hz=30.0)),
}
