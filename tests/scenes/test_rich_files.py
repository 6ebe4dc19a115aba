"""Effects follow from a GLB's content: skins, splines, mirrors, glass, cut-outs, a HUD."""

from __future__ import annotations

import numpy as np
import pytest
from worlds import read

from hmdwarp.client.effects import effects
from hmdwarp.colour import linear_from_srgb
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

from .glb import SQUARE, Glb

S = 1_000_000_000
NOTHING = Needs()


def metal(roughness: float = 0.0, **more) -> dict:
    base = {"metallicFactor": 1.0, "roughnessFactor": roughness, "baseColorFactor": [0.8, 0.7, 0.6, 1.0]}
    return {"pbrMetallicRoughness": base, **more}


def glass_of(colour, transmission: float, metallicFactor: float = 0.0) -> dict:  # noqa: N803 (a name of glTF)
    return {
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": transmission}},
        "pbrMetallicRoughness": {"baseColorFactor": list(colour), "metallicFactor": metallicFactor},
    }


@pytest.mark.parametrize("picture", [None, (200, 120, 250, 128)])
@pytest.mark.parametrize(
    "glass",
    [
        ((0.0, 0.0, 0.0, 0.25), 0.9, 0.0, "BLEND"),  # nearly opaque black for long; at least 75 % pass
        ((0.2, 0.9, 0.4, 0.25), 1.0, 0.0, "BLEND"),
        ((0.2, 0.9, 0.4, 0.6), 0.3, 0.5, "BLEND"),
        ((0.2, 0.9, 0.4, 0.6), 0.9, 1.0, "BLEND"),
        ((0.0, 0.0, 0.0, 0.25), 1.0, 1.0, "BLEND"),  # a metal by glTF's default: 75 % pass
        ((0.2, 0.9, 0.4, 0.6), 0.0, 0.0, "BLEND"),
        ((0.2, 0.9, 0.4, 1.0), 0.7, 0.0, "OPAQUE"),
    ],
)
def test_glass_lets_pass_what_gltf_says(tmp_path, gpu, glass, picture):
    """A pane before a wall, against the same two things drawn alone.

    By glTF alpha is coverage: what it leaves free passes. Of what it covers, the transmission
    passes, coloured by base colour and texture, the rest is the surface's own; metal lets nothing.
    Source: Khronos 2021, KHR_materials_transmission.
    """
    colour, transmission, metallic, mode = glass
    wall = {"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.5, 0.3, 1], "metallicFactor": 0}}

    def drawn(pane: dict | None, needs: Needs = NOTHING) -> dict[str, np.ndarray]:
        glb = Glb()
        glb.header["materials"] = [wall, pane or wall]
        glb.primitive["material"] = 0
        glb.header["meshes"].append({"primitives": [glb.primitive | {"material": 1}]})
        glb.header["nodes"].append({"mesh": 1, "translation": [0, 1, -2.5]})
        if pane is not None:
            glb.header["scenes"][0]["nodes"].append(1)
        if picture is not None and pane is not None:
            pane["pbrMetallicRoughness"]["baseColorTexture"] = glb.texture(np.full((8, 8, 4), picture, np.uint8))
        server = Server(gpu, glb.load(tmp_path))
        eye = server.draw_frame([View(Pose((0, 1, 0)), Fov.symmetric(0.3, 0.3))], 0, (8, 8), needs=needs).eyes[0]
        found = {"colour": read(eye.colour)[..., :3]}
        if needs:
            layer = eye["transparent"]
            found |= {"veil": read(layer.veil.colour)[..., :3], "passing": read(layer.passing)[..., :3]}
        server.close()
        return found

    texel, cover = np.ones(3), colour[3]
    if picture is not None:
        texel = linear_from_srgb(np.array(picture[:3]) / 255)
        cover *= picture[3] / 255 if mode != "OPAQUE" else 1
    through = transmission * (1 - metallic)
    passing = 1 - cover + cover * through * np.array(colour[:3]) * texel
    behind, solid = (drawn(pane)["colour"] for pane in (None, glass_of((*colour[:3], 1.0), 0.0)))
    expected = passing * behind + cover * (1 - through) * solid
    material = glass_of(colour, transmission, metallicFactor=metallic) | {"alphaMode": mode}
    # Light is at most 1, bytes of textures are exact to half of one in 255; half floats to 2^-11.
    assert np.abs(drawn(material)["colour"] - expected).max() < 2e-3
    layers = drawn(material, Needs(transparent=True))
    assert np.abs(layers["passing"] - passing).max() < 1e-3
    assert np.abs(layers["passing"] * behind + layers["veil"] - expected).max() < 2e-3
    assert passing.min() >= 1 - cover - 1e-9


def test_an_obj_says_by_d_how_much_it_dissolves(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl glass\nKd 0.2 0.4 0.6\nd 0.3\n")
    corners = "\n".join(f"v {x} {y} {z}" for x, y, z in SQUARE)
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{corners}\nusemtl glass\nf 1 2 3\nf 1 3 4\n")
    scene = load_scene(tmp_path / "a.obj")
    assert effects.of(scene) == ("transparency",) and scene.meshes[0].material.opacity == pytest.approx(0.3)


@pytest.mark.parametrize("kind", ["LINEAR", "CUBICSPLINE"])
def test_velocities_are_those_of_the_poses(tmp_path, kind):
    """Of a node below another that turns too: by differences of the poses a microsecond apart."""
    rng = np.random.default_rng(4)
    glb = Glb()
    glb.header["nodes"].append({"name": "arm", "children": [0], "translation": [1, 0, 0], "scale": [2, 2, 2]})
    glb.header["scenes"][0]["nodes"] = [1]
    each = 3 if kind == "CUBICSPLINE" else 1
    for node in (0, 1):
        turns = rng.normal(size=(3 * each, 4))
        turns /= np.linalg.norm(turns, axis=1, keepdims=True) if each == 1 else 1
        glb.animate("rotation", (0, 1, 3), turns, kind, node).animate(
            "translation", (0, 2), rng.normal(size=(2 * each, 3)), kind, node
        )
    motion = glb.load(tmp_path).bodies[0].motion
    for t in (0.3, 0.7, 1.4, 2.6):
        before, at, after = (motion.state(round(t * S) + step) for step in (-1000, 0, 1000))
        velocity = (after.pose.position_m - before.pose.position_m) / 2e-6
        spin = (after.pose.rotation * before.pose.rotation.inv()).as_rotvec() / 2e-6
        # Positions of some metres keep 1e-16 of that: 1e-9 m/s over 2 us. The error of a central
        # difference is far smaller.
        assert np.allclose(at.velocity_m_s, velocity, atol=1e-5)
        assert np.allclose(at.angular_velocity_rad_s, spin, atol=1e-5)
