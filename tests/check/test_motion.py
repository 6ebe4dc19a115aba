"""Motion vectors: every convention is named, what is none of them is not, and frames are made."""

from __future__ import annotations

import json
import os
import re

import attrs
import motion_frames as made
import numpy as np
import pytest
from commands import hmdwarp
from motion_frames import CONVENTIONS, LOW, SIZE, TrueFrame, ndc
from PIL import Image
from scenes.glb import Glb
from scipy import ndimage
from scipy.spatial.transform import Rotation

from hmdwarp.base import InputError, linear_from_srgb
from hmdwarp.check import Convention, MotionFrame, MotionFrames, check_motion, read_motion, synthesise
from hmdwarp.geometry import DepthLayer, Pose, View
from hmdwarp.scenes import InputEvent, load_scene
from hmdwarp.sources.server import Server

MS, STEP_NS = 10**6, 50 * 10**6
# Where a head begins to walk, and when, so that things move in view.
SCENES = {"playroom": ((0.0, 1.4, 0.2), 250), "parade": ((0.2, 1.5, 0.2), 250), "skinned": ((0.0, 1.6, 0.5), 300)}
EVERY = 1 if "HMDWARP_CHECK_CASES" in os.environ else 3
EXTENSION, PLANES = CONVENTIONS[0], DepthLayer(0, 1, made.NEAR, made.FAR)


def skinned_glb() -> Glb:
    """A sheet that a joint swings, before a wall and a floor, all of coarse noise."""

    def noise(seed: int, tint: tuple[float, float, float]) -> np.ndarray:
        values = ndimage.gaussian_filter(np.random.default_rng(seed).random((128, 128, 3)), (1.2, 1.2, 0), mode="wrap")
        return np.uint8(255 * (values - values.min()) / np.ptp(values) * tint)

    made = Glb()
    kinds = [{"baseColorTexture": made.texture(noise(*of))} for of in ((1, (1, 0.6, 0.4)), (2, (0.5, 0.8, 1)))]
    made.material(pbrMetallicRoughness=kinds[0], doubleSided=True)
    made.header["materials"].append({"pbrMetallicRoughness": kinds[1], "doubleSided": True})
    made.skin(weights=((1, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 1, 0, 0)))
    made.header["nodes"][1]["translation"] = [0, 1, -3]
    made.animate("rotation", [0, 1], [(0, 0, np.sin(half), np.cos(half)) for half in (-0.4, 0.4)], node=2)
    uv = np.array([(0, 3), (3, 3), (3, 0), (0, 0)], np.float32)
    wall = [(-8, -3, -3), (8, -3, -3), (8, 6, -3), (-8, 6, -3)]
    for corners in (wall, [(-8, -1.2, 6), (8, -1.2, 6), (8, -1.2, -3), (-8, -1.2, -3)]):
        attributes = {"POSITION": made.numbers(np.array(corners, np.float32)), "TEXCOORD_0": made.numbers(uv)}
        primitive = {"attributes": attributes, "indices": made.primitive["indices"], "material": 1}
        made.header["meshes"].append({"primitives": [primitive]})
        made.header["nodes"].append({"mesh": len(made.header["meshes"]) - 1, "translation": [0, 1, -3]})
        made.header["scenes"][0]["nodes"].append(len(made.header["nodes"]) - 1)
    return made


@pytest.fixture(scope="module")
def true(gpu, tmp_path_factory) -> dict[str, list[TrueFrame]]:
    found = {}
    for name, (at, start) in SCENES.items():
        scene = skinned_glb().load(tmp_path_factory.mktemp("skin")) if name == "skinned" else load_scene(name)
        for thing, way in (("ball", (-0.6, 0, -1)), ("door", (1, 0, 0))) if name == "playroom" else ():
            scene.inputs.add(InputEvent(0, "push", thing, direction=way))
        server = Server(gpu, scene)
        times = [start * MS + k * STEP_NS for k in range(4)]
        found[name] = made.true_frames(server, made.walking_head(at), times)
        if name == "skinned":
            found["steady"] = made.true_frames(server, made.walking_head(at), times, np.zeros((4, 2)))
        server.close()
    return found


def given(
    frames: list[TrueFrame], vectors: list[np.ndarray], stated: tuple[str, ...] = EXTENSION, **more
) -> MotionFrames:
    made_of = zip(frames, vectors, strict=True)
    return MotionFrames([MotionFrame(f"{k}", frame.colour, frame.view, frame.time_ns, made.depth_of(frame),
                                     one if k else None, PLANES, jitter=tuple(frame.jitter), **more)
                         for k, (frame, one) in enumerate(made_of)], Convention(*stated))  # fmt: skip


@pytest.mark.parametrize("scene", SCENES)
def test_each_of_32_conventions_is_named_from_four_frames(true, scene):
    """Each in one of the scenes, by default."""
    for convention in CONVENTIONS[list(SCENES).index(scene) % EVERY :: EVERY]:
        answer = check_motion(given(true[scene], made.arrays_of(true[scene], convention)))
        assert attrs.astuple(answer.reading) == convention, answer.headline
        assert answer.verdict == ("right" if convention == EXTENSION else "wrong"), answer.headline
        assert all(finding.told for finding in answer.findings) and len(answer.findings) == 4, convention
        # Exact but for half floats, and for pixels at edges: 1 % of the factor.
        assert (answer.figures["across"], answer.figures["down"]) == pytest.approx((1, 1), abs=0.01)


def test_right_vectors_of_fine_detail_without_antialiasing_are_right(gpu):
    """Edges of few pixels jump by half a pixel from frame to frame; no two frames agree on it."""
    server = Server(gpu, load_scene("room"))
    frames = made.true_frames(server, made.walking_head((0.2, 1.5, 0.2)), [k * STEP_NS for k in range(5, 9)])
    server.close()
    assert check_motion(given(frames, made.arrays_of(frames, EXTENSION))).verdict == "right"


def as_if(turns: bool = True, moves: bool = True):
    """Vectors of a camera alone, that only turns or only moves."""

    def vectors(now, before, _):
        then = View(Pose((before if moves else now).view.pose.position_m,
                         (before if turns else now).view.pose.orientation_xyzw), now.view.fov)  # fmt: skip
        return ndc(now.view, now.now) - ndc(then, then.pose.inverse().transform(now.view.pose.transform(now.now)))

    return vectors


def within(rows: slice, columns: slice, values):
    """Something else in a part of the vectors' picture, by what they are."""

    def vectors(_, __, right):
        out = right.copy()
        out[rows, columns] = values(right)
        return out

    return vectors


def moving(otherwise):
    """Something else where nothing moves by itself."""
    return lambda now, before, right: np.where(now.moves[..., None], right, otherwise(now, before, right))


def jittered(times):
    return lambda now, before, right: right + np.append(2 * times * (now.jitter - before.jitter) / SIZE, 0)


HALF = slice(LOW[1] // 2), slice(LOW[0] // 2)
# What is wrong, the scenes that show it, and what it makes of a frame, the one before, and right
# vectors; of two that lead further back, the vectors before too.
FAULTS = {
    "the camera alone": ("playroom parade skinned", as_if()),
    "the objects alone": ("playroom parade", lambda *of: np.where(of[0].moves[..., None], of[2] - as_if()(*of), 0)),
    "the camera's turn alone": ("parade", as_if(moves=False)),
    "the camera's way alone": ("skinned", as_if(turns=False)),
    "what stands still left cleared": ("parade", moving(lambda *_: 0)),
    "no clear at all": ("skinned", moving(lambda now, before, right: np.roll(right, 40, 1) / 2)),
    "the sky left cleared": ("parade", lambda now, _, right: np.where((now.inverse_depth > 0)[..., None], right, 0)),
    "an overlay that writes zeros": ("skinned", within(slice(80, None), slice(40, 120), lambda right: 0)),
    "a half picture read as a full one": ("playroom", within(*HALF, lambda right: right[::2, ::2])),
    "a sub-image six pixels off": ("parade", lambda *of: np.roll(of[2], (6, 6), (0, 1))),
    "rows upside down": ("parade", lambda *of: of[2][::-1]),
    "x and y exchanged": ("skinned", lambda *of: of[2][..., [1, 0, 2]]),
    "nine tenths": ("playroom", lambda *of: 0.9 * of[2]),
    "coded from 0 to 1": ("parade", lambda *of: 0.5 * of[2] + 0.5),
    "clamped": ("parade", lambda *of: np.clip(of[2], -0.02, 0.02)),
    "8 bits": ("parade", lambda *of: np.rint(of[2] * 127) / 127),
    "jitter twice": ("skinned", jittered(2)),
    "jitter the wrong way": ("skinned", jittered(-1)),
    "a frame late": ("parade", None),
    "to the frame before last": ("parade", None),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_what_is_no_convention_cannot_be_told(true, fault):
    scenes, change = FAULTS[fault]
    for frames in map(true.get, scenes.split()):
        right = [made.vectors_of(now, before, EXTENSION) for before, now in zip(frames, frames[1:], strict=False)]
        old = [0 * right[0], *right[:-1]]
        if change is None:
            found = old if fault == "a frame late" else [one + two for one, two in zip(right, old, strict=True)]
        else:
            found = [change(now, before, one) for now, before, one in zip(frames[1:], frames, right, strict=False)]
        answer = check_motion(given(frames, [right[0], *(one.astype(np.float16) for one in found)]))
        assert answer.verdict == "cannot be told" and "no convention explains" in answer.headline, answer.headline
        assert not answer.is_told and not answer.code and not answer.findings


def test_what_frames_do_not_show_is_said(true):
    """Without motion nothing can be told; without jitter its place in the vectors cannot."""
    first = true["skinned"][0]
    still = [attrs.evolve(first, time_ns=frame.time_ns, then=first.now) for frame in true["skinned"]]
    none = check_motion(given(still, made.arrays_of(still, EXTENSION)))
    assert none.verdict == "right" and not any(one.told for one in none.findings)
    assert "y up, current - previous, jitter out moves pixels by 0" in none.findings[1].why
    steady = check_motion(given(true["steady"], made.arrays_of(true["steady"], EXTENSION)))
    assert [one.name for one in steady.findings if not one.told] == ["jitter"] and steady.verdict == "right"


def test_the_line_to_change_makes_them_those_of_the_extension(true):
    frames = true["skinned"]
    for convention in CONVENTIONS[3:24:6]:
        vectors = made.arrays_of(frames, convention)
        numbers = re.search(r"Scale = \{(.*)\}", check_motion(given(frames, vectors)).code[0])[1]
        read = check_motion(given(frames, vectors, scale=tuple(map(float, numbers.split(",")))[:3]))
        assert attrs.astuple(read.reading) == (*EXTENSION[:3], convention[3]), numbers


def test_the_command_says_what_is_wrong_and_that_what_is_stated_is_right(true, tmp_path):
    folder = made.write_folder(tmp_path / "frames", true["parade"], CONVENTIONS[15])
    told = hmdwarp("check", "--motion", folder).stdout
    assert told.startswith("wrong: unit, y axis, direction and jitter.")
    assert "info.motionVectorScale = {-2, 2, -1, 0}" in told and "standard errors ahead)  <- not as stated" in told
    stated = dict(zip(("unit", "y", "sign", "jitter"), CONVENTIONS[15], strict=True))
    made.write_folder(folder, true["parade"], CONVENTIONS[15], convention=stated)
    data = json.loads(hmdwarp("check", "--motion", folder, "--json").stdout)
    assert data["verdict"] == "right" and data["told"] and data["code"] == []
    assert [one["name"] for one in data["conventions"] if one["told"] and one["as_stated"]] == [*stated]


def changed(folder, change):
    """A folder whose frames `change` alters, by number."""
    data = json.loads((folder / "motion.json").read_text())
    data["frames"] = [row | change(number) for number, row in enumerate(data["frames"])]
    (folder / "motion.json").write_text(json.dumps(data))
    return folder


def test_depth_of_16_bits_scales_offsets_and_sub_images_are_read(true, tmp_path):
    frames = true["parade"]
    coded = {"motionVectorScale": [0.5, 0.5, 0.5, 0], "motionVectorOffset": [-1, -1, -1, 0]}
    rect = {"imageRect": {"offset": {"x": 4, "y": 2}, "extent": {"width": LOW[0], "height": LOW[1]}}}

    def write(number):
        wide = np.full((LOW[1] + 5, LOW[0] + 9, 4), 9.0)
        wide[2:-3, 4:-5, :3] = 2 * (np.load(tmp_path / f"{number}.motion.npy").astype(float) + 1)
        np.save(tmp_path / f"{number}.motion.npy", wide)
        buffer = np.rint(65535 * made.depth_of(frames[number])).astype(np.uint16)
        Image.fromarray(buffer).save(tmp_path / f"{number}.depth.png")
        return {"depth": f"{number}.depth.png", "motionVectorSubImage": rect}

    read = read_motion(changed(made.write_folder(tmp_path, frames, EXTENSION, **coded), write))
    assert check_motion(read).verdict == "right"
    # Half a step of 16 bits is 8e-6 of the range of a buffer from 0.1 m on, 10 1/m.
    assert np.abs(read.frames[1].inverse_depth - np.maximum(frames[1].inverse_depth, 1 / made.FAR)).max() < 1e-4


def test_blender_s_layers_are_read_as_they_are(true, tmp_path):
    """Source: Blender 4.2 Manual, Render Passes: Z is the distance, Vector the motion in pixels.

    To the frame before (X, Y) and after (Z, W); EXR names VIEWLAYER.PASS.CHANNEL, light is linear.
    """
    exr, frames = pytest.importorskip("OpenEXR"), true["skinned"]
    vectors = made.arrays_of(frames, ("pixels", "up", "previous - current", "in"))

    def write(number):
        passes = dict(zip(("Combined.R", "Combined.G", "Combined.B"),
                          np.moveaxis(linear_from_srgb(frames[number].colour), 2, 0), strict=True))  # fmt: skip
        x, y, none = (*vectors[number][..., :2].transpose(2, 0, 1), np.zeros(LOW[::-1]))
        vector = {"Vector.X": x, "Vector.Y": y, "Vector.Z": none, "Vector.W": none}
        low = vector | {"Depth.Z": 1 / frames[number].inverse_depth}
        passes |= {name: one.repeat(2, 0).repeat(2, 1) for name, one in low.items()}
        layers = {f"ViewLayer.{name}": np.ascontiguousarray(one, np.float32) for name, one in passes.items()}
        head = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
        exr.File(head, layers).write(str(tmp_path / f"{number:04}.exr"))
        motion = {"motion": f"{number:04}.exr"} if number else {}
        return {"colour": f"{number:04}.exr", "depth": f"{number:04}.exr", "jitter": [0, 0]} | motion

    stated = {"unit": "pixels", "y": "up", "sign": "previous - current"}
    shot = made.write_folder(tmp_path, frames, EXTENSION, convention=stated, depthUnit="metres")
    assert check_motion(read_motion(changed(shot, write))).verdict == "right"


FAR_RECT = {"imageRect": {"offset": {"x": 9, "y": 0}, "extent": {"width": 160, "height": 9}}}


@pytest.mark.parametrize(("change", "message"), [
    ({"nearZ": 1, "farZ": 1}, "expected two different positive distances"),
    ({"depthSubImage": FAR_RECT}, "the file has"),
    ({"motion": None}, "expected two or more with depth"),
    ({"depth": None}, "motion vectors without depth"),
    ({"colour": "../elsewhere.png"}, "elsewhere"),
    ({"scale": 2}, "expected the keys of docs/motion.md"),
    ({"depthUnit": "feet"}, "depthUnit is 'feet': expected buffer or metres"),
    ({"displayTime": 5}, "does not rise"),
    ({"pose": [0, 0, 0]}, "expected an XrPosef"),
])  # fmt: skip
def test_what_does_not_fit_is_refused(true, tmp_path, change, message):
    folder = changed(made.write_folder(tmp_path / "frames", true["parade"][:2], EXTENSION), lambda _: change)
    with pytest.raises(InputError, match=re.escape(message)):
        read_motion(folder)
    with pytest.raises(InputError, match="expected ndc, uv, pixels, metres"):
        Convention("inches")


def test_a_frame_is_made_of_vectors_in_any_convention_and_of_a_space_that_moves(true):
    """By its vectors the swinging sheet, an eighth of the picture, is where it is: 2 dB and more.

    The application turns and moves its space before the third frame; poses are in that space.
    """
    frames = true["skinned"]
    moved = Pose((0.3, -0.1, 2.0), Rotation.from_euler("yx", (40, 60), degrees=True).as_quat())
    back = moved.inverse()
    for convention in (EXTENSION, CONVENTIONS[13]):
        plain = given(frames, made.arrays_of(frames, convention), convention)
        first, *later = [attrs.evolve(one, view=one.view.at(back @ one.view.pose)) for one in plain.frames[2:]]
        shifted = attrs.evolve(plain, frames=[*plain.frames[:2], attrs.evolve(first, app_space_delta=moved), *later])
        assert check_motion(shifted).verdict == "right"
        ways = [*synthesise(plain)], [*synthesise(shifted)]
        for one, other in zip(*(way[:2] for way in ways), strict=True):
            assert one.psnr_db > one.without_vectors_db + 2 > one.as_it_was_db + 8
            assert abs(one.psnr_db - other.psnr_db) < 0.05  # velocities are halves
        assert ways[0][2].truth is None and ways[0][2].time_ns == frames[3].time_ns + STEP_NS
        assert np.ptp([way[2].colour.astype(int) for way in ways], axis=0).max() <= 2  # halves: 1, rounding: 1


def test_the_command_writes_frames_and_their_error(true, tmp_path):
    folder = made.write_folder(tmp_path / "frames", true["skinned"][:3], EXTENSION)
    done = hmdwarp("synthesise", folder, "--at", -1, "--out", tmp_path / "made")
    rows = json.loads((tmp_path / "made" / "synthesis.json").read_text())["frames"]
    assert [row["truth"] for row in rows] == ["0.png", "1.png"] and done.stdout.count("PSNR") == 2
    with Image.open(tmp_path / "made" / rows[0]["file"]) as picture:
        assert picture.size == SIZE
    refused = hmdwarp("synthesise", folder, "--at", 3, "--out", tmp_path / "far")
    assert refused.returncode == 2 and "--at 3: expected a number of at least -1 and at most 2" in refused.stderr
