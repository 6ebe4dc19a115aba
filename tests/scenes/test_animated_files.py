"""Animated nodes of a GLB become bodies; broken keys are one clear line."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from hmdwarp.client.effects import effects
from hmdwarp.errors import SceneError
from hmdwarp.scenes import load_scene

from .glb import IN_PLACE

S = 1_000_000_000
HALF = np.sqrt(0.5)
TIMES = (0.0, 1.0, 3.0)
PLACES = ((0, 1, 0), (2, 1, 0), (2, 3, 0))
TURNS = ((0, 0, 0, 1), (0, HALF, 0, HALF), (0, 1, 0, 0))


def write_glb(path, channels: dict[str, tuple], *, change=None) -> None:
    """A still box, and a box node 'lift' below a turned node 'yard'.

    channels: times and values of lift's properties. change: edits the JSON.
    """
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((1, 1, 1)), node_name="still", geom_name="still")
    scene.add_geometry(trimesh.creation.box((1, 2, 1)), node_name="lift", geom_name="lift")
    data = scene.export(file_type="glb")
    length = struct.unpack_from("<I", data, 12)[0]
    header, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    index = next(k for k, node in enumerate(header["nodes"]) if node.get("name") == "lift")
    header["nodes"][index].pop("matrix", None)
    header["nodes"][index] |= {"translation": list(map(float, PLACES[0])), "scale": [1.0, 0.5, 1.0]}
    roots = next(
        a for a in (header["scenes"][0]["nodes"], *(node.get("children", []) for node in header["nodes"])) if index in a
    )
    roots.remove(index)
    header["nodes"].append(
        {"name": "yard", "rotation": [0, HALF, 0, HALF], "translation": [10.0, 0, 0], "children": [index]}
    )
    roots.append(len(header["nodes"]) - 1)
    animation = {"channels": [], "samplers": []}
    for where, (times, values) in channels.items():
        ends = {}
        for end, array in (("input", np.array(times, "<f4")[:, None]), ("output", np.array(values, "<f4"))):
            header["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": array.nbytes})
            kind = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[array.shape[1]]
            header["accessors"].append(
                {"bufferView": len(header["bufferViews"]) - 1, "componentType": 5126, "count": len(array), "type": kind}
            )
            binary += array.tobytes()
            ends[end] = len(header["accessors"]) - 1
        animation["samplers"].append(ends)
        animation["channels"].append(
            {"sampler": len(animation["samplers"]) - 1, "target": {"node": index, "path": where}}
        )
    header["animations"] = [animation]
    header["buffers"][0]["byteLength"] = len(binary)
    if change:
        change(header)
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)


def test_an_animated_node_moves_as_its_keys_say(tmp_path):
    write_glb(tmp_path / "lift.glb", {"translation": (TIMES, PLACES), "rotation": (TIMES, TURNS)})
    scene = load_scene(tmp_path / "lift.glb", IN_PLACE)
    assert effects.of(scene) == ("rigid_motion",)
    assert [body.name for body in scene.bodies] == ["lift"]
    assert sorted(mesh.body for mesh in scene.meshes) == [0, 1]
    lift = next(mesh for mesh in scene.meshes if mesh.body)
    # Its own scale stays in its corners: 1 m high instead of 2.
    assert np.allclose(np.abs(lift.positions), 0.5)
    quarter = Rotation.from_euler("y", 90, degrees=True)
    for second, place, turn in ((0, PLACES[0], 0), (0.5, (1, 1, 0), 45), (2, (2, 2, 0), 135), (3.5, (1, 1, 0), 45)):
        state = scene.bodies[0].motion.state(round(second * S))
        assert np.allclose(state.pose.position_m, quarter.apply(place) + (10, 0, 0), atol=1e-6)
        expected = quarter * Rotation.from_euler("y", turn, degrees=True)
        assert (state.pose.rotation.inv() * expected).magnitude() < 1e-6
    state = scene.bodies[0].motion.state(S // 2)
    assert np.allclose(state.velocity_m_s, quarter.apply((2, 0, 0)), atol=1e-6)
    assert np.allclose(state.angular_velocity_rad_s, (0, np.pi / 2, 0), atol=1e-6)


def test_one_channel_is_enough(tmp_path):
    write_glb(tmp_path / "lift.glb", {"rotation": (TIMES, TURNS)})
    state = load_scene(tmp_path / "lift.glb", IN_PLACE).bodies[0].motion.state(S)
    assert np.allclose(state.pose.position_m, (10, 1, 0), atol=1e-6)


def test_animations_of_the_same_thing_do_not_add_up(tmp_path):
    def change(header):
        header["animations"] = [{**header["animations"][0], "name": name} for name in ("up", "down")]

    write_glb(tmp_path / "lift.glb", {"translation": (TIMES, PLACES)}, change=change)
    scene = load_scene(tmp_path / "lift.glb", IN_PLACE)
    assert len(scene.bodies) == 1
    assert scene.notes == ("lift.glb: plays animation 'up'; --animation plays another: 'down'",)


def test_a_node_that_grows_is_no_rigid_body(tmp_path):
    write_glb(tmp_path / "lift.glb", {"scale": (TIMES, ((1, 0.5, 1), (1, 1.0, 1), (1, 1.0, 1)))})
    scene = load_scene(tmp_path / "lift.glb", IN_PLACE)
    assert effects.of(scene) == ("soft_motion",) and not scene.bodies
    lift = next(mesh for mesh in scene.meshes if mesh.deformation is not None)
    heights = [np.ptp(lift.deformation.positions(round(second * S))[:, 1]) for second in (0, 0.5, 1)]
    assert np.allclose(heights, (1.0, 1.5, 2.0), atol=1e-6)
    speed = lift.deformation.velocities(S // 2)[:, 1]
    assert np.allclose(np.abs(speed), 0.5, atol=1e-6)  # each end of 2 m of mesh, half a metre a second


def test_a_file_without_animation_has_no_bodies(tmp_path):
    write_glb(tmp_path / "still.glb", {})
    scene = load_scene(tmp_path / "still.glb")
    assert scene.bodies == ()
    assert not effects.of(scene)


def wrong_type(header):
    header["accessors"][-1]["componentType"] = 5121


def cut_off(header):
    header["accessors"][-1]["count"] = 1000


def no_such_node(header):
    header["animations"][0]["channels"][0]["target"]["node"] = 99


@pytest.mark.parametrize(
    ("channels", "change", "message"),
    [
        ({"translation": ((0, 2, 1), PLACES)}, None, "translation of node 'lift': key 2 is at 1 s; .* increase"),
        (
            {"translation": ((0, np.nan, 1), PLACES)},
            None,
            "translation of node 'lift': a key is not made of finite numbers",
        ),
        (
            {"translation": (TIMES, np.full((3, 3), np.inf))},
            None,
            "translation of node 'lift': a key is not made of finite numbers",
        ),
        ({"rotation": (TIMES, np.zeros((3, 4)))}, None, "rotation of node 'lift': key 0 is no rotation"),
        ({"translation": (TIMES, PLACES[:2])}, None, "3 key times and 2 values; expected 1 for each"),
        ({"translation": (TIMES, PLACES)}, wrong_type, "integers; expected floats"),
        ({"translation": (TIMES, PLACES)}, cut_off, "reaches beyond the file's"),
        ({"translation": (TIMES, PLACES)}, no_such_node, "uses number 99 of 3 nodes"),
    ],
)
def test_broken_keys_are_one_clear_line(tmp_path, channels, change, message):
    write_glb(tmp_path / "bent.glb", channels, change=change)
    with pytest.raises(SceneError, match=rf"bent\.glb: animation .*{message}"):
        load_scene(tmp_path / "bent.glb")
