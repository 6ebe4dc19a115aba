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
