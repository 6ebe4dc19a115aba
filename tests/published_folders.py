"""Recorded frames in the forms of published data sets and recorders, for tests.

Each writer follows its format's own documentation; poses go by the camera's directions, as in
recorded_folders.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from functools import partial
from pathlib import Path

import attrs
import av
import numpy as np
from PIL import Image
from recorded_folders import (
    CX,
    CY,
    FX,
    FY,
    OPTICAL,
    STATED,
    Taken,
    camera_matrix,
    seconds,
    seven_numbers,
    write_depth,
    y_down,
    z_up,
)
from scipy.spatial.transform import Rotation

from hmdwarp.sources.sequences import SequenceOptions

NED = ("forward", "right", "down")


def _rows(matrix: np.ndarray) -> str:
    return "\n".join(" ".join(f"{x:.12g}" for x in row) for row in matrix) + "\n"


def _save(path: Path, one: Taken) -> None:
    """Save the colour; a JPEG as near to it as one can be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    how = {"quality": 100, "subsampling": 0} if path.suffix == ".jpg" else {}
    Image.fromarray(one.colour).save(path, **how)


def _text(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def write_seven_scenes(folder: Path, frames: list[Taken]) -> None:
    """Write with 65535 for no depth."""
    for i, one in enumerate(frames):
        name = folder / f"frame-{i:06}"
        _save(Path(f"{name}.color.png"), one)
        millimetres = np.where(one.depth_m > 0, np.rint(one.depth_m * 1000), 65535)
        Image.fromarray(millimetres.astype(np.uint16)).save(f"{name}.depth.png")
        _text(Path(f"{name}.pose.txt"), _rows(camera_matrix(one, OPTICAL, y_down)))


def write_with_info(folder: Path, frames: list[Taken], depth: str = "png", stride: int = 1) -> None:
    """Write the files of 12-Scenes, BundleFusion and 3RScan. stride: of the depth's pixels."""
    (wide, high), kind = frames[0].colour.shape[1::-1], {"png": "png", "pgm": "ppm"}[depth]
    lines = ["m_versionNumber = 4", "m_sensorName = StructureSensor"]
    for side, step in (("Color", 1), ("Depth", stride)):
        sides = {"Width": wide // step, "Height": high // step}
        lines += [f"m_{side.lower()}{way} = {pixels}" for way, pixels in sides.items()]
        matrix = [FX / step, 0, CX / step, 0, 0, FY / step, CY / step, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        lines.append(f"m_calibration{side}Intrinsic = {' '.join(map(str, matrix))} ")
        lines.append(f"m_calibration{side}Extrinsic = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 ")
    for i, one in enumerate(frames):
        _save(folder / f"frame-{i:06}.color.jpg", one)
        units = Image.fromarray(np.rint(one.depth_m[::stride, ::stride] * 5000).astype(np.uint16))
        units.save(folder / f"frame-{i:06}.depth.{depth}", kind)
        _text(folder / f"frame-{i:06}.pose.txt", _rows(camera_matrix(one, OPTICAL, y_down)))
    place = folder / "_info.txt" if depth == "pgm" else folder.parent / "info.txt"
    _text(place, "\n".join([*lines, "m_depthShift = 5000", f"m_frames.size = {len(frames)}", ""]))


def write_three_d_match(folder: Path, frames: list[Taken]) -> None:
    """Write the camera above the sequences."""
    write_seven_scenes(folder, frames)
    _text(folder.parent / "camera-intrinsics.txt", _rows(np.array([[FX, 0, CX], [0, FY, CY], [0, 0, 1]])))


def write_scannet(folder: Path, frames: list[Taken], stride: int = 1) -> None:
    """Write with intrinsics as 4x4 matrices. stride: of the depth's pixels."""
    for i, one in enumerate(frames):
        _save(folder / f"color/{i}.jpg", one)
        write_depth(folder / f"depth/{i}.png", attrs.evolve(one, depth_m=one.depth_m[::stride, ::stride]), 1000)
        _text(folder / f"pose/{i}.txt", _rows(camera_matrix(one, OPTICAL, z_up)))
    for side, step in (("color", 1), ("depth", stride)):
        matrix = np.eye(4)
        matrix[:2, :3] = [[FX / step, 0, CX / step], [0, FY / step, CY / step]]
        _text(folder / f"intrinsic/intrinsic_{side}.txt", _rows(matrix))
        _text(folder / f"intrinsic/extrinsic_{side}.txt", _rows(np.eye(4)))


def write_replica(folder: Path, frames: list[Taken]) -> None:
    """Write with cam_params.json above the scene, as the archive has it."""
    lines = []
    for i, one in enumerate(frames):
        _save(folder / f"results/frame{i:06}.jpg", one)
        write_depth(folder / f"results/depth{i:06}.png", one, 6553.5)
        lines.append(" ".join(f"{x:.18e}" for x in camera_matrix(one, OPTICAL, z_up).ravel()))
    _text(folder / "traj.txt", "\n".join(lines) + "\n")
    wide, high = frames[0].colour.shape[1::-1]
    camera = {"w": wide, "h": high, "fx": FX, "fy": FY, "cx": CX, "cy": CY, "scale": 6553.5}
    _text(folder.parent / "cam_params.json", json.dumps({"camera": camera}))


def ned(v: np.ndarray) -> np.ndarray:
    """North is forward, east is right."""
    return np.array([-v[2], v[0], -v[1]])


def write_tartanair(folder: Path, frames: list[Taken]) -> None:
    """Write metres as arrays."""
    for i, one in enumerate(frames):
        _save(folder / f"image_left/{i:06}_left.png", one)
        (folder / "depth_left").mkdir(exist_ok=True)
        np.save(folder / f"depth_left/{i:06}_left_depth.npy", one.depth_m)
    lines = (seven_numbers(camera_matrix(frame, NED, ned)) for frame in frames)
    _text(folder / "pose_left.txt", "\n".join(lines) + "\n")


def write_tartanair_v2(folder: Path, frames: list[Taken]) -> None:
    """Write each metre's four bytes as the blue, green, red and alpha of a pixel."""
    for i, one in enumerate(frames):
        _save(folder / f"image_lcam_front/{i:06}_lcam_front.png", one)
        (folder / "depth_lcam_front").mkdir(exist_ok=True)
        blue, green, red, alpha = np.moveaxis(one.depth_m.astype("<f4")[..., None].view(np.uint8), -1, 0)
        Image.fromarray(np.stack([red, green, blue, alpha], axis=2), "RGBA").save(
            folder / f"depth_lcam_front/{i:06}_lcam_front_depth.png"
        )
    lines = (seven_numbers(camera_matrix(frame, NED, ned)) for frame in frames)
    _text(folder / "pose_lcam_front.txt", "\n".join(lines) + "\n")


def write_video(path: Path, frames: list[Taken]) -> None:
    """Write every colour as it is."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264rgb", rate=30, options={"qp": "0", "g": "10"})
        stream.pix_fmt = "rgb24"
        stream.height, stream.width = frames[0].colour.shape[:2]
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame.colour, format="rgb24")))
        container.mux(stream.encode())


def write_stray_scanner(folder: Path, frames: list[Taken], stride: int = 1, focus: tuple[float, ...] = ()) -> None:
    """Write with the world of ARKit, which is OpenXR's.

    stride: of the depth's pixels. focus: of each frame, as a share of FX, in the app's later form.
    """
    write_video(folder / "rgb.mp4", frames)
    later = ", fx, fy, cx, cy, distortion_center_x, distortion_center_y" if focus else ""
    lines = [f"timestamp, frame, x, y, z, qx, qy, qz, qw{later}"]
    for i, one in enumerate(frames):
        write_depth(folder / f"depth/{i:06}.png", attrs.evolve(one, depth_m=one.depth_m[::stride, ::stride]), 1000)
        pose = seven_numbers(camera_matrix(one, OPTICAL, np.asarray)).replace(" ", ", ")
        lines.append(f"{seconds(1000 * 10**9 + one.time_ns)}, {i:06}, {pose}{_focused(focus, i)}")
    _text(folder / "odometry.csv", "\n".join(lines) + "\n")
    _text(folder / "camera_matrix.csv", f"{FX}, 0.0, {CX}\n0.0, {FY}, {CY}\n0.0, 0.0, 1.0")


def _focused(focus: tuple[float, ...], number: int) -> str:
    return f", {FX * focus[number]}, {FY * focus[number]}, {CX}, {CY}, , " if focus else ""


def ros(v: np.ndarray) -> np.ndarray:
    """World of ROS: x forward, y left, z up."""
    return np.array([-v[2], -v[0], v[1]])


ROBOT = np.array([[0.0, 0, 1, 0.1], [-1, 0, 0, 0.02], [0, -1, 0, 0.3]])  # from the optical frame
_CALIBRATION = """%YAML:1.0
---
camera_name: "{name}"
image_width: {wide}
image_height: {high}
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
   data: [ {local} ]
"""


def write_rtabmap(folder: Path, frames: list[Taken], robot: bool = False) -> None:
    """Write with ids as names. robot: poses of its frame in place of the camera's."""
    wide, high = frames[0].colour.shape[1::-1]
    lines = ["#timestamp x y z qx qy qz qw id"]
    local = np.vstack([ROBOT, [0, 0, 0, 1]])
    for i, one in enumerate(frames, 7):
        _save(folder / f"map_rgb/{i}.jpg", one)
        write_depth(folder / f"map_depth/{i}.png", one, 1000)
        matrix = camera_matrix(one, OPTICAL, ros)
        matrix = matrix @ np.linalg.inv(local) if robot else matrix
        lines.append(f"{seconds(1_700_000_000 * 10**9 + one.time_ns)} {seven_numbers(matrix)} {i}")
        numbers = ", ".join(map(str, ROBOT.ravel()))
        text = _CALIBRATION.format(name=i, wide=wide, high=high, FX=FX, FY=FY, CX=CX, CY=CY, local=numbers)
        _text(folder / f"map_calib/{i}.yaml", text)
    _text(folder / f"map_{'' if robot else 'camera_'}poses.txt", "\n".join(lines) + "\n")


def write_open3d(folder: Path, frames: list[Taken], scale: float = 1.0) -> None:
    """Write extrinsics, from world to camera, by columns. scale: of the camera's unit."""
    parameters = []
    for i, one in enumerate(frames):
        _save(folder / f"color/{i:05}.png", one)
        write_depth(folder / f"depth/{i:05}.png", one, 1000)
        wide, high = one.colour.shape[1::-1]
        extrinsic = np.linalg.inv(camera_matrix(one, OPTICAL, y_down))
        extrinsic[:3, :3] *= scale
        intrinsic = {"width": wide, "height": high, "intrinsic_matrix": [FX, 0, 0, 0, FY, 0, CX, CY, 1]}
        parameters.append(
            {
                "class_name": "PinholeCameraParameters",
                "extrinsic": extrinsic.T.ravel().tolist(),
                "intrinsic": intrinsic,
                "version_major": 1,
                "version_minor": 0,
            }
        )
    trajectory = {"class_name": "PinholeCameraTrajectory", "parameters": parameters}
    _text(folder / "camera_trajectory.json", json.dumps(trajectory, indent=4))


def write_open3d_first(folder: Path, frames: list[Taken]) -> None:
    """Write the form of its first versions: one intrinsic, and a list of extrinsics."""
    write_open3d(folder, frames)
    file = folder / "camera_trajectory.json"
    parameters = json.loads(file.read_text())["parameters"]
    first = {"class_name": "PinholeCameraTrajectory", "extrinsic": [frame["extrinsic"] for frame in parameters]}
    _text(file, json.dumps({**first, "intrinsic": parameters[0]["intrinsic"]}))


def colmap_pose(one: Taken) -> list[float]:
    """Return QW QX QY QZ TX TY TZ of a camera: the world seen from it."""
    inverse = np.linalg.inv(camera_matrix(one, OPTICAL, y_down))
    x, y, z, w = Rotation.from_matrix(inverse[:3, :3]).as_quat()
    return [w, x, y, z, *inverse[:3, 3]]


def write_colmap(folder: Path, frames: list[Taken]) -> None:
    """Write a model as text, in another order than the names', one without points."""
    lines = ["# Image list with two lines of data per image:"]
    for i, one in reversed(list(enumerate(frames))):
        _save(folder / f"images/{i:04}.png", one)
        write_depth(folder / f"depth/{i:04}.png", one, 1000)
        lines.append(f"{9 - i} {' '.join(map(repr, map(float, colmap_pose(one))))} 1 {i:04}.png")
        lines.append("" if i == 1 else "10.5 12.5 -1 3.25 7.5 4")
    _text(folder / "sparse/0/images.txt", "\n".join(lines) + "\n")
    wide, high = frames[0].colour.shape[1::-1]
    camera = f"1 PINHOLE {wide} {high} {FX} {FY} {CX + 0.5} {CY + 0.5}"
    _text(folder / "sparse/0/cameras.txt", f"# Camera list\n{camera}\n")


def write_colmap_dense(folder: Path, frames: list[Taken]) -> None:
    """Write a binary model and the depth of COLMAP's own stereo."""
    images, (wide, high) = [struct.pack("<Q", len(frames))], frames[0].colour.shape[1::-1]
    for i, one in enumerate(frames):
        name = f"{i:04}.png"
        _save(folder / f"images/{name}", one)
        (folder / "stereo/depth_maps").mkdir(parents=True, exist_ok=True)
        depth = f"{wide}&{high}&1&".encode() + one.depth_m.astype("<f4").tobytes()
        (folder / f"stereo/depth_maps/{name}.geometric.bin").write_bytes(depth)
        images.append(struct.pack("<i7di", i + 1, *colmap_pose(one), 3) + name.encode() + b"\0")
        images.append(struct.pack("<Q", 1) + struct.pack("<ddq", 1.5, 2.5, -1))
    (folder / "sparse").mkdir()
    (folder / "sparse/images.bin").write_bytes(b"".join(images))
    camera = struct.pack("<QiiQQ4d", 1, 3, 1, wide, high, FX, FY, CX + 0.5, CY + 0.5)
    (folder / "sparse/cameras.bin").write_bytes(camera)


def write_traced(folder: Path, frames: list[Taken]) -> None:
    """Write pictures named by the clock of a trace in TUM's format, which has more poses."""
    _text(folder / "intrinsics.txt", f"{FX} 0 {CX}\n0 {FY} {CY}\n0 0 1\n")
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    for i, one in enumerate(frames):
        stamp = seconds(1_700_000_000 * 10**9 + one.time_ns)
        _save(folder / f"rgb/{stamp}.png", one)
        write_depth(folder / f"depth/{stamp}.png", one, 1000)
        lines.append(f"{stamp} {seven_numbers(camera_matrix(one, OPTICAL, y_down))}")
        if i + 1 < len(frames):
            between = attrs.evolve(one, pose=one.pose.towards(frames[i + 1].pose, 0.5))
            stamp = seconds(1_700_000_000 * 10**9 + (one.time_ns + frames[i + 1].time_ns) // 2)
            lines.append(f"{stamp} {seven_numbers(camera_matrix(between, OPTICAL, y_down))}")
    _text(folder / "trajectory.txt", "\n".join(lines) + "\n")


def write_traced_matrices(folder: Path, frames: list[Taken]) -> None:
    """Write a matrix for each picture in the axes of OpenXR, and metres as floats."""
    _text(folder / "intrinsics.json", json.dumps({"fx": FX, "fy": FY, "cx": CX, "cy": CY}))
    lines = []
    for i, one in enumerate(frames):
        _save(folder / f"color/{i:04}.png", one)
        (folder / "depth").mkdir(exist_ok=True)
        np.save(folder / f"depth/{i:04}.npy", one.depth_m)
        lines.append(" ".join(f"{x:.12g}" for x in camera_matrix(one, ("right", "up", "back"), np.asarray)[:3].ravel()))
    _text(folder / "poses.txt", "\n".join(lines) + "\n")


@attrs.frozen
class Form:
    """A folder of one layout: the reader that must recognise it, who writes it, what is stated."""

    reader: str
    write: Callable[[Path, list[Taken]], None]
    options: SequenceOptions = SequenceOptions()
    colour_within: int = 0  # Largest difference of its colour, in steps of 255: that of a JPEG, or of a video


JPEG = 4
PUBLISHED = {
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
    "open3d_first": Form("open3d", write_open3d_first),
    "colmap": Form("colmap", write_colmap, SequenceOptions(depth_scale=0.001)),
    "colmap_dense": Form("colmap", write_colmap_dense),
    "traced": Form("traced", write_traced, SequenceOptions(depth_scale=0.001)),
    "traced_matrices": Form(
        "traced", write_traced_matrices, SequenceOptions(frames_axes="openxr", frames_rate_hz=30.0)
    ),
    "tartanair_v2": Form("tartanair", write_tartanair_v2, attrs.evolve(STATED, frames_rate_hz=30.0)),
}
