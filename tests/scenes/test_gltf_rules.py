"""A glTF file is drawn as its specification says: backs, emission, hidden nodes and pictures."""

from __future__ import annotations

import io
import json

import attrs
import numpy as np
import pytest
from PIL import Image
from worlds import read

from hmdwarp.colour import linear_from_srgb
from hmdwarp.errors import SceneError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import _gltf_nodes, load_scene, only_light, partial_scene, reduced, unlit
from hmdwarp.sources.server import Server

from .glb import IN_PLACE, Glb

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


def test_sixteen_bits_of_grey_on_an_obj_are_scaled(tmp_path):
    Image.fromarray(np.full((4, 4), 20_000, np.uint16)).save(tmp_path / "grey.png")
    (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd grey.png\n", encoding="utf-8")
    rows = ["mtllib m.mtl", "v -1 -1 -3", "v 1 -1 -3", "v 0 1 -3", "vt 0 0", "vt 1 0", "vt 0 1", "usemtl a"]
    (tmp_path / "thing.obj").write_text("\n".join([*rows, "f 1/1 2/2 3/3"]) + "\n", encoding="utf-8")
    assert np.unique(load_scene(tmp_path / "thing.obj", IN_PLACE).textures[0].image).tolist() == [78]


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
