"""A glTF file is drawn as its specification says: backs, emission, hidden nodes and pictures."""

from __future__ import annotations

import io
import json

import attrs
import numpy as np
import pytest
from PIL import Image
from worlds import read

from hmdwarp.cloudlight.points import PointCells
from hmdwarp.colour import linear_from_srgb
from hmdwarp.errors import SceneError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import _gltf_nodes, load_scene, only_light, partial_scene, reduced, unlit
from hmdwarp.sources.server import Server

from .glb import IN_PLACE, SQUARE, Glb, boxes, cube

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


def test_a_hull_turned_inside_out_is_seen_through_from_outside(tmp_path, gpu):
    glb = boxes(cube((-0.4, 0.6, -3.4), (0.4, 1.4, -2.6)))
    hull, faces = cube((-0.5, 0.5, -3.5), (0.5, 1.5, -2.5), inwards=True)
    more = {"attributes": {"POSITION": glb.numbers(hull)}, "indices": glb.numbers(faces)}
    glb.header["materials"] = [
        {"pbrMetallicRoughness": RED, "extensions": {"KHR_materials_unlit": {}}},
        {"pbrMetallicRoughness": BLACK},
    ]
    glb.primitive["material"] = 0
    glb.header["meshes"][0]["primitives"].append(more | {"material": 1})
    colour, away = middle(gpu, glb.load(tmp_path))
    assert colour == pytest.approx([1, 0, 0], abs=HALF) and away == pytest.approx(2.6, rel=1e-5)
    glb.header["materials"][1]["doubleSided"] = True
    colour, away = middle(gpu, glb.load(tmp_path, "both.glb"))
    assert colour == pytest.approx([0, 0, 0], abs=HALF) and away == pytest.approx(2.5, rel=1e-5)


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


@pytest.mark.parametrize("strength", [None, 2.5])
def test_emission_follows_its_factor_and_strength(tmp_path, gpu, strength):
    more = (
        {} if strength is None else {"extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}}
    )
    scene = emissive(emissiveFactor=[0.9, 0.3, 0.2], **more).load(tmp_path)
    assert middle(gpu, scene)[0] == pytest.approx(np.array([0.9, 0.3, 0.2]) * (strength or 1), abs=HALF)
    assert not any("emission" in note or "left out" in note for note in scene.notes)


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


def test_points_show_the_emission(tmp_path, gpu):
    scene = _textured(tmp_path)
    point = PointCells(scene).block((0, 0, 0), 0.1).colours[0]
    assert linear_from_srgb(point / 255) == pytest.approx(middle(gpu, scene)[0], abs=0.01)  # a byte of sRGB


def test_emission_with_coordinates_of_its_own_is_drawn_at_its_mean_and_noted(tmp_path, gpu):
    glb = Glb()
    glb.primitive["attributes"]["TEXCOORD_1"] = glb.numbers(np.zeros((4, 2)))
    base = {"baseColorTexture": flat(glb, (255, 0, 0))}
    glow = {"emissiveFactor": [1, 1, 1], "emissiveTexture": flat(glb, (0, 255, 0)) | {"texCoord": 1}}
    scene = glb.material(pbrMetallicRoughness=base, **glow).load(tmp_path)
    assert any("emission" in note and "mean" in note for note in scene.notes)
    assert middle(gpu, scene)[0] == pytest.approx(_base(tmp_path, gpu) + (0, 1, 0), abs=BYTE)


def test_glass_that_shines_under_a_picture_is_noted(tmp_path):
    scene = _textured(tmp_path, extensions={"KHR_materials_transmission": {"transmissionFactor": 1}})
    assert any("emission" in note and "see-through" in note for note in scene.notes)


def test_lamps_and_pictures_that_shine_exclude_each_other(tmp_path):
    lit = load_scene("lantern")
    shining = _textured(tmp_path).textures
    with pytest.raises(SceneError, match="shines"):
        attrs.evolve(lit, textures=[*lit.textures, *shining])


def test_a_hidden_node_hides_what_hangs_from_it(tmp_path, gpu):
    glb = Glb().material(pbrMetallicRoughness=RED)
    glb.header["nodes"] += [
        {"children": [2], "extensions": {"KHR_node_visibility": {"visible": False}}},
        {"mesh": 0, "translation": [0, 1, -2]},
    ]
    glb.header["scenes"][0]["nodes"].append(1)
    glb.header["extensionsUsed"] = glb.header["extensionsRequired"] = ["KHR_node_visibility"]
    scene = glb.load(tmp_path)
    assert middle(gpu, scene)[1] == pytest.approx(3)
    assert not any("KHR_node_visibility" in note for note in scene.notes)
    glb.header["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = True
    assert middle(gpu, glb.load(tmp_path, "seen.glb"))[1] == pytest.approx(2)


def test_a_file_with_every_node_hidden_says_why_there_is_nothing(tmp_path):
    glb = Glb()
    glb.header["nodes"][0]["extensions"] = {"KHR_node_visibility": {"visible": False}}
    with pytest.raises(SceneError, match="KHR_node_visibility"):
        glb.load(tmp_path)


def spec_gloss(**values) -> dict:
    return {"extensions": {"KHR_materials_pbrSpecularGlossiness": values}}


@pytest.mark.parametrize("required", [False, True])
def test_diffuse_colour_and_picture_of_specular_glossiness_are_the_base_colour(tmp_path, gpu, required):
    def colour(**material):
        glb = Glb()
        if "picture" in material:
            name, target = material.pop("picture")
            (target or material["extensions"]["KHR_materials_pbrSpecularGlossiness"])[name] = flat(glb, (200, 90, 30))
        if required and "extensions" in material:
            glb.header["extensionsUsed"] = glb.header["extensionsRequired"] = ["KHR_materials_pbrSpecularGlossiness"]
        scene = glb.material(**material).load(tmp_path)
        assert not any("SpecularGlossiness" in note for note in scene.notes)
        return middle(gpu, scene)[0]

    plain = {"baseColorFactor": [0.6, 0.3, 0.1, 1]}
    # A specular colour of 0.04 is that of every glTF material that is not a metal.
    dull = spec_gloss(diffuseFactor=[0.6, 0.3, 0.1, 1], specularFactor=[0.04] * 3)
    assert colour(**dull) == pytest.approx(colour(pbrMetallicRoughness=plain), abs=HALF)
    pictured = {"pbrMetallicRoughness": dict(plain)}
    pictured["picture"] = ("baseColorTexture", pictured["pbrMetallicRoughness"])
    assert colour(**dull, picture=("diffuseTexture", None)) == pytest.approx(colour(**pictured), abs=BYTE)


def test_the_specular_colour_of_a_metal_is_its_base_colour(tmp_path, gpu):
    gold = spec_gloss(diffuseFactor=[0, 0, 0, 1], specularFactor=[0.9, 0.6, 0.2], glossinessFactor=0.3)
    metal = {"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.6, 0.2, 1], "metallicFactor": 1}}
    colours = [middle(gpu, Glb().material(**one).load(tmp_path, f"{k}.glb"))[0] for k, one in enumerate((gold, metal))]
    assert colours[0] == pytest.approx(colours[1], abs=HALF)
    glb = Glb()
    pictured = spec_gloss(diffuseFactor=[0, 0, 0, 1], specularGlossinessTexture=flat(glb, (230, 160, 60)))
    shown = middle(gpu, glb.material(**pictured).load(tmp_path, "pictured.glb"))[0]
    light = colours[1] / (0.9, 0.6, 0.2)
    assert shown == pytest.approx(light * linear_from_srgb(np.array([230, 160, 60]) / 255), abs=0.01)


def test_a_polished_specular_metal_is_a_mirror(tmp_path):
    scene = Glb().material(**spec_gloss(diffuseFactor=[0, 0, 0, 1], specularFactor=[0.9] * 3)).load(tmp_path)
    assert scene.meshes[0].material.reflectivity == pytest.approx(0.9, abs=0.01)


def _picture(glb: Glb, image: Image.Image) -> dict:
    stream = io.BytesIO()
    image.save(stream, "PNG")
    found = glb.texture(np.zeros((1, 1, 3), np.uint8))
    glb.header["images"][-1]["bufferView"] = glb.view(stream.getvalue())
    return found


@pytest.mark.parametrize("grey", [0, 128, 20_000, 40_000, 65_535])
def test_sixteen_bits_of_grey_are_scaled(tmp_path, grey):
    glb = Glb()
    picture = _picture(glb, Image.fromarray(np.full((4, 4), grey, np.uint16)))
    image = glb.material(pbrMetallicRoughness={"baseColorTexture": picture}).load(tmp_path).textures[0].image
    assert np.unique(image) == pytest.approx([round(grey / 257)])


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


def test_the_square_of_these_tests_faces_the_viewer():
    a, b, c = SQUARE[[0, 1, 2]]
    assert np.cross(b - a, c - a)[2] > 0


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


@pytest.mark.parametrize("what", ["positions", "indices", "instances of a mesh"])
def test_what_is_counted_but_not_there_is_refused_before_it_is_made(tmp_path, what):
    """Neither refusal waits for an array: 3e7 elements, a file's triangles 50,000 times."""
    glb = Glb()
    if what == "instances of a mesh":
        index = glb.primitive["indices"]
        glb.header["accessors"][index]["count"] = 3_000_000
        glb.header["nodes"], glb.header["scenes"] = [{"mesh": 0}] * 100, [{"nodes": [*range(100)]}]
    else:
        empty = {"componentType": 5126, "count": 30_000_000, "type": "VEC3"}
        if what == "indices":
            empty |= {"componentType": 5125, "type": "SCALAR"}
        glb.header["accessors"].append(empty)
        place = glb.primitive if what == "indices" else glb.primitive["attributes"]
        place["indices" if what == "indices" else "POSITION"] = len(glb.header["accessors"]) - 1
    with pytest.raises(SceneError, match="without data; expected at most|more than 50000000 triangles"):
        glb.load(tmp_path)
