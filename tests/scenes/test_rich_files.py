"""Effects follow from a GLB's content: skins, splines, mirrors, glass, cut-outs, a HUD."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from worlds import read

from hmdwarp.client.effects import effects
from hmdwarp.colour import linear_from_srgb
from hmdwarp.errors import SceneError
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import SceneOptions, is_cutout, load_scene
from hmdwarp.sources.server import Server

from .glb import BENT, SQUARE, Glb

S = 1_000_000_000
NOTHING = Needs()


def rgba(alpha) -> np.ndarray:
    image = np.full((8, 8, 4), 200, np.uint8)
    image[..., 3] = alpha
    return image


def metal(roughness: float = 0.0, **more) -> dict:
    base = {"metallicFactor": 1.0, "roughnessFactor": roughness, "baseColorFactor": [0.8, 0.7, 0.6, 1.0]}
    return {"pbrMetallicRoughness": base, **more}


def test_polished_metal_mirrors_and_dull_metal_does_not(tmp_path):
    shiny = Glb().material(**metal(0.02)).load(tmp_path, "shiny.glb")
    assert effects.of(shiny) == ("planar_reflections",)
    assert shiny.meshes[0].material.reflectivity == pytest.approx(0.7)
    assert not effects.of(Glb().material(**metal(0.3)).load(tmp_path, "dull.glb"))
    assert not effects.of(Glb().material(name="as most are").load(tmp_path, "plain.glb"))


def test_a_normal_map_on_a_mirror_makes_it_glossy_and_a_bent_one_is_curved(tmp_path):
    glb = Glb()
    scene = glb.material(**metal(normalTexture=glb.texture(rgba(255)))).load(tmp_path)
    assert effects.of(scene) == ("planar_reflections", "glossy_reflections")
    assert not scene.textures[scene.meshes[0].material.normal_map].srgb
    assert effects.of(Glb(BENT).material(**metal()).load(tmp_path)) == ("curved_reflections",)


def test_a_normal_map_is_as_strong_as_its_scale_says(tmp_path):
    glb = Glb()
    scene = glb.material(**metal(normalTexture=glb.texture(rgba(255)) | {"scale": 0.25})).load(tmp_path)
    assert scene.mirrors[0].normal_scale == 0.25


@pytest.mark.parametrize(
    ("ways", "repeats", "told"),
    [
        ({}, True, False),
        ({"wrapS": 33071, "wrapT": 33071}, False, False),
        ({"wrapS": 33071}, True, True),
        ({"wrapS": 33648, "wrapT": 33648}, True, True),
    ],
)
def test_a_sampler_says_whether_a_picture_wraps_around(tmp_path, ways, repeats, told):
    glb = Glb()
    picture = glb.texture(rgba(255)[..., :3])
    glb.header["samplers"] = [ways]
    glb.header["textures"][0]["sampler"] = 0
    scene = glb.material(pbrMetallicRoughness={"baseColorTexture": picture}).load(tmp_path)
    assert scene.textures[scene.meshes[0].texture].repeat is repeats
    assert any("wrap on both" in note for note in scene.notes) is told


def test_extras_say_how_much_something_mirrors(tmp_path):
    assert Glb().material(extras={"reflectivity": 0.3}).load(tmp_path).meshes[0].material.reflectivity == 0.3
    with pytest.raises(
        SceneError, match=r"thing\.glb: material 'floor': reflectivity 3 in its extras; expected a share"
    ):
        Glb().material(name="floor", extras={"reflectivity": 3}).load(tmp_path)


def glass_of(colour, transmission: float, metallicFactor: float = 0.0) -> dict:  # noqa: N803 (a name of glTF)
    return {
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": transmission}},
        "pbrMetallicRoughness": {"baseColorFactor": list(colour), "metallicFactor": metallicFactor},
    }


def test_transmission_of_metals_and_by_texture_is_noted(tmp_path):
    metal = Glb().material(**glass_of((1, 1, 1, 1), 0.9, 1.0)).load(tmp_path)
    assert not effects.of(metal) and "a metal transmits no light: what its alpha leaves free passes" in metal.notes[0]
    material = glass_of((1, 1, 1, 1), 0.9)
    material["extensions"]["KHR_materials_transmission"]["transmissionTexture"] = {"index": 0}
    (note,) = Glb().material(**material).load(tmp_path).notes
    assert "a transmission texture is left out, drawn with its factor everywhere" in note


def test_a_metallic_texture_says_how_much_is_glass(tmp_path):
    glb = Glb()
    material = glass_of((1, 1, 1, 1), 0.8, 1.0)
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = glb.texture(rgba(255)[..., :3] * 0 + 51)
    found = glb.material(**material).load(tmp_path).meshes[0].material
    assert found.transmission == pytest.approx(0.8 * 0.8)


def test_blended_and_transmitting_materials_are_see_through(tmp_path):
    quarter = {"baseColorFactor": [1, 1, 1, 0.25]}
    blend = Glb().material(alphaMode="BLEND", pbrMetallicRoughness=quarter).load(tmp_path, "blend.glb")
    assert effects.of(blend) == ("transparency",) and blend.meshes[0].material.opacity == 0.25
    glass = Glb().material(**glass_of((0.2, 1.0, 0.4, 1.0), 0.9)).load(tmp_path, "glass.glb").meshes[0]
    assert glass.material.opacity == 1 and glass.material.transmission == pytest.approx(0.9)
    assert np.allclose(glass.albedo, (0.2, 1.0, 0.4))
    assert not effects.of(Glb().material(alphaMode="BLEND").load(tmp_path, "opaque.glb"))  # lets nothing pass


@pytest.mark.parametrize(("mode", "told"), [("BLEND", True), ("MASK", True), ("OPAQUE", False)])
def test_alpha_of_vertex_colours_is_noted_where_it_counts(tmp_path, mode, told):
    glb = Glb()
    glb.primitive["attributes"]["COLOR_0"] = glb.numbers(np.tile([1.0, 1.0, 1.0, 0.3], (4, 1)))
    scene = glb.material(alphaMode=mode).load(tmp_path)
    assert any("the alpha of vertex colours is left out" in note for note in scene.notes) is told


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


def test_masked_materials_are_cut_out_by_alpha(tmp_path):
    alpha = np.zeros((8, 8), np.uint8)
    alpha[:, :3], alpha[:, 3:6] = 100, 200
    glb = Glb()
    base = {"baseColorTexture": glb.texture(rgba(alpha))}
    scene = glb.material(alphaMode="MASK", pbrMetallicRoughness=base).load(tmp_path)
    # A surface with holes: there is nothing to composite.
    assert not effects.of(scene) and is_cutout(scene, scene.meshes[0])
    assert np.array_equal(np.unique(scene.textures[0].image[..., 3], return_counts=True), ([0, 255], [40, 24]))
    with pytest.raises(SceneError, match="no triangles"):
        Glb().material(alphaMode="MASK", pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.2]}).load(tmp_path)


def test_an_obj_says_by_d_how_much_it_dissolves(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl glass\nKd 0.2 0.4 0.6\nd 0.3\n")
    corners = "\n".join(f"v {x} {y} {z}" for x, y, z in SQUARE)
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{corners}\nusemtl glass\nf 1 2 3\nf 1 3 4\n")
    scene = load_scene(tmp_path / "a.obj")
    assert effects.of(scene) == ("transparency",) and scene.meshes[0].material.opacity == pytest.approx(0.3)


def test_extras_of_a_node_fix_it_to_the_head(tmp_path):
    glb = Glb()
    glb.header["nodes"][0]["extras"] = {"head_locked": True}
    glb.header["nodes"].append({"mesh": 0, "translation": [40, 0, 0]})
    glb.header["scenes"][0]["nodes"].append(1)
    scene = glb.load(tmp_path)
    assert effects.of(scene) == ("overlay",)
    locked = next(mesh for mesh in scene.meshes if mesh.material.head_locked)
    assert np.allclose(locked.positions.mean(axis=0), (0, 1, -3))  # head axes: the scene's origin has no say
    assert np.array_equal(scene.origin_m, (40, 0, 0)) and np.allclose(locked.light, 1)


def with_panel(positions: np.ndarray = SQUARE, **extras) -> Glb:
    """A wall, and a rectangle of 3 x 2 m that shows a picture, turned by 90 degrees about +y."""
    glb = Glb(positions)
    page = np.random.default_rng(1).integers(0, 255, (6, 9, 3), np.uint8)
    glb.material(pbrMetallicRoughness={"baseColorTexture": glb.texture(page)})
    turned = {"rotation": [0, 0.5**0.5, 0, 0.5**0.5], "scale": [1.5, 1, 1], "translation": [-2, 1, 0]}
    glb.header["nodes"] = [{"mesh": 0, **turned, "extras": {"panel": True, **extras}}]
    glb.header["meshes"].append({"primitives": [{"attributes": {"POSITION": glb.numbers(SQUARE * 9)}}]})
    glb.header["nodes"].append({"mesh": 1, "translation": [0, 0, -5]})
    glb.header["scenes"][0]["nodes"].append(1)
    return glb


@pytest.mark.parametrize("locked", [False, True])
def test_extras_of_a_node_make_its_rectangle_a_panel(tmp_path, locked):
    scene = with_panel(occluded=True, head_locked=locked).load(tmp_path)
    assert effects.of(scene) == ("panels", "occluded_panels") and len(scene.meshes) == 1
    (panel,) = scene.panels
    assert panel.occluded and panel.head_locked == locked and panel.size_m == pytest.approx((3, 2))
    # Its picture faces +x, and its right is away from the viewer: -z.
    corners = panel.pose.transform(np.array([(-1.5, -1, 0), (1.5, -1, 0), (0, 0, 1)]))
    assert np.allclose(corners, [(-2, 0, 1.5), (-2, 0, -1.5), (-1, 1, 0)], atol=1e-6)
    page = np.random.default_rng(1).integers(0, 255, (6, 9, 3), np.uint8)
    assert np.array_equal(panel.pictures[0].image, page)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda glb: glb.header.pop("materials"), "has no picture"),
        (lambda glb: glb.primitive["attributes"].pop("TEXCOORD_0"), "expected texture coordinates from 0 to 1"),
    ],
)
def test_a_panel_that_shows_no_whole_picture_is_refused(tmp_path, change, why):
    glb = with_panel()
    change(glb)
    glb.primitive.pop("material") if "materials" not in glb.header else None
    with pytest.raises(SceneError, match=why):
        glb.load(tmp_path)
    with pytest.raises(SceneError, match="no rectangle"):
        with_panel(BENT).load(tmp_path)


HALF = 0.5**0.5
PLACES = ((0, 1, 0), (2, 1, 0), (2, 3, 0))
TURNS = ((0, 0, 0, 1), (0, HALF, 0, HALF), (0, 1, 0, 0))


def lift(**channels) -> Glb:
    """A still square, and one that is half as high and moves below a turned node."""
    glb = Glb()
    glb.header["nodes"] = [
        {"name": "lift", "mesh": 0, "translation": PLACES[0], "scale": [1, 0.5, 1]},
        {"name": "yard", "rotation": TURNS[1], "translation": [10, 0, 0], "children": [0]},
        {"mesh": 0},
    ]
    glb.header["scenes"][0]["nodes"] = [1, 2]
    for path, values in channels.items():
        glb.animate(path, (0.0, 1.0, 3.0), values)
    return glb


def test_an_animated_node_moves_as_its_keys_say(tmp_path):
    scene = lift(translation=PLACES, rotation=TURNS).load(tmp_path)
    assert effects.of(scene) == ("rigid_motion",) and [body.name for body in scene.bodies] == ["lift"]
    assert sorted(mesh.body for mesh in scene.meshes) == [0, 1]
    # Its own scale stays in its corners.
    assert np.allclose(next(mesh for mesh in scene.meshes if mesh.body).positions, SQUARE * (1, 0.5, 1))
    quarter = Rotation.from_euler("y", 90, degrees=True)
    for second, place, turn in ((0, PLACES[0], 0), (0.5, (1, 1, 0), 45), (2, (2, 2, 0), 135), (3.5, (1, 1, 0), 45)):
        state = scene.bodies[0].motion.state(round(second * S))
        assert np.allclose(state.pose.position_m, quarter.apply(place) + (10, 0, 0), atol=1e-6)
        expected = quarter * Rotation.from_euler("y", turn, degrees=True)
        assert (state.pose.rotation.inv() * expected).magnitude() < 1e-6
    state = scene.bodies[0].motion.state(S // 2)
    assert np.allclose(state.velocity_m_s, quarter.apply((2, 0, 0)), atol=1e-6)
    assert np.allclose(state.angular_velocity_rad_s, (0, np.pi / 2, 0), atol=1e-6)
    turning = lift(rotation=TURNS).load(tmp_path).bodies[0].motion.state(S)  # one channel is enough
    assert np.allclose(turning.pose.position_m, (10, 1, 0), atol=1e-6)


def test_a_node_that_grows_is_no_rigid_body(tmp_path):
    scene = lift(scale=((1, 0.5, 1), (1, 1, 1), (1, 1, 1))).load(tmp_path)
    assert effects.of(scene) == ("soft_motion",) and not scene.bodies
    grows = next(mesh.deformation for mesh in scene.meshes if mesh.deformation is not None)
    heights = [np.ptp(grows.positions(round(second * S))[:, 1]) for second in (0, 0.5, 1)]
    assert np.allclose(heights, (1.0, 1.5, 2.0), atol=1e-6)
    # Each end of 2 m of mesh, half a metre a second.
    assert np.allclose(np.abs(grows.velocities(S // 2)[:, 1]), 0.5, atol=1e-6)


def test_steps_jump_and_splines_follow_their_tangents(tmp_path):
    jumps = ((0, 0, 0), (5, 0, 0), (5, 0, 0))
    steps = Glb().animate("translation", (0, 1, 2), jumps, "STEP").load(tmp_path).bodies[0].motion
    assert [steps.state(round(t * S)).pose.position_m[0] for t in (0, 0.99, 1.01)] == [0, 0, 5]
    assert (steps.state(S // 2).velocity_m_s == 0).all()
    # Tangent in, value, tangent out: the parabola t^2 + t from 0 to 2 s, whose slopes are 1 and 5.
    keys = ((0, 0, 0), (0, 0, 0), (1, 0, 0), (5, 0, 0), (6, 0, 0), (0, 0, 0))
    spline = Glb().animate("translation", (0, 2), keys, "CUBICSPLINE").load(tmp_path).bodies[0].motion
    for t in (0.25, 1.0, 1.5):
        state = spline.state(round(t * S))
        assert state.pose.position_m[0] == pytest.approx(t * t + t, abs=1e-6)
        assert state.velocity_m_s[0] == pytest.approx(2 * t + 1, abs=1e-6)


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


def test_a_skin_goes_where_the_weighted_mean_of_its_joints_takes_it(tmp_path):
    turn = Rotation.from_rotvec((0, 0, np.pi / 2))
    keys = ((0, 0, 0, 1), turn.as_quat(), turn.as_quat())
    scene = Glb().skin().animate("rotation", (0, 1, 2), keys, node=2).load(tmp_path)
    assert effects.of(scene) == ("soft_motion",)
    deformation = scene.meshes[0].deformation
    rest, bent = (deformation.positions(round(t * S)) + scene.origin_m for t in (0, 1))
    assert np.allclose(rest, SQUARE, atol=1e-6)  # a skin's own node has no say
    about = np.array([0, 1, 0])
    turned = turn.apply(SQUARE - about) + about
    expected = np.array([SQUARE[0], SQUARE[1], turned[2], (SQUARE[3] + turned[3]) / 2])
    assert np.allclose(bent, expected, atol=1e-6)
    differences = (deformation.positions(S // 2 + 1000) - deformation.positions(S // 2 - 1000)) / 2e-6
    assert np.allclose(deformation.velocities(S // 2), differences, atol=1e-5)


def test_all_that_is_drawn_by_the_server(tmp_path, gpu):
    """A skinned mesh, a moving pane and a HUD in one file, in one picture."""
    glb = Glb().skin().animate("translation", (0, 1), ((0, 1, 0), (0, 2, 0)), node=2)
    glb.material(alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [1, 0, 0, 0.5]})
    glb.header["nodes"].append(
        {"mesh": 0, "translation": [0, 0, -2], "scale": [0.1, 0.1, 0.1], "extras": {"head_locked": True}}
    )
    glb.header["scenes"][0]["nodes"].append(3)
    scene = glb.load(tmp_path, options=SceneOptions())
    assert effects.of(scene) == ("soft_motion", "transparency", "overlay")
    server = Server(gpu, scene)
    pictures = [
        server.draw(View(scene.viewpoint, Fov.symmetric(1, 1)), (32, 32), time_ns=t).colour.read() for t in (0, S // 2)
    ]
    assert pictures[0] != pictures[1]
    server.close()


STILL, THREE = np.zeros((2, 3)), np.zeros((3, 3))
ONE_MATRIX = np.eye(4, dtype=np.float32).reshape(1, 16)
PUT = [{"mesh": 0, "matrix": np.eye(4).ravel().tolist()}]
UP = "animation 'walk', translation of node 'thing': "


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda g: g.animate("translation", (0, 1), STILL, node=7), "animation 'walk' uses number 7 of 1 nodes"),
        (lambda g: g.animate("translation", (1, 0.5), STILL), UP + "key 1 is at 0.5 s; .* increase"),
        (lambda g: g.animate("translation", (0, np.nan, 1), THREE), UP + "a key is not made of finite numbers"),
        (lambda g: g.animate("translation", (0, 1), STILL + np.inf), UP + "a key is not made of finite numbers"),
        (lambda g: g.animate("rotation", (0, 1), np.zeros((2, 4))), "rotation of node 'thing': key 0 is no rotation"),
        (lambda g: g.animate("translation", (0, 1, 2), STILL), "3 key times and 2 values; expected 1 for each"),
        (lambda g: g.animate("translation", (0, 1), STILL, "CUBICSPLINE"), "2 values; expected 3 for each"),
        (lambda g: g.animate("translation", (0, 1), STILL, "BEZIER"), "'BEZIER'; expected LINEAR, STEP or CUBICSPLINE"),
        (lambda g: g.animate("translation", (0, 1), STILL).header.update(nodes=PUT), "moves node 0.* has a matrix"),
        (
            lambda g: g.animate("translation", (0, 1), STILL).header["accessors"][-1].update(componentType=5121),
            "integers; expected floats",
        ),
        (
            lambda g: g.animate("translation", (0, 1), STILL).header["accessors"][-1].update(count=1000),
            "reaches beyond the file's",
        ),
        (lambda g: g.skin(np.tile((1.5, -0.5, 0, 0), (4, 1))), "skin 'figure': weights 1.5, -0.5, 0, 0 of vertex 0"),
        (lambda g: g.skin(joints=(0, 9, 0, 0)), "skin 'figure': a vertex uses joint 9, there are 2"),
        (
            lambda g: g.skin().primitive["attributes"].pop("WEIGHTS_0"),
            "skin 'figure': a mesh without joints and weights",
        ),
        (
            lambda g: g.skin().header["skins"][0].update(inverseBindMatrices=g.numbers(ONE_MATRIX)),
            "skin 'figure': 1 inverse bind matrices for 2 joints",
        ),
        (lambda g: g.skin().header["nodes"][2].update(children=[1]), "is its own ancestor|has two parents"),
    ],
)
def test_broken_files_are_refused_in_one_line(tmp_path, change, message):
    glb = Glb()
    change(glb)
    with pytest.raises(SceneError, match=rf"thing\.glb: .*({message})") as caught:
        glb.load(tmp_path)
    assert "\n" not in str(caught.value)
