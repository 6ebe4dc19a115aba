"""All of a scene file arrives, or its loss is said: packed data, extensions, instances, lights."""

from __future__ import annotations

import sys
from contextlib import nullcontext

import numpy as np
import pytest

from hmdwarp.errors import SceneError
from hmdwarp.scenes import _gltf_scene, load_scene

from .glb import IN_PLACE, SQUARE, Glb

DRACO, INSTANCING = "KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing"


def world(scene) -> np.ndarray:
    """(n, 3) all vertices in the world, in their order."""
    return np.concatenate([mesh.positions for mesh in scene.meshes]) + scene.origin_m


def needing(*names: str) -> Glb:
    glb = Glb()
    glb.header |= {"extensionsUsed": list(names), "extensionsRequired": list(names)}
    return glb


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("EXT_meshopt_compression", "'gltf-transform copy thing.glb thing-plain.glb' removes it"),
        ("KHR_texture_basisu", "'gltf-transform ktxdecompress thing.glb thing-plain.glb' removes it"),
        ("ACME_unheard_of", "export it without"),
    ],
)
def test_required_unread_extensions_are_refused_with_a_remedy(tmp_path, name, remedy):
    with pytest.raises(SceneError, match=f"needs {name}, which is not read: {remedy}"):
        needing(name).load(tmp_path)


def test_each_of_several_is_named(tmp_path):
    with pytest.raises(SceneError, match="needs KHR_texture_basisu, .*; needs EXT_meshopt_compression, "):
        needing("KHR_texture_basisu", "EXT_meshopt_compression").load(tmp_path)


def packed(points: np.ndarray, faces: np.ndarray, bytes_of=None) -> Glb:
    """The square's file with its numbers in Draco's packing alone."""
    draco = pytest.importorskip("DracoPy", reason="the extra 'draco' is not installed")
    data = draco.encode(points, faces.astype(np.uint32), quantization_bits=16) if bytes_of is None else bytes_of
    glb = needing(DRACO)
    for number in (glb.primitive["attributes"]["POSITION"], glb.primitive["indices"]):
        del glb.header["accessors"][number]["bufferView"]
    del glb.primitive["attributes"]["TEXCOORD_0"]
    glb.primitive["extensions"] = {DRACO: {"bufferView": glb.view(data), "attributes": {"POSITION": 0}}}
    return glb


def test_draco_is_unpacked(tmp_path):
    scene = packed(SQUARE, np.array([(0, 1, 2), (0, 2, 3)])).load(tmp_path)
    assert scene.triangle_count == 2
    # The node stands at (0, 1, -3); 16 bits over 2 m are 31 micrometres.
    found = {tuple(corner) for corner in (world(scene) - (0, 1, -3)).round(3) + 0.0}
    assert found == {tuple(corner) for corner in SQUARE}


def test_damaged_draco_data_are_refused(tmp_path):
    with pytest.raises(SceneError, match="Draco data cannot be decoded"):
        packed(SQUARE, np.array([(0, 1, 2)]), b"DRACO but not really").load(tmp_path)


@pytest.mark.parametrize("level", [0, 1, 7])
def test_draco_data_are_refused_by_what_they_say_that_they_unpack_to(tmp_path, level):
    """Nothing of 4 points and 2 faces is unpacked once they say that they are 30 million."""
    draco, count = pytest.importorskip("DracoPy", reason="the extra 'draco' is not installed"), b"\x80\x87\xa7\x0e"
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    data = draco.encode(SQUARE, faces.astype(np.uint32), quantization_bits=16, compression_level=level)
    for number, at in enumerate((11, 12) if level == 0 else (13, 12)):
        assert data[at] == (2, 4)[number]
        said = (12, 32)[number] * 30_000_000 + (4 * 32, 2 * 12)[number]
        with pytest.raises(SceneError, match=f"{said} bytes, unpacked, of Draco; expected at most 134217728"):
            packed(SQUARE, faces, data[:at] + count + data[at + 1 :]).load(tmp_path)


def test_without_the_library_draco_is_refused_with_the_extra_to_install(tmp_path, monkeypatch):
    """Its accessors have no numbers of their own, so all vertices would be zero."""
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(SceneError, match=r"pip install '\.\[draco\]'.*'gltf-transform copy thing.glb thing-plain"):
        needing(DRACO).load(tmp_path)


def test_a_scene_without_extent_is_refused(tmp_path):
    with pytest.raises(SceneError, match="all 4 positions are the same point"):
        Glb(np.zeros_like(SQUARE)).load(tmp_path)


def test_instances_are_drawn_where_they_stand(tmp_path):
    """Two, the second turned by half about +y, twice as large, and mirrored along x."""
    glb = needing(INSTANCING)
    places, turns = np.array([(0, 0, 0), (5, 0, 0)], np.float32), np.array([(0, 0, 0, 1), (0, 1, 0, 0)], np.float32)
    sizes = np.array([(1, 1, 1), (-2, 2, 2)], np.float32)
    parts = {"TRANSLATION": places, "ROTATION": turns, "SCALE": sizes}
    attributes = {name: glb.numbers(rows) for name, rows in parts.items()}
    glb.header["nodes"][0]["extensions"] = {INSTANCING: {"attributes": attributes}}
    scene = glb.load(tmp_path)
    node = np.array((0, 1, -3))
    second = SQUARE * (-2, 2, 2) * (-1, 1, -1) + (5, 0, 0)
    assert scene.triangle_count == 4
    assert np.allclose(world(scene), np.concatenate([SQUARE, second]) + node)
    # Mirrored twice or not at all, each shows its front: counter-clockwise about its normal.
    (mesh,) = scene.meshes
    a, b, c = (mesh.positions[mesh.triangles[:, corner]] for corner in range(3))
    facing = np.cross(b - a, c - a)[:, 2]
    assert (facing[:2] > 0).all() and (facing[2:] < 0).all()  # the second was turned to the back


def test_instances_without_numbers_that_fit_are_refused(tmp_path):
    glb = needing(INSTANCING)
    attributes = {"TRANSLATION": glb.numbers(SQUARE[:2]), "SCALE": glb.numbers(SQUARE[:3])}
    glb.header["nodes"][0]["extensions"] = {INSTANCING: {"attributes": attributes}}
    with pytest.raises(SceneError, match="instances without one finite place, turn and size each"):
        glb.load(tmp_path)


@pytest.mark.parametrize("required", [True, False])
def test_lights_that_no_node_has_light_nothing(tmp_path, required):
    glb = needing("KHR_lights_punctual")
    if not required:
        del glb.header["extensionsRequired"]
    glb.header["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}, {"type": "spot"}]}}
    assert glb.load(tmp_path).notes == glb.load(tmp_path).lamps == ()


def test_extensions_that_a_file_can_do_without_are_one_note(tmp_path):
    glb = Glb()
    glb.header["extensionsUsed"] = ["KHR_materials_sheen", "KHR_texture_transform", "KHR_materials_clearcoat"]
    assert glb.load(tmp_path).notes == (
        "thing.glb: extensions are left out, and the file does not need them: KHR_materials_sheen, "
        "KHR_materials_clearcoat",
    )


def test_a_ktx2_image_is_drawn_plain_with_one_note_for_all_of_them(tmp_path):
    glb = Glb()
    texture = glb.texture(np.full((4, 4, 3), 200, np.uint8))
    glb.header["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    materials = [{"name": name, "pbrMetallicRoughness": {"baseColorTexture": texture}} for name in ("hull", "wing")]
    glb.header["materials"] = materials
    glb.header["meshes"][0]["primitives"] = [glb.primitive | {"material": number} for number in (0, 1)]
    scene = glb.load(tmp_path)
    assert not scene.textures
    assert scene.notes == (
        "thing.glb: KTX2 images are not read, drawn plain ('gltf-transform ktxdecompress' converts them): 2 of "
        "them, such as material 'hull'",
    )


def test_a_texture_is_moved_as_the_file_says(tmp_path):
    """The example of KHR_texture_transform: the lower left quarter, turned by 90 degrees."""
    glb = Glb()
    transform = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    base = glb.texture(np.full((4, 4, 3), 200, np.uint8)) | {"extensions": {"KHR_texture_transform": transform}}
    scene = glb.material(pbrMetallicRoughness={"baseColorTexture": base}).load(tmp_path)
    # The file's (u, v) with v down are (0, 1), (1, 1), (1, 0), (0, 0): u' = v / 2, v' = 1 - u / 2.
    assert np.allclose(scene.meshes[0].uv, [(0.5, 0), (0.5, 0.5), (0, 0.5), (0, 0)])


def test_an_unlit_material_shines_in_its_own_colour(tmp_path):
    base = {"baseColorFactor": [0.2, 0.4, 0.6, 1.0]}
    scene = Glb().material(pbrMetallicRoughness=base, extensions={"KHR_materials_unlit": {}}).load(tmp_path)
    assert np.allclose(scene.meshes[0].light, (0.2, 0.4, 0.6))


@pytest.mark.parametrize(("mode", "faces"), [(5, [(0, 1, 2), (2, 1, 3)]), (6, [(0, 1, 2), (0, 2, 3)])])
def test_strips_and_fans_are_triangles(tmp_path, mode, faces):
    glb = Glb()
    glb.primitive |= {"mode": mode, "indices": glb.numbers(np.arange(4, dtype=np.uint16))}
    assert glb.load(tmp_path).meshes[0].triangles.tolist() == [list(face) for face in faces]


def test_points_and_lines_are_left_out_with_one_note(tmp_path):
    glb = Glb()
    glb.header["meshes"][0]["primitives"] += [glb.primitive | {"mode": mode} for mode in (0, 1, 3)]
    assert glb.load(tmp_path).notes == (
        "thing.glb: points and lines are left out: 3 of them, such as mesh 'thing-0-1'",
    )


def test_a_note_names_the_scene_taken_of_several(tmp_path):
    glb = Glb()
    glb.header["scenes"] = [{"nodes": []}, {"nodes": [0], "name": "hall"}]
    glb.header["scene"] = 1
    scene = glb.load(tmp_path)
    assert len(scene.meshes) == 1
    assert scene.notes == ("thing.glb: 2 scenes in it; scene 1 'hall' is taken, which it shows first",)


def test_sparse_numbers_stand_in_their_places(tmp_path):
    glb = Glb()
    accessor = glb.header["accessors"][glb.primitive["attributes"]["POSITION"]]
    which, values = np.array([2], np.uint16), np.array([(1, 3, 0.5)], np.float32)
    accessor["sparse"] = {
        "count": 1,
        "indices": {"bufferView": glb.view(which.tobytes()), "componentType": 5123},
        "values": {"bufferView": glb.view(values.tobytes())},
    }
    expected = SQUARE.copy()
    expected[2] = values
    assert np.allclose(world(glb.load(tmp_path)), expected + (0, 1, -3))


def test_vertices_of_morph_targets_count_as_the_scene_s(tmp_path, monkeypatch):
    """Many may share one list of numbers."""
    glb, change = Glb(), {"POSITION": 0}
    monkeypatch.setattr(_gltf_scene, "MOST_TRIANGLES", 20)
    for count, refuses in ((20, False), (21, True)):
        glb.primitive["targets"], glb.header["meshes"][0]["weights"] = [change] * count, [1.0] * count
        with pytest.raises(SceneError, match="vertices of morph targets") if refuses else nullcontext():
            glb.load(tmp_path)


def test_morph_targets_stand_at_their_weights_and_do_not_move(tmp_path):
    glb = Glb().animate("weights", (0, 1), np.zeros((2, 1)))
    glb.primitive["targets"] = [{"POSITION": glb.numbers(np.tile(np.array((0, 2, 0), np.float32), (4, 1)))}]
    glb.header["meshes"][0]["weights"] = [0.5]
    scene = glb.load(tmp_path)
    assert np.allclose(world(scene), SQUARE + (0, 2, -3))
    (note,) = scene.notes
    assert "is not played: animation 'walk', weights of node 'thing'" in note


@pytest.mark.parametrize("total", [0.98, 0.5, 2.0])
def test_skin_weights_are_scaled_to_sum_1_with_one_note(tmp_path, total):
    weights = np.tile(np.array((0.25, 0.75, 0, 0)) * total, (4, 1))
    glb = Glb().skin(weights, joints=(0, 1, 0, 0)).animate("translation", (0, 1), ((0, 1, 0), (0, 2, 0)), node=2)
    scene = glb.load(tmp_path)
    assert scene.notes == (
        f"thing.glb: skin weights do not have sum 1; they were scaled to it: skin 'figure', a sum of {total:g}",
    )
    deformation = scene.meshes[0].deformation
    moved = deformation.positions(999_999_999) - deformation.positions(0)
    assert np.allclose(moved, (0, 0.75, 0), atol=1e-6)


def test_half_a_byte_off_is_no_matter(tmp_path):
    assert Glb().skin(np.tile((0.496, 0.496, 0, 0), (4, 1))).load(tmp_path).notes == ()


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
    json_bytes = int.from_bytes(data[12:16], "little")
    end = 20 + json_bytes
    return {
        "another format": (b"PK\x03\x04" + data[4:], r"begins with b'PK\\x03\\x04', expected b'glTF'"),
        "cut in its header": (data[:15], "ends after 15 bytes, expected 20 of headers at least"),
        "version 1": (data[:4] + b"\1" + data[5:], "version 1 at byte 4, expected 2"),
        "no JSON first": (data[:16] + b"BIN\0" + data[20:], r"a chunk b'BIN\\x00' at byte 16, expected b'JSON'"),
        "cut in its JSON": (data[:100], f"its JSON of {json_bytes} bytes ends at byte {end}, expected 100, the file's"),
        "broken JSON": (data[:20] + b"{]" + data[22:], "its JSON cannot be read: Expecting property name.*column 2"),
        "JSON that is no text": (data[:20] + b"\xff" + data[21:], "not UTF-8 text: byte 0 is 0xff"),
    }


@pytest.mark.parametrize("how", damaged())
def test_a_damaged_glb_is_refused_with_place_and_content(tmp_path, how):
    data, said = damaged()[how]
    (tmp_path / "bad.glb").write_bytes(data)
    with pytest.raises(SceneError, match=f"bad.glb: .*{said}.*; export it again"):
        load_scene(tmp_path / "bad.glb")


def test_an_undecodable_picture_is_noted_with_its_first_bytes(tmp_path):
    glb = Glb()
    glb.header["images"] = [{"bufferView": glb.view(b"GIF87a, and no more"), "mimeType": "image/png"}]
    glb.header["textures"] = [{"source": 0}]
    glb.material(pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    (note,) = glb.load(tmp_path).notes
    print(note)
    assert "image 0, 19 bytes that begin with b'GIF87a, ', cannot be decoded; expected PNG" in note
