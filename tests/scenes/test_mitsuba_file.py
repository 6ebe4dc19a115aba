"""A scene of Mitsuba's: shapes where its matrices say, in the matt colours of its surfaces."""

from __future__ import annotations

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from PIL import Image

from hmdwarp.errors import HmdwarpError, SceneError
from hmdwarp.options.identity import hash_of_files
from hmdwarp.scenes import SceneOptions, load_scene

AT = '<transform name="{}"><matrix value="1 0 0 {} 0 1 0 1 0 0 1 -2 0 0 0 1"/></transform>'
SCENE = f"""<scene version="0.6.0">
  <texture type="bitmap" id="oak"><string name="filename" value="oak.png"/></texture>
  <bsdf type="twosided" id="wood"><bsdf type="plastic"><ref name="diffuseReflectance" id="oak"/></bsdf></bsdf>
  <shape type="rectangle">{AT.format("toWorld", 0)}<ref id="wood"/></shape>
  <shape type="obj"><string name="filename" value="part.obj"/>{AT.format("to_world", 3)}
    <bsdf type="diffuse"><rgb name="reflectance" value="0.1, 0.2, 0.3"/></bsdf></shape>
  <shape type="serialized"><string name="filename" value="parts.serialized"/>
    <integer name="shapeIndex" value="1"/><bsdf type="roughconductor"/></shape>
  <shape type="rectangle"><bsdf type="dielectric"/></shape>
  <shape type="rectangle"><emitter type="area"/></shape>
  <shape type="sphere"/>
</scene>"""


def serialized_file(version: int, name: bytes, after: bytes = b"") -> bytes:
    """Two meshes of one triangle, the second at x = 1, with normals and texture coordinates."""
    data, begins = b"", []
    for x in (0.0, 1.0):
        body = struct.pack("<I", 0x1003) + name + struct.pack("<QQ", 3, 1)
        body += np.array([(x, 0, 0), (x + 1, 0, 0), (x, 1, 0)], "<f4").tobytes() + np.zeros((3, 3), "<f4").tobytes()
        body += np.array([(0, 0), (1, 0), (0, 1)], "<f4").tobytes() + np.array([0, 1, 2], "<u4").tobytes()
        begins.append(len(data))
        data += struct.pack("<HH", 0x041C, version) + zlib.compress(body + after, 1)
    return data + struct.pack("<2Q" if version >= 4 else "<2I", *begins) + struct.pack("<I", 2)


@pytest.fixture
def scene(tmp_path):
    folder = tmp_path / "shed"
    folder.mkdir()
    Image.new("RGB", (2, 2), (255, 0, 0)).save(folder / "oak.png")
    (folder / "part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "parts.serialized").write_bytes(serialized_file(4, b"a part\0"))
    (folder / "scene.xml").write_text(SCENE)
    return folder / "scene.xml"


HERE = SceneOptions(viewpoint="0,1.6,0")  # leaves every coordinate as it is in the file


def test_shapes_stand_where_their_matrices_say_in_the_colours_of_their_surfaces(scene):
    loaded = load_scene(scene, HERE)
    square, part, metal, lamp = loaded.meshes
    at = [mesh.positions + loaded.origin_m for mesh in loaded.meshes]
    assert loaded.name == "shed" and loaded.triangle_count == 2 + 1 + 1 + 2
    assert at[0][:, 2] == pytest.approx(-2) and at[0].mean(axis=0)[:2] == pytest.approx([0, 1])
    assert at[1][0] == pytest.approx([3, 1, -2]) and at[2][0] == pytest.approx([1, 0, 0])
    assert square.texture == 0 and loaded.textures[0].image[0, 0, 0] == 255
    assert part.albedo[0] / part.albedo[0, 2] == pytest.approx([1 / 3, 2 / 3, 1])  # less light, one hue
    assert lamp.light == pytest.approx(1) and metal.texture == -1
    # Its rows go down, ours up.
    assert metal.uv == pytest.approx(np.array([(0, 1), (1, 1), (0, 0)]))
    assert any("glass is left out" in note for note in loaded.notes)
    assert any("no mesh are left out: sphere" in note for note in loaded.notes)


def test_an_older_file_of_meshes_has_no_names_and_short_places(scene):
    later = load_scene(scene, HERE).meshes[2].positions
    (scene.parent / "parts.serialized").write_bytes(serialized_file(3, b""))
    assert np.array_equal(load_scene(scene, HERE).meshes[2].positions, later)


def test_its_hash_is_that_of_all_it_names(scene):
    before = hash_of_files(scene)
    (scene.parent / "part.obj").write_text("v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n")
    assert hash_of_files(scene) != before


@pytest.mark.parametrize(
    ("said", "instead", "why"),
    [
        ("<scene", "<scene <", "not a readable XML file"),
        ("<matrix value", "<translate value", "placed by <translate>"),
        ("part.obj", "../part.obj", "outside"),
        ('value="1"/><bsdf type="rough', 'value="2"/><bsdf type="rough', "not a readable mesh"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(scene, said, instead, why):
    scene.write_text(SCENE.replace(said, instead))
    (scene.parent.parent / "part.obj").write_text("v 0 0 0\n")
    with pytest.raises(HmdwarpError, match=why) as caught:
        load_scene(scene)
    assert isinstance(caught.value, SceneError) or why == "outside"
    assert "\n" not in str(caught.value)


def test_damaged_meshes_are_refused_and_no_more_is_unpacked_than_a_mesh_holds(scene):
    """Half a gigabyte of zeros packs into half a megabyte."""
    many = struct.pack("<I", 0x1000) + b"\0" + struct.pack("<QQ", 10**12, 1)
    path = scene.parent / "parts.serialized"
    for data in (b"", b"\x1c\x04", packed(many), serialized_file(4, b"a part\0")[:-60]):
        path.write_bytes(data)
        with pytest.raises(SceneError, match=r"parts\.serialized: not a readable mesh"):
            load_scene(scene)
    path.write_bytes(serialized_file(4, b"a part\0", after=bytes(1 << 29)))
    tracemalloc.start()
    load_scene(scene)
    assert tracemalloc.get_traced_memory()[1] < 1 << 25
    tracemalloc.stop()


def packed(body: bytes) -> bytes:
    """A file of one mesh."""
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(body, 1) + struct.pack("<QI", 0, 1)
