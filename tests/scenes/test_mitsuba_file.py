"""A scene of Mitsuba's: shapes where its matrices say, in the matt colours of its surfaces."""

from __future__ import annotations

import shutil
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

from hmdwarp.base import HmdwarpError, SceneError
from hmdwarp.base.identity import hash_of_files
from hmdwarp.scenes import load_scene

from .glb import IN_PLACE

FILES = Path(__file__).with_name("files")
SCENE = (FILES / "mitsuba.xml").read_text(encoding="utf-8")


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
    """A copy of the scene whose loading is golden, in a folder of its own."""
    shutil.copytree(FILES, tmp_path / "shed", ignore=lambda _, names: [n for n in names if "mitsuba" not in n])
    return (tmp_path / "shed" / "mitsuba.xml").rename(tmp_path / "shed" / "scene.xml")


def test_an_older_file_of_meshes_has_no_names_and_short_places(scene):
    assert load_scene(scene, IN_PLACE).name == "shed"
    later = load_scene(scene, IN_PLACE).meshes[2].positions
    (scene.parent / "mitsuba.serialized").write_bytes(serialized_file(3, b""))
    assert np.array_equal(load_scene(scene, IN_PLACE).meshes[2].positions, later)


def test_its_hash_is_that_of_all_it_names(scene):
    before = hash_of_files(scene)
    (scene.parent / "mitsuba-part.obj").write_text("v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n")
    assert hash_of_files(scene) != before


@pytest.mark.parametrize(
    ("said", "instead", "why"),
    [
        ("<scene", "<scene <", "not a readable XML file"),
        ("<matrix value", "<translate value", "placed by <translate>"),
        ("mitsuba-part.obj", "../mitsuba-part.obj", "outside"),
        ('value="1"/><bsdf type="rough', 'value="2"/><bsdf type="rough', "not a readable mesh"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(scene, said, instead, why):
    scene.write_text(SCENE.replace(said, instead))
    (scene.parent.parent / "mitsuba-part.obj").write_text("v 0 0 0\n")
    with pytest.raises(HmdwarpError, match=why) as caught:
        load_scene(scene)
    assert isinstance(caught.value, SceneError) or why == "outside"
    assert "\n" not in str(caught.value)


def test_damaged_meshes_are_refused_and_no_more_is_unpacked_than_a_mesh_holds(scene):
    """Half a gigabyte of zeros packs into half a megabyte."""
    many = struct.pack("<I", 0x1000) + b"\0" + struct.pack("<QQ", 10**12, 1)
    path = scene.parent / "mitsuba.serialized"
    for data in (b"", b"\x1c\x04", packed(many), serialized_file(4, b"a part\0")[:-60]):
        path.write_bytes(data)
        with pytest.raises(SceneError, match=r"mitsuba\.serialized: not a readable mesh"):
            load_scene(scene)
    path.write_bytes(serialized_file(4, b"a part\0", after=bytes(1 << 29)))
    tracemalloc.start()
    load_scene(scene)
    assert tracemalloc.get_traced_memory()[1] < 1 << 25
    tracemalloc.stop()


def packed(body: bytes) -> bytes:
    """A file of one mesh."""
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(body, 1) + struct.pack("<QI", 0, 1)
