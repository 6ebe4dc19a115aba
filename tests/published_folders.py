"""Recorded frames in the forms of published data sets and recorders, for tests.

Each writer follows its format's own documentation; poses go by the camera's directions, as in
recorded_folders.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import attrs
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
    seven_numbers,
    write_depth,
    y_down,
    z_up,
)

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
    lines = (seven_numbers(camera_matrix(one, NED, ned)) for one in frames)
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
    lines = (seven_numbers(camera_matrix(one, NED, ned)) for one in frames)
    _text(folder / "pose_lcam_front.txt", "\n".join(lines) + "\n")


@attrs.frozen
class Form:
    """A folder of one layout: the reader that must recognise it, who writes it, what is stated."""

    reader: str
    write: Callable[[Path, list[Taken]], None]
    options: SequenceOptions = SequenceOptions()
    # Largest difference of its colour, in steps of 255: that of a JPEG, or of a video.
    colour_within: int = 0


JPEG = 4
PUBLISHED = {
    "seven_scenes": Form("seven_scenes", write_seven_scenes, STATED),
    "scannet": Form("scannet", write_scannet, colour_within=JPEG),
    "replica": Form("replica", write_replica, colour_within=JPEG),
    "tartanair": Form("tartanair", write_tartanair, STATED),
    "tartanair_v2": Form("tartanair", write_tartanair_v2, attrs.evolve(STATED, frames_rate_hz=30.0)),
}
