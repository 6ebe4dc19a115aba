"""Points on the client: a sphere of them is where it is, and hard ones do no harm."""

from __future__ import annotations

import numpy as np
import pytest
from client_scene import ClientScene
from replays import run
from worlds import read

from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.client.warps import Output
from hmdwarp.cloudlight.photons import octahedral
from hmdwarp.cloudlight.points import Block, Cloud, KeptPoints, packed_sky
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate
from hmdwarp.link import LinkOptions

SIZE, FOV = (64, 48), Fov(-0.5, 0.5, -0.4, 0.4)
EYE = View(Pose((0.3, -0.1, 0.2), (0.02, 0.05, 0.0, 0.998)), FOV)
SKY = np.array([[0.25, 0.5, 1.0], [0.5, 0.5, 0.5], [0.125, 0.25, 0.125]])
COUNT = 4096


def content(points: np.ndarray, normals: np.ndarray, area: float, *, complete: bool = True) -> np.ndarray:
    """An update with these points in one cell, in blocks of 128."""
    low = points.min(axis=0).astype(np.float32).astype(float)
    edge = float(np.float32(max((points - low).max(), 1e-3)))
    steps = np.rint((points - low) / edge * 1023).clip(0, 1023).astype(np.uint32)
    packed = steps[:, 0] | steps[:, 1] << 10 | steps[:, 2] << 20
    colours = np.full((len(points), 3), (255, 128, 0), np.uint8)
    data = packed_sky(SKY, complete=complete)
    for number, at in enumerate(range(0, len(points), 128)):
        part = slice(at, at + 128)
        place = (float(low[0]), float(low[1]), float(low[2]))
        one = Block(0, 0, number, 0, False, place, edge, area, packed[part], octahedral(normals[part]), colours[part])
        data += one.packed()
    return np.frombuffer(data, np.uint8).copy()


def sphere(centre: tuple[float, float, float], radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Points on a sphere by the golden angle."""
    k = np.arange(COUNT) + 0.5
    z, angle = 1 - 2 * k / COUNT, np.pi * (1 + 5**0.5) * k
    normals = np.column_stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z])
    return np.array(centre) + radius * normals, normals


def shown(gpu, updates: list[np.ndarray], spec: str = "points", view: View = EYE) -> tuple[np.ndarray, np.ndarray]:
    """Colour and inverse depth, the same with and without depth and twice from the same pose."""
    geometry, choice = ClientScene(gpu), parse_warp(spec)
    warp = choice.entry(gpu, SIZE, SIZE, choice.settings, Output(depth=True), geometry)
    for update in updates:
        geometry.store(KeptPoints, Cloud()).receive(update)
    frame = EyeImage(view, allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR))
    canvas, depth = Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR)
    pictures = []
    for _ in range(2):
        warp.run_with_depth(PassInputs(frame, view), canvas, depth)
        gpu.gl.memory_barrier()
        pictures.append((read(canvas.texture), read(depth)[..., 0]))
    warp.close()
    assert all(np.array_equal(one, other) for one, other in zip(*pictures, strict=True))
    assert all(np.isfinite(picture).all() for picture in pictures[0])
    return pictures[0]


def test_a_sphere_of_points_is_the_sphere(gpu):
    """Discs lie behind the sphere by at most their sagitta and their tilt, where it is met steeply.

    Area 4 pi r^2 over 4096 points: discs of 1.1 sqrt(area / 4096) = 0.061 m, so the sagitta is 1.9
    mm; tilted by 0.7 degrees they are off by 0.7 mm; steps of position are 2 m / 2046 at most. Met
    at 45 degrees that is 1.5 times as much along the ray: 6 mm of 3 m.
    """
    centre, radius = np.array((0.1, 0.0, -3.0)), 1.0
    colour, depth = shown(gpu, [content(*sphere((0.1, 0.0, -3.0), radius), 4 * np.pi * radius**2)])
    left, right, down, up = FOV.tangents
    x = left + (np.arange(SIZE[0]) + 0.5) / SIZE[0] * (right - left)
    y = down + (np.arange(SIZE[1]) + 0.5) / SIZE[1] * (up - down)
    rays = np.stack([*np.meshgrid(x, y), np.full(SIZE[::-1], -1.0)], axis=2) @ EYE.pose.rotation_matrix.T
    off = centre - EYE.pose.position_m
    a, b, c = (rays**2).sum(axis=2), rays @ off, off @ off - radius**2
    root = b * b - a * c
    at = (b - np.sqrt(np.maximum(root, 0))) / a
    normal = (rays * at[..., None] - off) / radius
    steep = (root > 0) & (-(normal * rays).sum(axis=2) / np.sqrt(a) > 0.7)
    assert steep.sum() > 300
    assert np.abs(1 / depth[steep] - at[steep]).max() < 0.006
    assert (colour[steep, 3] == 1).all() and np.abs(colour[steep, 1] - 0.2159).max() < 1e-3
    beside = root < -2
    assert (depth[beside] == 0).all() and (colour[beside, 3] == 1).all(), "the sky"


def test_the_sky_fades_from_horizon_to_zenith_and_is_a_hole_before_the_first_picture(gpu):
    behind = sphere((0.0, 0.0, 5.0), 1.0)
    colour, depth = shown(gpu, [content(*behind, 12.0)], view=View(Pose((0.0, 0.0, 0.0)), FOV))
    assert (depth == 0).all(), "what lies behind the eye is not seen"
    assert colour[-1, 32, 2] > colour[24, 32, 2] and colour[0, 32, 0] < colour[23, 32, 0]
    colour, depth = shown(gpu, [content(*behind, 12.0, complete=False)])
    assert (depth == -1).all() and not colour.any()


@pytest.mark.parametrize(
    ("points", "area"),
    [
        ([[0.0, 0.0, -1e6]], 1.0),
        ([[0.0, 0.0, -2.0]], 0.0),
        ([[0.3, -0.1, 0.2]], 1.0),
        ([[0.3, -0.1, 2.0]], 1.0),
        ([[0.0, 0.0, -1e30]], 1e30),
    ],
    ids=["far", "radius 0", "in the eye", "behind the eye", "beyond"],
)
def test_hard_points(gpu, points, area):
    points = np.repeat(np.array(points), 16, axis=0)
    normals = np.repeat([[0.0, 0.0, 1.0]], 16, axis=0)
    colour, depth = shown(gpu, [content(points, normals, area)])
    if area == 0.0 or points[0, 2] == -1e6:
        assert (depth > 0).sum() == 1 and colour[depth > 0, 0] == 1
    assert np.isfinite(colour).all() and np.isfinite(depth).all()
    if points[0, 2] > EYE.pose.position_m[2]:
        assert (depth == 0).all(), "sky alone"


def test_a_denser_cloud_is_no_worse_at_rest(tmp_path):
    """It was: what covers no middle of a pixel hid what does; finer texture was not averaged."""
    said = {"trace": "still", "scene": "planes", "fill": "none", "latency_ms": 30.0, "seconds": 0.3, "size": (48, 40)}
    warps = [f"points:spacing={spacing},budget=3000000" for spacing in (1.0, 0.5, 0.25)]
    quality = [run(tmp_path / "out", warp=warp, metrics_every=1, **said).rows[-1]["psnr_db"] for warp in warps]
    assert quality[0] < quality[1] < quality[2]


@pytest.mark.parametrize(
    "network", [LinkOptions(), LinkOptions.of({"loss": "0.2", "jitter": "uniform:20", "link_seed": 4})], ids=["", "bad"]
)
def test_only_points_cross_and_they_stop_once_all_have_arrived(tmp_path, network):
    more = {"warp": "points:budget=400000", "fill": "pyramid", "latency_ms": 50.0, "seconds": 0.5, "network": network}
    summary = run(tmp_path, scene="planes", **more).summary
    assert set(summary["link"]["layers_mbit_s"]) == {"points"}
    (cloud,) = summary["client_models"]
    assert cloud["first_picture_bytes"] and cloud["points"] > 1000
    assert cloud["arrived_bytes"] < 9 * 1.3 * cloud["points"] + 20 * 60
