"""Motion vectors: every convention is named, what is none of them is not, and frames are made."""

from __future__ import annotations

import json
import re

import attrs
import numpy as np
import pytest
from commands import hmdwarp
from PIL import Image
from reference.motion_frames import (
    CONVENTIONS,
    FAR,
    LOW,
    NEAR,
    SIZE,
    TrueFrame,
    arrays_of,
    depth_of,
    ndc,
    skinned_glb,
    true_frames,
    vectors_of,
    walking_head,
    write_folder,
)  # fmt: skip
from scipy.spatial.transform import Rotation

from hmdwarp.check import Convention, MotionFrame, MotionFrames, check_motion, motion_mismatch, read_motion
from hmdwarp.check.synthesis import synthesise
from hmdwarp.colour import linear_from_srgb
from hmdwarp.errors import InputError
from hmdwarp.geometry import DepthLayer, Fov, Pose, View
from hmdwarp.scenes import InputEvent, load_scene
from hmdwarp.sources.server import Server

MS, STEP_NS = 10**6, 50 * 10**6
# Where a head begins to walk, and when, so that things move in view.
SCENES = {"playroom": ((0.0, 1.4, 0.2), 250), "parade": ((0.2, 1.5, 0.2), 250), "skinned": ((0.0, 1.6, 0.5), 300)}
EXTENSION = CONVENTIONS[0]


@pytest.fixture(scope="module")
def true(gpu, tmp_path_factory) -> dict[str, list[TrueFrame]]:
    found = {}
    for name, (at, start) in SCENES.items():
        scene = skinned_glb().load(tmp_path_factory.mktemp("skin")) if name == "skinned" else load_scene(name)
        if name == "playroom":
            scene.inputs.add(InputEvent(0, "push", "ball", direction=(-0.6, 0, -1)))
            scene.inputs.add(InputEvent(0, "push", "door", direction=(1, 0, 0)))
        server = Server(gpu, scene)
        found[name] = true_frames(server, walking_head(at), [start * MS + k * STEP_NS for k in range(4)])
        server.close()
    return found


def given(
    frames: list[TrueFrame], vectors: list[np.ndarray], stated: tuple[str, ...] = EXTENSION, **more
) -> MotionFrames:
    planes = DepthLayer(0, 1, NEAR, FAR)
    return MotionFrames(
        [
            MotionFrame(f"{number}", frame.colour, frame.view, frame.time_ns, depth_of(frame), one if number else None,
                        planes, **{"jitter": tuple(frame.jitter), **more})
            for number, (frame, one) in enumerate(zip(frames, vectors, strict=True))
        ],
        Convention(*stated),
    )  # fmt: skip


@pytest.mark.parametrize("scene", SCENES)
def test_each_of_32_conventions_is_named_from_four_frames(true, scene):
    for convention in CONVENTIONS:
        verdict = check_motion(given(true[scene], arrays_of(true[scene], convention)))
        assert attrs.astuple(verdict.best) == convention, verdict.headline()
        assert verdict.verdict == ("right" if convention == EXTENSION else "wrong"), verdict.headline()
        assert all(one.told for one in verdict.properties), (convention, verdict.lines())
        # Exact but for half floats: the factor is 1 within 1 %, z that of the depth.
        assert np.abs(np.array(verdict.contradictions.factor) - 1).max() < 0.01
        assert verdict.z is None or abs(verdict.z[0] - 1) < 0.05


@pytest.mark.parametrize("scene", ["parade"])
def test_a_convention_that_is_stated_is_right(true, scene):
    for convention in CONVENTIONS[5::9]:
        verdict = check_motion(given(true[scene], arrays_of(true[scene], convention), convention))
        assert verdict.verdict == "right" and not verdict.code()


def changed(change):
    """A fault that does something to right vectors."""
    return lambda now, before, vectors: change(vectors)


def seen_from(view: View, other: View, points: np.ndarray) -> np.ndarray:
    """Points in one eye, in the other's axes."""
    return other.pose.inverse().transform(view.pose.transform(points))


def as_if(turns: bool = True, moves: bool = True):
    """Vectors of a camera alone, that only turns or only moves."""

    def vectors(now, before, right):
        turn = before if turns else now
        then = View(
            Pose((before if moves else now).view.pose.position_m, turn.view.pose.orientation_xyzw), now.view.fov
        )
        return ndc(now.view, now.now) - ndc(then, seen_from(now.view, then, now.now))

    return vectors


def objects_alone(now, before, right):
    return np.where(now.moves[..., None], right - as_if()(now, before, right), 0)


def other_lens(now, before, right):
    wide = View(
        Pose(),
        Fov(*(0.9 * angle for angle in (now.view.fov.left, now.view.fov.right, now.view.fov.down, now.view.fov.up))),
    )
    return ndc(wide, now.now) - ndc(wide, now.then)


def half_as_full(right):
    out = np.zeros_like(right)
    out[: LOW[1] // 2, : LOW[0] // 2] = right[::2, ::2]
    return out


def overlay(right):
    out = right.copy()
    out[80:, 40:120] = 0
    return out


def twice_jittered(times):
    return lambda now, before, right: right + np.append(2 * times * (now.jitter - before.jitter) / SIZE, 0)


# What is wrong, the scenes that show it, and what it does to right vectors.
FAULTS = {
    "the camera alone": (("playroom", "parade", "skinned"), as_if()),
    "the objects alone": (("playroom", "parade"), objects_alone),
    "the camera's turn alone": (("parade",), as_if(moves=False)),
    "the camera's way alone": (("skinned",), as_if(turns=False)),
    "what stands still left cleared": (("parade",), lambda now, _, right: np.where(now.moves[..., None], right, 0)),
    "the sky left cleared": (("parade",), lambda now, _, right: np.where((now.inverse_depth > 0)[..., None], right, 0)),
    "no clear at all": (("skinned",), lambda now, _, right: np.where(now.moves[..., None], right, np.roll(right, 40, 1) * 0.5)),
    "an overlay that writes zeros": (("parade",), changed(overlay)),
    "a half picture read as a full one": (("playroom",), changed(half_as_full)),
    "a quarter read as the whole": (("parade",), changed(lambda v: np.repeat(np.repeat(v[:60, :80], 2, 0), 2, 1))),
    "a sub-image six pixels off": (("parade",), changed(lambda v: np.roll(v, (6, 6), (0, 1)))),
    "rows upside down": (("parade",), changed(lambda v: v[::-1])),
    "x and y exchanged": (("skinned",), changed(lambda v: v[..., [1, 0, 2]])),
    "half as much again": (("parade",), changed(lambda v: 1.5 * v)),
    "nine tenths": (("playroom",), changed(lambda v: 0.9 * v)),
    "per second": (("skinned",), changed(lambda v: 20 * v)),
    "coded from 0 to 1": (("parade",), changed(lambda v: 0.5 * v + 0.5)),
    "clamped": (("parade",), changed(lambda v: np.clip(v, -0.02, 0.02))),
    "coded as a gamma": (("playroom",), changed(lambda v: np.sign(v) * np.abs(v) ** (1 / 2.2))),
    "noise of a pixel and a half": (("skinned",), changed(lambda v: v + np.random.default_rng(1).normal(0, 0.01, v.shape))),
    "another field of view": (("parade",), other_lens),
    "jitter twice": (("skinned",), twice_jittered(2)),
    "jitter the wrong way": (("skinned",), twice_jittered(-1)),
}  # fmt: skip


@pytest.mark.parametrize("fault", [*FAULTS, "a frame late", "to the frame before last"])
def test_what_is_no_convention_cannot_be_told(true, fault):
    scenes, change = FAULTS.get(fault, (("parade",), None))
    for scene in scenes:
        frames = true[scene]
        right = [vectors_of(now, before, EXTENSION) for before, now in zip(frames, frames[1:], strict=False)]
        if fault == "a frame late":
            found = [right[0] * 0, *right[:-1]]
        elif change is None:
            found = [one + old for one, old in zip(right, [right[0] * 0, *right[:-1]], strict=True)]
        else:
            found = [change(now, before, one) for now, before, one in zip(frames[1:], frames, right, strict=False)]
        verdict = check_motion(given(frames, [right[0] * 0, *(one.astype(np.float16) for one in found)]))
        assert verdict.verdict == "cannot be told" and not verdict.explained, (scene, verdict.headline())
        assert not verdict.code() and "cannot be told" in verdict.headline()
        assert motion_mismatch(verdict).shape[2] == 3


def still_head(frames: list[TrueFrame]) -> list[TrueFrame]:
    return [attrs.evolve(frames[0], time_ns=frame.time_ns, then=frames[0].now) for frame in frames]


def test_what_frames_do_not_show_is_said(true):
    """Without jitter its place in the vectors cannot be told; without motion nothing can."""
    frames = still_head(true["skinned"])
    none = check_motion(given(frames, arrays_of(frames, EXTENSION)))
    assert none.verdict == "right" and not any(one.told for one in none.properties)
    assert "cannot be told from" in "\n".join(none.lines())
    frames = [attrs.evolve(frame, jitter=np.zeros(2)) for frame in true["skinned"]]
    shifted = check_motion(given(frames, arrays_of(frames, EXTENSION)))
    assert not next(one for one in shifted.properties if one.name == "jitter").told


def test_the_line_to_change_makes_them_those_of_the_extension(true):
    frames = true["skinned"]
    for convention in CONVENTIONS[3:24:6]:
        wrong = given(frames, arrays_of(frames, convention))
        line = check_motion(wrong).code()[0]
        scale = tuple(map(float, re.search(r"Scale = \{(.*)\}", line)[1].split(",")))[:3]
        read = check_motion(given(frames, arrays_of(frames, convention), scale=scale))
        assert attrs.evolve(read.best, jitter="out") == Convention() and read.best.jitter == convention[3], line


def test_a_folder_is_read_as_it_is_stated_and_the_command_says_what_is_wrong(true, tmp_path):
    frames, read = true["parade"], ("uv", "up", "previous - current", "in")
    folder = write_folder(tmp_path / "frames", frames, read)
    picture = tmp_path / "found.png"
    done = hmdwarp("check", "--motion", folder, "--out", picture).stdout
    assert done.startswith("wrong: unit, y axis, direction and jitter.") and picture.exists()
    assert "info.motionVectorScale = {-2, 2, -1, 0}" in done and "standard errors ahead)  <- not as stated" in done
    stated = dict(zip(("unit", "y", "sign", "jitter"), read, strict=True))
    write_folder(folder, frames, read, convention=stated)
    data = json.loads(hmdwarp("check", "--motion", folder, "--json").stdout)
    assert data["verdict"] == "right" and data["told"] == [*stated] and data["code"] == []


def test_depth_of_16_bits_scales_offsets_and_sub_images_are_read(true, tmp_path):
    frames = true["parade"]
    folder = write_folder(
        tmp_path, frames, EXTENSION, motionVectorScale=[0.5, 0.5, 0.5, 0], motionVectorOffset=[-1, -1, -1, 0]
    )
    rect = {"imageRect": {"offset": {"x": 4, "y": 2}, "extent": {"width": LOW[0], "height": LOW[1]}}}
    data = json.loads((folder / "motion.json").read_text())
    for number, frame in enumerate(frames):
        wide = np.full((LOW[1] + 5, LOW[0] + 9, 4), 9.0)
        wide[2:-3, 4:-5, :3] = 2 * (np.load(folder / f"{number}.motion.npy").astype(float) + 1)
        np.save(folder / f"{number}.motion.npy", wide)
        Image.fromarray(np.rint(65535 * depth_of(frame)).astype(np.uint16)).save(folder / f"{number}.depth.png")
        data["frames"][number] |= {"depth": f"{number}.depth.png", "motionVectorSubImage": rect}
    (folder / "motion.json").write_text(json.dumps(data))
    read = read_motion(folder)
    assert check_motion(read).verdict == "right"
    # 16 bits of a buffer from 0.1 m: half a step is 1e-5 of 10 1/m.
    assert np.abs(read.frames[1].inverse_depth - np.maximum(frames[1].inverse_depth, 1 / FAR)).max() < 1e-4


def test_blender_s_layers_are_read_as_they_are(true, tmp_path):
    """Source: Blender 4.2 Manual, Render Passes: Z is the distance, Vector the motion in pixels.

    To the frame before (X, Y) and after (Z, W); EXR names VIEWLAYER.PASS.CHANNEL, light is linear.
    """
    exr = pytest.importorskip("OpenEXR")
    frames = [attrs.evolve(frame, jitter=np.zeros(2)) for frame in true["skinned"]]
    shot = write_folder(tmp_path, frames, EXTENSION, convention={"jitter": "in"}, depthUnit="metres")
    data = json.loads((shot / "motion.json").read_text())
    for number, (frame, row) in enumerate(zip(frames, data["frames"], strict=True)):
        vectors = vectors_of(frame, frames[max(number - 1, 0)], ("pixels", "up", "previous - current", "in"))
        light = linear_from_srgb(true["skinned"][number].colour)
        with np.errstate(divide="ignore"):
            layers = {"Combined": dict(zip("RGB", np.moveaxis(light, 2, 0), strict=True))}
        passes = {"Depth.Z": 1 / frame.inverse_depth, "Vector.X": vectors[..., 0], "Vector.Y": vectors[..., 1],
                  "Vector.Z": 0 * vectors[..., 0], "Vector.W": 0 * vectors[..., 0]}  # fmt: skip
        big = {f"ViewLayer.{name}": np.kron(one, np.ones((2, 2))).astype(np.float32) for name, one in passes.items()}
        big |= {f"ViewLayer.Combined.{name}": np.ascontiguousarray(one) for name, one in layers["Combined"].items()}
        name = f"{number:04}.exr"
        exr.File({"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}, big).write(str(shot / name))
        row |= {"colour": name, "depth": name} | ({"motion": name} if number else {})
    (shot / "motion.json").write_text(json.dumps(data))
    found = check_motion(read_motion(shot))
    assert (found.best.unit, found.best.y, found.best.sign) == ("pixels", "up", "previous - current"), found.headline()


@pytest.mark.parametrize(("change", "message"), [
    ({"convention": {"unit": "inches"}}, "expected ndc, uv, pixels, metres"),
    ({"frames": 3}, "expected a list of objects"),
    ({"nearZ": 1, "farZ": 1}, "expected two different positive distances"),
    ({"depthSubImage": {"imageRect": {"offset": {"x": 9, "y": 0}, "extent": {"width": 160, "height": 9}}}}, "the file has"),
    ({"motion": None}, "expected two or more with depth"),
    ({"depth": None}, "motion vectors without depth"),
    ({"colour": "../elsewhere.png"}, "elsewhere"),
    ({"scale": 2}, "expected the keys of docs/motion.md"),
    ({"displayTime": 5}, "does not rise"),
])  # fmt: skip
def test_what_does_not_fit_is_refused(true, tmp_path, change, message):
    folder = write_folder(tmp_path / "frames", true["parade"][:2], EXTENSION)
    data = json.loads((folder / "motion.json").read_text())
    shared = {key: value for key, value in change.items() if key in ("frames", "convention")}
    for row in data["frames"]:
        row |= {key: value for key, value in change.items() if key not in shared}
    (folder / "motion.json").write_text(json.dumps(data | shared))
    with pytest.raises(InputError, match=re.escape(message)):
        read_motion(folder)


def test_a_frame_is_made_of_vectors_in_any_convention_and_of_a_space_that_moves(true):
    """By its vectors the swinging sheet, an eighth of the picture, is where it is: 2 dB and more.

    The application turns and moves its space before the third frame; poses are in that space.
    """
    frames = true["skinned"]
    moved = Pose((0.3, -0.1, 2.0), Rotation.from_euler("y", 40, degrees=True).as_quat())
    for convention in (EXTENSION, CONVENTIONS[13]):
        plain = given(frames, arrays_of(frames, convention), convention)
        spaces = [attrs.evolve(one, view=one.view.at(moved.inverse() @ one.view.pose)) if number >= 2 else one
                  for number, one in enumerate(plain.frames)]  # fmt: skip
        spaces[2] = attrs.evolve(spaces[2], app_space_delta=moved)
        shifted = attrs.evolve(plain, frames=spaces)
        assert check_motion(shifted).verdict == "right"
        made, same = list(synthesise(plain)), list(synthesise(shifted))
        for one, other in zip(made[:2], same[:2], strict=True):
            assert one.psnr_db > one.without_vectors_db + 2 > one.as_it_was_db + 8
            assert abs(one.psnr_db - other.psnr_db) < 0.05  # velocities are halves
        assert made[2].truth is None and made[2].time_ns == frames[3].time_ns + STEP_NS


def test_the_command_writes_frames_and_their_error(true, tmp_path):
    folder = write_folder(tmp_path / "frames", true["skinned"][:3], EXTENSION)
    done = hmdwarp("synthesise", folder, "--at", -1, "--out", tmp_path / "made")
    rows = json.loads((tmp_path / "made" / "synthesis.json").read_text())["frames"]
    assert [row["truth"] for row in rows] == ["0.png", "1.png"] and done.stdout.count("PSNR") == 2
    assert Image.open(tmp_path / "made" / rows[0]["file"]).size == SIZE
    refused = hmdwarp("synthesise", folder, "--at", 3, "--out", tmp_path / "far")
    assert refused.returncode == 2 and "--at 3: expected -1 to 2" in refused.stderr
