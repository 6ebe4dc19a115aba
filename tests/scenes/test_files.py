"""Users' files arrive as written, and broken ones are refused in one clear line."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from hmdwarp.base import InputError
from hmdwarp.scenes import SceneOptions, load_scene

from .glb import IN_PLACE


def polygon(rng: np.random.Generator) -> np.ndarray:
    """Return (n, 2) corners seen from the middle one after another, far and near: often hollow."""
    count = int(rng.integers(3, 12))
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(0.1, 0.9, count)) / count
    corners = rng.uniform(0.2, 1, count)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return corners[:: rng.choice([-1, 1])]


def is_inside(point: np.ndarray, corners: np.ndarray) -> bool:
    """Return by the even-odd rule: whether a ray to the right crosses the border once or thrice."""
    (x, y), after = point, np.roll(corners, -1, axis=0)
    cross = (corners[:, 1] > y) != (after[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = corners[:, 0] + (y - corners[:, 1]) / (after[:, 1] - corners[:, 1]) * (after[:, 0] - corners[:, 0])
    return bool((cross & (at > x)).sum() % 2)


@pytest.mark.parametrize("ending", ["obj", "ply"])
@pytest.mark.parametrize("seed", range(10))
def test_polygons_of_any_shape_are_covered_once_with_their_picture(seed, ending, tmp_path):
    """Triangles lie inside by the even-odd rule, have its area (shoelace) and uv of their place."""
    rng = np.random.default_rng(seed)
    several = [polygon(rng) + (3 * k, 0) for k in range(6)]
    before = ["mtllib a.mtl", "usemtl a", "vt 9 9"] if ending == "obj" else []
    lines, counts, first = before, np.cumsum([0, *map(len, several)]), rng.choice([0, 1])
    for corners, start in zip(several, counts, strict=False):
        lines += [f"v {x} {y} {x}" for x, y in corners] + [f"vt {x / 20 + 0.1} {y / 3 + 0.5}" for x, y in corners]
        numbers = [
            (at - len(corners),) * 2 if first else (start + at + 1, start + at + 2) for at in range(len(corners))
        ]
        lines.append("f " + " ".join(f"{v}/{vt}" for v, vt in numbers))
    if ending == "ply":
        places = [f"{x} {y} {x}" for corners in several for x, y in corners]
        faces = [
            f"{len(c)} {' '.join(map(str, at + np.arange(len(c))))}" for c, at in zip(several, counts, strict=False)
        ]
        head = f"ply\nformat ascii 1.0\nelement vertex {len(places)}\n" + "".join(
            f"property float {a}\n" for a in "xyz"
        )
        lines = [f"{head}element face 6\nproperty list uchar int vertex_indices\nend_header", *places, *faces]
    (tmp_path / "a.mtl").write_text("newmtl a\nmap_Kd picture.png\n")
    Image.fromarray(np.zeros((8, 8, 3), np.uint8)).save(tmp_path / "picture.png")
    (tmp_path / f"a.{ending}").write_text("\n".join(lines) + "\n")
    scene = load_scene(tmp_path / f"a.{ending}", IN_PLACE)
    mesh = scene.meshes[0]
    cut = (mesh.positions + scene.origin_m)[mesh.triangles][..., :2]
    ways = cut[:, 1:] - cut[:, :1]
    areas, middle = np.abs(np.linalg.det(ways)) / 2, cut.mean(axis=1)
    for k, corners in enumerate(several):
        own = np.abs(middle[:, 0] - 3 * k) < 1.5
        x, y = corners.T
        assert areas[own].sum() == pytest.approx(abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) / 2, rel=1e-5)
        assert all(is_inside(each, corners) for each, area in zip(middle[own], areas[own], strict=True) if area > 1e-6)
    if ending == "obj":
        place = (mesh.positions + scene.origin_m)[:, :2]
        assert np.allclose(mesh.uv, place / (20, 3) + (0.1, 0.5), atol=1e-5) and len(scene.textures) == 1


def test_a_scene_far_from_the_origin_keeps_its_float64_place(tmp_path):
    (tmp_path / "far.obj").write_text("v 1000000.125 0 0\nv 1000001.125 0 0\nv 1000000.125 1.5 0\nf 1 2 3\n")
    scene = load_scene(tmp_path / "far.obj", IN_PLACE)
    assert np.abs(scene.meshes[0].positions).max() < 10
    assert np.allclose(scene.meshes[0].positions[0] + scene.origin_m, (1000000.125, 0, 0), atol=1e-6)


@pytest.mark.parametrize("option", [{"scale": 0.01}, {"up": "z"}, {"viewpoint": "0,1,2"}, {"animation": "none"}])
def test_scenes_of_the_library_take_no_options_of_files(option):
    (name,) = option
    flag = {"scale": "--scene-scale", "up": "--scene-up"}.get(name, f"--{name}")
    with pytest.raises(InputError, match=f"{flag} with scene 'planes': it is for scene files"):
        load_scene("planes", SceneOptions(**option))
