"""Lamps of files.

`lamps-of-blender.glb` is a room open above and behind, as Blender 4.2 exports it: four walls, a
block, a lamp that swings, a spot and a sun.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from replays import run

from hmdwarp.base import SceneError
from hmdwarp.cloudlight.radiosity import direct_light, receivers_of
from hmdwarp.scenes import ATLAS, lamps_at, load_scene

from .glb import IN_PLACE, Glb

ROOM = Path(__file__).parent / "files" / "lamps-of-blender.glb"
LIGHTS = "KHR_lights_punctual"
CANDELA_PER_WATT = 683 / (4 * np.pi)  # as Blender exports; of a spot too
POINT, SPOT, SUN = (
    {"type": "point", "name": "Point", "color": [1, 0.9, 0.7], "intensity": 60 * CANDELA_PER_WATT},
    {
        "type": "spot",
        "name": "Spot",
        "color": [0.5, 0.7, 1],
        "intensity": 150 * CANDELA_PER_WATT,
        "spot": {"innerConeAngle": 0.35, "outerConeAngle": 0.6},
    },
    {"type": "directional", "name": "Sun", "color": [1, 1, 1], "intensity": 1.5 * 683},
)


def test_lamps_stand_and_shine_as_the_file_says():
    """In candela and lux, times one factor; turned as their nodes are; the first one moves."""
    scene = load_scene(ROOM, IN_PLACE)
    point, spot, sun = scene.lamps
    assert not scene.bodies and not spot.is_sun and sun.is_sun and spot.cone == (0.35, 0.6)
    factor = point.colour[0] / POINT["intensity"]
    for lamp, said in zip(scene.lamps, (POINT, SPOT, SUN), strict=True):
        assert np.allclose(lamp.colour, factor * said["intensity"] * np.array(said["color"]))
    places = [point.place(ns)[:3] for ns in (0, 250_000_000, 500_000_000, 1_500_000_000)]
    expected = [(-0.8, 1.9, -0.6), (-0.2, 1.8, -0.4), (0.4, 1.7, -0.2), (0.4, 1.7, -0.2)]
    assert np.allclose(places, expected)
    assert np.allclose(spot.place(0)[:3], (1.1, 2.4, -0.4))
    assert np.allclose(spot.fading(0)[:3] / np.linalg.norm(spot.fading(0)[:3]), (0, -1, 0), atol=1e-6)
    assert all(mesh.light_uv is not None for mesh in scene.meshes)
    assert f"times {factor:.3g}" in scene.notes[-1]


def test_pointers_of_an_animation_are_not_followed_and_one_note_says_where_they_lead(tmp_path):
    """What they point at stays as the file has it, beside nodes, which move."""
    glb, lights = Glb.of(ROOM), f"/extensions/{LIGHTS}/lights"
    shows = "/nodes/4/extensions/KHR_node_visibility/visible"
    glb.header["extensionsUsed"].append("KHR_animation_pointer")
    glb.animate("", [0, 9.0], [[20.0], [80.0]], pointer=f"{lights}/1/intensity")
    glb.animate("", [0, 1.0], [[0.2], [0.4]], pointer=f"{lights}/1/spot/innerConeAngle")
    glb.animate("", [0, 1.0], np.array([[1], [0]], np.uint8), "STEP", pointer=shows)
    found, still = glb.load(tmp_path), load_scene(ROOM, IN_PLACE)
    for lamp, plain in zip(found.lamps, still.lamps, strict=True):
        assert (lamp.colour, lamp.cone, lamp.brightness) == (plain.colour, plain.cone, None)
        for ms in (0, 700, 1300):  # the animation of nodes repeats after its own second
            assert np.array_equal(lamp.place(ms * 1_000_000), plain.place(ms * 1_000_000))
    assert len(found.bodies) == len(still.bodies) and len(found.meshes) == len(still.meshes)
    (note,) = [note for note in found.notes if "pointers are not followed" in note]
    assert f"{lights}/1/intensity" in note
    assert not any("KHR_animation_pointer" in other for other in found.notes if other != note)


def test_a_spot_fades_between_its_angles():
    """By the extension's formula, from arc cosines, on a floor below it."""
    scene = load_scene(ROOM, IN_PLACE)
    (spot,) = [lamp for lamp in lamps_at(scene, 0) if lamp[0][3] and np.abs(lamp[0][4:7]).any()]
    angles = np.array([0.0, 0.3, 0.4, 0.5, 0.59, 0.61, 0.8])
    below = spot[0][:3] + np.stack([np.sin(angles), -np.cos(angles), 0 * angles], axis=1)
    up = np.tile((0.0, 1.0, 0.0), (len(angles), 1))
    clear = receivers_of(scene).blockers
    clear = type(clear)(clear.corners[:0])
    between = np.clip((np.cos(angles) - np.cos(0.6)) / (np.cos(0.35) - np.cos(0.6)), 0, 1)
    expected = (between**2 * np.cos(angles))[:, None] * np.array(spot[1])
    assert np.allclose(direct_light(clear, below, up, [spot]), expected, atol=1e-9)


def test_white_surfaces_have_half_light_on_average():
    """Over what faces a lamp, whatever stands between, by points spread over each quad."""
    scene = load_scene(ROOM, IN_PLACE)
    clear = receivers_of(scene).blockers
    clear = type(clear)(clear.corners[:0])
    brightest = [(place, (max(colour),) * 3) for place, colour in lamps_at(scene, 0)]
    total = area = 0.0
    for mesh in scene.meshes:
        for triangle in mesh.triangles:
            a, b, c = mesh.positions[triangle].astype(float)
            size = np.linalg.norm(np.cross(b - a, c - a))
            normal = mesh.normals[triangle[:1]].astype(float)
            light = direct_light(clear, (a + b + c)[None] / 3, normal, brightest)
            total, area = total + size * light[0, 0], area + size * bool(light.any())
    assert total / area == pytest.approx(0.5, rel=1e-5)


def test_each_triangle_has_texels_of_its_own():
    receivers = receivers_of(load_scene(ROOM, IN_PLACE))
    texels = receivers.patches.texels
    assert len(np.unique(texels, axis=0)) == len(texels) and texels.min() >= 1 and (texels.max(axis=0) < ATLAS).all()
    # A floor of 4 x 4 m, three walls of 2.6 m, and a block of 0.5 x 0.9 m: three sides and a top.
    areas = 4 * 4 + 3 * 4 * 2.6 + 3 * 0.5 * 0.9 + 0.5 * 0.5
    assert receivers.patches.areas.sum() == pytest.approx(areas, rel=1e-5)


def grid(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles apart from each other: none makes a parallelogram with a neighbour."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0.3, 0.8, 0)], np.float32)
    places = np.arange(count)[:, None, None] * np.array((1.5, 0, 0), np.float32)
    return (corners + places).reshape(-1, 3), np.arange(3 * count, dtype=np.uint32)


@pytest.mark.parametrize(
    ("count", "lamps", "said"),
    [
        (441, 1, ""),
        (442, 1, "442 flat pieces"),
        (66_000, 1, "66,000 lit triangles, expected 1 to 882"),
        (1, 5, "there are 5"),
    ],
)
def test_what_does_not_fit_has_a_plain_light_and_is_said_with_the_figure(tmp_path, count, lamps, said):
    positions, indices = grid(count)
    glb = Glb()
    glb.header["meshes"] = [{"primitives": [{"attributes": {"POSITION": glb.numbers(positions)}}]}]
    glb.header["extensions"] = {LIGHTS: {"lights": [POINT]}}
    glb.header["nodes"] += [{"translation": [0, 0, 1], "extensions": {LIGHTS: {"light": 0}}}] * lamps
    glb.header["scenes"][0]["nodes"] = list(range(1 + lamps))
    scene = glb.load(tmp_path)
    assert len(scene.lamps) == (0 if said else lamps)
    left_out = f"its lamps are left out, and a plain light from above is used: {said}"
    assert bool(said) == any(left_out in note for note in scene.notes)
    if not said:
        assert len(receivers_of(scene).patches) == count
        assert (np.ptp(scene.meshes[0].light_uv[:3], axis=0) == 1.5).all()  # the middle of its texel lies inside


@pytest.mark.parametrize(
    ("light", "node"),
    [
        ({"type": "area"}, {}),
        ({"type": "point", "intensity": -1}, {}),
        ({"type": "spot", "spot": {"innerConeAngle": 1.0, "outerConeAngle": 0.5}}, {}),
        ({"type": "point"}, {"scale": [0, 1, 1]}),
        (None, {}),
    ],
)
def test_damaged_lamps_are_refused_in_one_line(tmp_path, light, node):
    glb = Glb()
    glb.header["extensions"] = {LIGHTS: {"lights": [light] if light else []}}
    glb.header["nodes"].append({**node, "extensions": {LIGHTS: {"light": 0}}})
    glb.header["scenes"][0]["nodes"] = [0, 1]
    with pytest.raises(SceneError, match="node 1") as refusal:
        glb.load(tmp_path)
    assert "\n" not in str(refusal.value)


def test_a_strategy_for_moving_light_runs_on_it(tmp_path, gpu):
    """Light is late, surfaces are not: nearer to the truth than the late picture as it is."""
    own = {"scene": str(ROOM), "latency_ms": 100.0, "seconds": 0.2, "rate_hz": 20.0, "metrics_every": 2, "gpu": gpu}
    late, found = (
        run(tmp_path / warp, **own, warp=warp).summary["quality"]["psnr_db"]["mean"] for warp in ("none", "irradiance")
    )
    assert found > late + 1
