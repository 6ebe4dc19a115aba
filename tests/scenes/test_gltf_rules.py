"""A glTF file is drawn as its specification says, and all of it arrives, or its loss is said."""

from __future__ import annotations

import io
import json
from contextlib import nullcontext

import attrs
import numpy as np
import pytest
from PIL import Image
from worlds import read

from hmdwarp.base import SceneError, linear_from_srgb
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import _gltf_nodes, _gltf_scene, load_scene, only_light, partial_scene, reduced, unlit
from hmdwarp.sources.server import Server

from .glb import IN_PLACE, SQUARE, Glb

BLACK, RED = {"baseColorFactor": [0, 0, 0, 1]}, {"baseColorFactor": [1, 0, 0, 1]}
# Colours are half floats of at most 4; bytes of textures are exact to half of one in 255.
HALF, BYTE = 2e-3, 4e-3


def middle(gpu, scene, eye=(0, 1, 0), time_ns: int = 0) -> tuple[np.ndarray, float]:
    """Colour and distance in metres straight ahead."""
    server = Server(gpu, scene)
    drawn = server.draw(View(Pose(eye), Fov.symmetric(0.3, 0.3)), (9, 9), time_ns=time_ns)
    colour, depth = read(drawn.colour)[4, 4, :3], read(drawn.inverse_depth)[4, 4]
    server.close()
    return colour, 1 / float(np.ravel(depth)[0]) if np.ravel(depth)[0] > 0 else np.inf


def emissive(base=None, **more) -> Glb:
    glb = Glb()
    return glb.material(pbrMetallicRoughness=base or BLACK, **more)


def flat(glb: Glb, colour) -> dict:
    return glb.texture(np.full((8, 8, 3), colour, np.uint8))


def test_an_open_sheet_has_one_side_unless_its_material_says_two(tmp_path, gpu):
    behind = (0, 1, -6)
    turned = Pose(behind, (0, 1, 0, 0))
    for both in (False, True):
        scene = Glb().material(doubleSided=both, pbrMetallicRoughness=RED).load(tmp_path, f"{both}.glb")
        server = Server(gpu, scene)
        drawn = server.draw(View(turned, Fov.symmetric(0.3, 0.3)), (9, 9))
        assert (read(drawn.inverse_depth)[4, 4] > 0) == both
        server.close()
        assert middle(gpu, scene)[1] == pytest.approx(3)


def _base(tmp_path, gpu) -> np.ndarray:
    """The square's colour without emission."""
    return middle(gpu, emissive(RED).load(tmp_path, "base.glb"))[0]


@pytest.mark.parametrize("textured", [False, True])
@pytest.mark.parametrize("shining", ["factor", "texture"])
def test_emission_is_added_to_what_the_light_shows(tmp_path, gpu, textured, shining):
    glb = Glb()
    base, more = dict(RED), {"emissiveFactor": [0.1, 0.5, 0.25]}
    if textured:
        base = {"baseColorTexture": flat(glb, (255, 0, 0))}
    glow = np.array([0.1, 0.5, 0.25])
    if shining == "texture":
        more["emissiveTexture"] = flat(glb, (60, 200, 255))
        glow = glow * linear_from_srgb(np.array([60, 200, 255]) / 255)
    scene = glb.material(pbrMetallicRoughness=base, **more).load(tmp_path)
    assert middle(gpu, scene)[0] == pytest.approx(_base(tmp_path, gpu) + glow, abs=BYTE)


def test_an_emissive_picture_lies_where_its_texture_coordinates_say(tmp_path, gpu):
    glb = Glb()
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:, 32:] = (0, 255, 0)  # on the right
    base = {"baseColorTexture": flat(glb, (255, 0, 0))}
    scene = glb.material(
        pbrMetallicRoughness=base, emissiveFactor=[1, 1, 1], emissiveTexture=glb.texture(picture)
    ).load(tmp_path)
    dark = _base(tmp_path, gpu)
    for x, green in ((-0.5, 0.0), (0.5, 1.0)):
        assert middle(gpu, scene, (x, 1, 0))[0] == pytest.approx(dark + (0, green, 0), abs=BYTE)


def _textured(tmp_path, **more):
    glb = Glb()
    base = {"baseColorTexture": flat(glb, (200, 0, 0)), "metallicFactor": 0}
    glow = {"emissiveFactor": [1, 1, 1], "emissiveTexture": flat(glb, (0, 200, 90))}
    return glb.material(pbrMetallicRoughness=base, **glow, **more).load(tmp_path, "textured.glb")


def test_a_client_that_draws_for_itself_draws_the_emission_too(tmp_path, gpu):
    scene = _textured(tmp_path)
    shown = middle(gpu, scene)[0]
    assert shown[1] > 0.5
    for own in (reduced(scene, 1, texture=0.5), partial_scene(scene, 1, 1, lit=True)):
        assert middle(gpu, own)[0] == pytest.approx(shown, abs=BYTE)
    assert middle(gpu, unlit(scene))[0][1] == pytest.approx(shown[1], abs=BYTE)
    assert middle(gpu, only_light(scene))[0][1] < 2  # light alone has no picture on it


def test_lamps_and_pictures_that_shine_exclude_each_other(tmp_path):
    lit = load_scene("lantern")
    shining = _textured(tmp_path).textures
    with pytest.raises(SceneError, match="shines"):
        attrs.evolve(lit, textures=[*lit.textures, *shining])


@pytest.fixture
def beside(tmp_path):
    """Write a .gltf whose picture lies in pictures/Red.png and is called `uri`."""
    glb = Glb()
    glb.material(pbrMetallicRoughness={"baseColorTexture": flat(glb, (255, 0, 0))})

    def make(uri: str):
        glb.write_gltf(tmp_path / "thing.gltf", inside=False)
        (tmp_path / "pictures").mkdir(exist_ok=True)
        (tmp_path / "picture 0.png").replace(tmp_path / "pictures" / "Red 1.png")
        header = json.loads((tmp_path / "thing.gltf").read_text(encoding="utf-8"))
        header["images"][0]["uri"] = uri
        (tmp_path / "thing.gltf").write_text(json.dumps(header), encoding="utf-8")
        return load_scene(tmp_path / "thing.gltf", IN_PLACE)

    return make


@pytest.mark.parametrize(
    "uri",
    [
        "pictures/Red%201.png",
        "pictures/Red 1.png",
        "pictures\\Red%201.png",
        "Pictures/red 1.PNG",
        "./pictures/../pictures/Red%201.png?v=3",
        "pictures/Red%201.png#top",
    ],
)
def test_a_picture_is_found_by_backslashes_other_case_and_a_query(beside, uri):
    scene = beside(uri)
    assert len(scene.textures) == 1 and not any("cannot be read" in note for note in scene.notes)


@pytest.mark.parametrize(
    ("uri", "reason"),
    [
        ("pictures/Blue.png", "no such file"),
        ("https://example.org/a/Red%201.png", "network"),
        ("pictures", "is a folder"),
    ],
)
def test_a_picture_that_is_not_found_has_its_true_reason(beside, uri, reason):
    assert any(reason in note and uri in note for note in beside(uri).notes)


def test_two_files_that_differ_in_case_alone_are_told_apart(beside, tmp_path):
    beside("pictures/Red 1.png")
    (tmp_path / "pictures" / "RED 1.png").write_bytes((tmp_path / "pictures" / "Red 1.png").read_bytes())
    assert len(beside("pictures/Red 1.png").textures) == 1
    assert any("2 files" in note for note in beside("pictures/red 1.png").notes)


def test_data_of_percents_and_of_base64_are_read(beside, tmp_path):
    data = io.BytesIO()
    Image.fromarray(np.full((2, 2, 3), (255, 0, 0), np.uint8)).save(data, "PNG")
    percents = "".join(f"%{byte:02X}" for byte in data.getvalue())
    assert len(beside(f"data:image/png,{percents}").textures) == 1


def test_a_long_chain_of_nodes_stands_where_its_steps_lead(tmp_path):
    glb, count = Glb(), 3000
    glb.header["nodes"] = [{"children": [n + 1], "translation": [0, 0, -1e-3]} for n in range(count)] + [{"mesh": 0}]
    scene, glb.header["nodes"] = glb.load(tmp_path), [{"mesh": 0, "translation": [0, 0, -count * 1e-3]}]
    wanted = glb.load(tmp_path, "one.glb")
    np.testing.assert_allclose(scene.meshes[0].positions, wanted.meshes[0].positions, atol=1e-5)


def test_keys_of_animations_and_places_of_chains_are_bounded(tmp_path, monkeypatch):
    """Neither many channels of one list of keys, nor a deep chain that moves at many instants."""
    glb, count = Glb(), 200
    glb.header["nodes"] = [{"children": [n + 1], "mesh": 0} for n in range(count)] + [{"mesh": 0}]
    for node in range(count):
        glb.animate("translation", [node / 100, node / 100 + 1], [[0, 0, 0], [0, 0, 1]], node=node)
    monkeypatch.setattr(_gltf_nodes, "MOST_PLACED", 10_000)
    with pytest.raises(SceneError, match="move at too many instants: 10,000 places were looked at"):
        glb.load(tmp_path)
    glb.header["nodes"] = [{"mesh": 0} for n in range(count)]
    glb.load(tmp_path)
    (walk,) = glb.header["animations"]
    walk["channels"] = [channel | {"sampler": 0} for channel in walk["channels"]]
    times, places = np.arange(1000) / 60, np.zeros((1000, 3))
    walk["samplers"] = [{"input": glb.numbers(times), "output": glb.numbers(places)}]
    with pytest.raises(SceneError, match="more keys in all than the file has bytes"):
        glb.load(tmp_path)


S = 1_000_000_000
NOTHING = Needs()


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


def world(scene) -> np.ndarray:
    """(n, 3) all vertices in the world, in their order."""
    return np.concatenate([mesh.positions for mesh in scene.meshes]) + scene.origin_m


def test_vertices_of_morph_targets_count_as_the_scene_s(tmp_path, monkeypatch):
    """Many may share one list of numbers."""
    glb, change = Glb(), {"POSITION": 0}
    monkeypatch.setattr(_gltf_scene, "MOST_TRIANGLES", 20)
    for count, refuses in ((20, False), (21, True)):
        glb.primitive["targets"], glb.header["meshes"][0]["weights"] = [change] * count, [1.0] * count
        with pytest.raises(SceneError, match="vertices of morph targets") if refuses else nullcontext():
            glb.load(tmp_path)


@pytest.mark.parametrize("inside", [True, False], ids=["data URIs", "files beside it"])
def test_a_gltf_is_read_with_its_bytes_and_pictures(tmp_path, inside):
    glb, picture = Glb(), np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    glb.material(pbrMetallicRoughness={"baseColorTexture": glb.texture(picture)})
    glb.write_gltf(tmp_path / "thing.gltf", inside=inside)
    scene = load_scene(tmp_path / "thing.gltf", IN_PLACE)
    assert scene.notes == ()
    assert np.allclose(world(scene), SQUARE + (0, 1, -3))
    assert np.array_equal(scene.textures[0].image, picture)


def test_a_gltf_without_its_files_says_which(tmp_path):
    glb = Glb()
    glb.material(pbrMetallicRoughness={"baseColorTexture": glb.texture(np.zeros((4, 4, 3), np.uint8))})
    glb.write_gltf(tmp_path / "thing.gltf", inside=False)
    (tmp_path / "picture 0.png").unlink()
    (note,) = load_scene(tmp_path / "thing.gltf", IN_PLACE).notes
    assert "images cannot be read, drawn plain: " in note and "picture%200.png" in note
    (tmp_path / "all numbers.bin").unlink()
    with pytest.raises(SceneError, match=r"buffer 0 lies in 'all%20numbers\.bin', which cannot be read: .* beside"):
        load_scene(tmp_path / "thing.gltf")


def test_a_note_comes_once_however_often_its_reason_does(tmp_path):
    """195 lines of one kind were printed for one file."""
    glb = Glb().animate("translation", (0, 1), np.zeros((2, 3)))
    many = [{**glb.header["animations"][0], "name": f"dance {number}"} for number in range(200)]
    glb.header["animations"] = many
    (note,) = glb.load(tmp_path).notes
    assert note.startswith("thing.glb: plays animation 'dance 0'; --animation plays another: 'dance 1', ")
    assert note.endswith("'dance 8' and 191 more")


def damaged() -> dict[str, tuple[bytes, str]]:
    """Bytes of a GLB that is none, and what is said of them."""
    data = Glb().data()
    return {
        "another format": (b"PK\x03\x04" + data[4:], r"bytes that begin with b'PK\\x03\\x04.*expected b'glTF'"),
        "cut in its header": (data[:15], "15 bytes that begin with"),
        "version 1": (data[:4] + b"\1" + data[5:], "no GLB 2.0 file"),
        "no JSON first": (data[:16] + b"BIN\0" + data[20:], "expected b'glTF', 2 and whole JSON"),
        "cut in its JSON": (data[:100], "100 bytes that begin with"),
        "broken JSON": (data[:20] + b"{]" + data[22:], "its JSON cannot be read: Expecting property name.*column 2"),
        "JSON that is no text": (data[:20] + b"\xff" + data[21:], "not UTF-8 text: byte 0 is 0xff"),
    }


@pytest.mark.parametrize("how", damaged())
def test_a_damaged_glb_is_refused_with_place_and_content(tmp_path, how):
    data, said = damaged()[how]
    (tmp_path / "bad.glb").write_bytes(data)
    with pytest.raises(SceneError, match=f"bad.glb: .*{said}.*; export it again"):
        load_scene(tmp_path / "bad.glb")
