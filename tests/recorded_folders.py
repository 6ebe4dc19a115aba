"""Recorded frames for tests: a wall and a nearer strip, written in every layout.

The writers turn a pose by its three directions, column by column; the readers by a change of basis.
"""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Callable
from pathlib import Path

import attrs
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
    return [
        seen_from(
            Pose((step_m * i, 1.6, 0.1), Rotation.from_euler("yx", (step_deg * i, 2), degrees=True).as_quat()),
            round(i * 1e9 / RATE_HZ),
            size,
        )
        for i in range(count)
    ]


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


def camera_matrix(one: Taken, columns: tuple[str, str, str], world: Callable[[Vectors], Vectors]) -> Vectors:
    """Return camera to world with these directions as columns, in a file's world."""
    out = np.eye(4)
    out[:3, :3] = np.stack([world(one.basis[name]) for name in columns], axis=1)
    out[:3, 3] = world(one.pose.position_m)
    return out


def z_up(v: Vectors) -> Vectors:
    """World with x right, y forward, z up."""
    return np.array([v[0], -v[2], v[1]])


def y_down(v: Vectors) -> Vectors:
    """World of the first camera: x right, y down, z forward."""
    return np.array([v[0], -v[1], -v[2]])


def _left_handed(v: Vectors) -> Vectors:
    return np.array([v[0], v[1], -v[2]])


OPTICAL = ("right", "down", "forward")


def seven_numbers(matrix: Vectors) -> str:
    """Return x y z qx qy qz qw."""
    return " ".join(f"{x:.12g}" for x in (*matrix[:3, 3], *Rotation.from_matrix(matrix[:3, :3]).as_quat()))


def _pictures(colour: Path, depth: Path, one: Taken, per_metre: float) -> None:
    colour.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(one.colour).save(colour)
    write_depth(depth, one, per_metre)


def write_depth(path: Path, one: Taken, per_metre: float) -> None:
    """Write whole numbers of 16 bits."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.rint(one.depth_m * per_metre).astype(np.uint16)).save(path)


def _numbered(folder: Path, frames: list[Taken], colour: str, per_metre: float) -> None:
    for i, one in enumerate(frames):
        _pictures(folder / colour / f"{i}.png", folder / "depth" / f"{i}.png", one, per_metre)


def write_tum(folder: Path, frames: list[Taken]) -> None:
    """Write with clocks that begin at 1305031102 s, depth 5 ms after colour and poses at 90 Hz."""
    colours, depths, poses = ["# color images"], ["# depth maps"], ["# timestamp tx ty tz qx qy qz qw"]
    for i, one in enumerate(frames):
        _pictures(folder / f"rgb/{i}.png", folder / f"depth/{i}.png", one, 5000)
        time_ns = 1305031102_175304000 + one.time_ns
        colours.append(f"{seconds(time_ns)} rgb/{i}.png")
        depths.append(f"{seconds(time_ns + 5_000_000)} depth/{i}.png")
        for part, pose in enumerate([one.pose] if i == len(frames) - 1 else _thirds(one.pose, frames[i + 1].pose)):
            at = round(part * (1e9 / RATE_HZ) / 3)
            poses.append(
                f"{seconds(time_ns + at)} {seven_numbers(camera_matrix(attrs.evolve(one, pose=pose), OPTICAL, z_up))}"
            )
    for name, lines in (("rgb", colours), ("depth", depths), ("groundtruth", poses)):
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _thirds(one: Pose, other: Pose) -> list[Pose]:
    return [one, one.towards(other, 1 / 3), one.towards(other, 2 / 3)]


def seconds(time_ns: int) -> str:
    """Return seconds with nine decimals."""
    return f"{time_ns // 10**9}.{time_ns % 10**9:09d}"


def write_icl_nuim(folder: Path, frames: list[Taken]) -> None:
    """Write with y up and a left-handed world, as the renderer has it."""
    _numbered(folder, frames, "rgb", 5000)
    rows = (
        f"{i} {seven_numbers(camera_matrix(one, ('right', 'up', 'forward'), _left_handed))}"
        for i, one in enumerate(frames)
    )
    (folder / "livingRoom0.gt.freiburg").write_text("\n".join(rows), encoding="utf-8")


def write_numbered(folder: Path, frames: list[Taken]) -> None:
    """Write with a line of a pose for each picture."""
    _numbered(folder, frames, "color", 1000)
    rows = (seven_numbers(camera_matrix(frame, OPTICAL, y_down)) for frame in frames)
    (folder / "pose.txt").write_text("\n".join(rows), encoding="utf-8")


def write_redwood(folder: Path, frames: list[Taken]) -> None:
    """Write with matrices and the intrinsics that Open3D writes, by columns."""
    _numbered(folder, frames, "color", 1000)
    lines = []
    for i, one in enumerate(frames):
        lines += [
            f"{i} {i} {i + 1}",
            *(" ".join(f"{x:.12g}" for x in row) for row in camera_matrix(one, OPTICAL, y_down)),
        ]
    (folder / "trajectory.log").write_text("\n".join(lines), encoding="utf-8")
    wide, high = frames[0].colour.shape[1::-1]
    camera = {"width": wide, "height": high, "intrinsic_matrix": [FX, 0, 0, 0, FY, 0, CX, CY, 1]}
    (folder / "camera_intrinsic.json").write_text(json.dumps(camera), encoding="utf-8")


def write_nerfstudio(folder: Path, frames: list[Taken]) -> None:
    """Write transforms.json; its pixel centres lie at 0.5."""
    _numbered(folder, frames, "images", 1000)
    listed = [
        {
            "file_path": f"images/{i}.png",
            "depth_file_path": f"depth/{i}.png",
            "transform_matrix": camera_matrix(one, ("right", "up", "back"), z_up).tolist(),
        }
        for i, one in enumerate(frames)
    ]
    wide, high = frames[0].colour.shape[1::-1]
    camera = {
        "camera_model": "OPENCV", "fl_x": FX, "fl_y": FY, "cx": CX + 0.5, "cy": CY + 0.5, "w": wide, "h": high, "k1": 0,
    }  # fmt: skip
    (folder / "transforms.json").write_text(json.dumps({**camera, "frames": listed}), encoding="utf-8")


def _facts(one: Taken) -> dict[str, object]:
    return {
        "position_m": one.pose.position_m.tolist(),
        "orientation_xyzw": one.pose.orientation_xyzw.tolist(),
        "time_s": one.time_ns * 1e-9,
    }


def write_npz(folder: Path, frames: list[Taken]) -> None:
    """Write each frame as `hmdwarp warp` takes it."""
    for i, one in enumerate(frames):
        fov = fov_of(one.colour.shape[1::-1])
        facts = {"fov": attrs.astuple(fov)[:4], **_facts(one)}
        np.savez(folder / f"frame-{i}.npz", colour=one.colour, depth_m=one.depth_m, **facts)


def write_pictures(folder: Path, frames: list[Taken]) -> None:
    """Write pictures with depth and a JSON beside each, and what all share in camera.json."""
    for i, one in enumerate(frames):
        _pictures(folder / f"{i}.png", folder / f"{i}.depth.png", one, 1000)
        (folder / f"{i}.json").write_text(json.dumps(_facts(one)), encoding="utf-8")
    shared = {"intrinsics": [FX, FY, CX, CY], "depth_scale": 0.001}
    (folder / "camera.json").write_text(json.dumps(shared), encoding="utf-8")


def write_exrs(folder: Path, frames: list[Taken]) -> None:
    """Write EXR files with their own Z, and a JSON beside each."""
    import OpenEXR

    from hmdwarp.colour import linear_from_srgb

    for i, one in enumerate(frames):
        light = linear_from_srgb(one.colour)
        channels = {name: np.ascontiguousarray(light[..., c]) for c, name in enumerate("RGB")} | {"Z": one.depth_m}
        OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, channels).write(str(folder / f"{i}.exr"))
        facts = {"intrinsics": [FX, FY, CX, CY], **_facts(one)}
        (folder / f"{i}.json").write_text(json.dumps(facts), encoding="utf-8")


STATED = SequenceOptions(intrinsics=parse_intrinsics(f"{FX},{FY},{CX},{CY}"))
AS_TUM = attrs.evolve(STATED, depth_scale=1 / 5000)
MIRRORED = attrs.evolve(AS_TUM, intrinsics=parse_intrinsics(f"{FX},{-FY},{CX},{CY}"))
MILLIMETRES = attrs.evolve(STATED, depth_scale=0.001)
# By name: the reader that must recognise it, who writes it, and what the user has to say.
LAYOUTS: dict[str, tuple[str, Callable[[Path, list[Taken]], None], SequenceOptions]] = {
    "tum": ("tum", write_tum, AS_TUM), "icl_nuim": ("icl_nuim", write_icl_nuim, MIRRORED),
    "numbered": ("numbered", write_numbered, MILLIMETRES), "redwood": ("redwood", write_redwood, SequenceOptions()),
    "nerfstudio": ("nerfstudio", write_nerfstudio, SequenceOptions()), "npz": ("folder", write_npz, SequenceOptions()),
    "pictures": ("folder", write_pictures, SequenceOptions()), "exr": ("folder", write_exrs, SequenceOptions()),
}  # fmt: skip
