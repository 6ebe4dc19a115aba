"""Draw a sequence with Mitsuba 3, a path tracer that shares nothing with this project.

    python docs/measure/mitsuba_frames.py FOLDER

A head slides past a railing and a ball of glass, over a glossy floor, under a lamp; every picture
is antialiased and has noise, depth is that of a pixel's centre. FOLDER is as `--frames` takes it.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

COUNT, RATE_HZ, SIZE, SAMPLES = 12, 30, (80, 64), 64
TANGENTS = np.tan(np.radians(40)) * np.array([1, SIZE[1] / SIZE[0]])  # of half the field of view
# From Mitsuba's camera, which looks along +z with x to the left, to OpenXR's.
AXES = np.diag([-1.0, 1.0, -1.0, 1.0])
Picture = tuple[NDArray[np.uint8], NDArray[np.float32]]


def pose_at(number: int) -> tuple[NDArray[np.float64], Rotation]:
    """Return where the head is at a frame: 75 cm/s to the right and ahead, turning and rolling.

    Without all of that no frames could tell every convention.
    """
    step = number / (COUNT - 1)
    turn = Rotation.from_euler("yxz", [8 - 16 * step, -10 + 14 * step, 6 * np.sin(5 * step)], degrees=True)
    return np.array([0.25 * step - 0.1, 1.6 - 0.1 * step, 0.3 - 0.15 * step]), turn


def scene(mi: Any) -> Any:
    """Return the scene: metres, +y up."""
    place = mi.ScalarTransform4f
    matt = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.55, 0.45, 0.35]}}
    tiles = {"type": "checkerboard", "to_uv": place().scale([10, 10, 1])}
    pattern = {"type": "checkerboard", "color0": {"type": "rgb", "value": [0.2, 0.3, 0.5]}}
    paper = {"type": "diffuse", "reflectance": {**pattern, "to_uv": place().scale([16, 8, 1])}}
    parts: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 8},
        "floor": {
            "type": "rectangle",
            "to_world": place().rotate([1, 0, 0], -90).scale(4),
            "bsdf": {"type": "roughplastic", "alpha": 0.1, "diffuse_reflectance": tiles},
        },
        "wall": {"type": "rectangle", "to_world": place().translate([0, 1, -4]).scale([5, 3, 1]), "bsdf": paper},
        "glass": {
            "type": "sphere",
            "center": [0.7, 1.3, -2.2],
            "radius": 0.3,
            "bsdf": {"type": "dielectric", "int_ior": 1.5},
        },
        "lamp": {
            "type": "rectangle",
            "to_world": place().translate([0, 3.2, -1.5]).rotate([1, 0, 0], 90).scale(0.8),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 20.0}},
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.25}},
    }
    for number in range(7):  # a railing, whose bars are two pixels wide
        x = 0.25 * number - 1.2
        parts[f"bar{number}"] = {"type": "cylinder", "p0": [x, 0, -1.5], "p1": [x, 1.5, -1.5], "radius": 0.02}
        parts[f"bar{number}"]["bsdf"] = matt
    return mi.load_dict(parts)


def drawn(mi: Any, world: Any, number: int) -> Picture:
    """Return colour (h, w, 3) sRGB and depth (h, w) in metres along -z, inf for the sky."""
    position, turn = pose_at(number)
    to_world = np.eye(4)
    to_world[:3, :3], to_world[:3, 3] = turn.as_matrix(), position
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}}
    sensor = mi.load_dict(
        {
            "type": "perspective",
            "fov": 2 * float(np.degrees(np.arctan(TANGENTS[0]))),
            "to_world": mi.ScalarTransform4f((to_world @ AXES).tolist()),
            "film": film,
        }
    )
    light = np.clip(np.array(mi.render(world, sensor=sensor, spp=SAMPLES, seed=number))[..., :3], 0, 1)
    colour = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(255 * colour).astype(np.uint8), _depth(mi, world, position, turn)


def _depth(mi: Any, world: Any, position: NDArray[np.float64], turn: Rotation) -> NDArray[np.float32]:
    x, y = ((2 * (np.arange(n) + 0.5) / n - 1) * tangent for n, tangent in zip(SIZE, TANGENTS, strict=True))
    depth = np.full(SIZE[::-1], np.inf, np.float32)
    for row, column in np.ndindex(depth.shape):
        # A direction of length 1 along -z: the distance along it is the depth.
        direction = turn.apply([x[column], -y[row], -1])
        hit = world.ray_intersect_preliminary(mi.Ray3f(position.tolist(), direction.tolist()))
        if hit.is_valid():
            depth[row, column] = hit.t
    return depth


def draw(folder: Path) -> None:
    """Write the sequence. Errors: ImportError without Mitsuba."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")  # the one that needs no LLVM
    across, up = np.arctan(TANGENTS)
    world = scene(mi)
    for number in range(COUNT):
        colour, depth_m = drawn(mi, world, number)
        position, turn = pose_at(number)
        np.savez(
            folder / f"{number:02}.npz", colour=colour, depth_m=depth_m, fov=(-across, across, -up, up),
            position_m=position, orientation_xyzw=turn.as_quat(), time_s=number / RATE_HZ,
        )  # fmt: skip


if __name__ == "__main__":
    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    draw(Path(sys.argv[1]))
