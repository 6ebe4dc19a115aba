"""Files that the user or another file names: whatever they are, one line says so, at once.

Every reader of a file is here: an entry of READERS, or a layout of recorded frames.
"""

from __future__ import annotations

import os
import resource
import shutil
import socket
import struct
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
import pytest
from PIL import Image
from recorded_folders import HAS_EXR, LAYOUTS, Form, taken
from ros_bags import BEGINS_NS, FORMS, HAS_ROSBAGS, Messages, form_of, write_bag
from scenes.glb import Glb

from hmdwarp.base import InputError, opened, text_in
from hmdwarp.base.named_files import TABLE, allow_outside
from hmdwarp.client.classes import load_client
from hmdwarp.experiments.bench import MergeOptions, merge
from hmdwarp.headsets import load_headset
from hmdwarp.link.delays import read_delays
from hmdwarp.pipeline.governor import read_rows
from hmdwarp.poses import load_trace
from hmdwarp.poses.reading import pose_messages as bags
from hmdwarp.poses.reading import text_table
from hmdwarp.scenes import load_scene
from hmdwarp.sources import sequences
from hmdwarp.sources.feed.options import public_key, secret_in
from hmdwarp.sources.sequences import SequenceOptions, read_frame, read_view
from hmdwarp.study.analysis.findings import load_claims
from hmdwarp.study.analysis.long_table import from_csv
from hmdwarp.study.design import load_design
from hmdwarp.study.design.definitions import resolve_paths
from hmdwarp.study.respondents import load_model
from hmdwarp.study.scales import load_scale

GIB = 1 << 30
# Name of the file, and what reads it.
READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "trace": ("head.csv", load_trace),
    "headset": ("mine.toml", lambda path: load_headset(str(path))),
    "client": ("mine.toml", lambda path: load_client(str(path))),
    "study": ("mine.toml", lambda path: load_design(str(path))),
    "scale": ("mine.toml", lambda path: load_scale(str(path))),
    "respondents": ("mine.toml", lambda path: load_model(str(path))),
    "published figures": ("mine.toml", load_claims),
    "ratings": ("mine.csv", from_csv),
    "delays": ("delays.csv", read_delays),
    "token": ("token", secret_in),
    "server's key": ("server.key", public_key),
    "bench": ("bench.json", read_rows),
    "bench to merge": (
        "bench.json",
        lambda path: merge(MergeOptions(folders=(path.parent, path.parent), out=path / "out")),
    ),
    "view": ("pose.json", read_view),
    **{f"scene {ending}": (f"scene.{ending}", load_scene) for ending in ("glb", "gltf", "obj", "ply")},
    **{f"frame {ending}": (f"frame.{ending}", read_frame) for ending in ("npz", "png", "tiff")},
}


def put_socket(path: Path) -> None:
    here = Path.cwd()
    os.chdir(path.parent)  # the name of a socket has 108 bytes at most
    try:
        with socket.socket(socket.AF_UNIX) as one:
            one.bind(path.name)
    finally:
        os.chdir(here)


def put_large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2 * 1024 * GIB if path.suffix in (".bag", ".db3", ".mcap", ".mp4") else 10 * GIB)


OTHERS = {
    "a pipe": os.mkfifo,
    "a socket": put_socket,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "a directory": Path.mkdir,
    "bytes: expected": put_large,
}


@pytest.fixture(autouse=True)
def little_memory():
    """What is read is known to be unfit before it is in memory."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    yield
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300 * 1024  # KiB; what imports take


def refused(read: Callable[[], object], *words: str) -> str:
    with pytest.raises(InputError) as caught:
        read()
    said = str(caught.value)
    assert "\n" not in said and all(word in said for word in words), said
    return said


@pytest.mark.parametrize("what", OTHERS)
@pytest.mark.parametrize("name", READERS)
def test_a_file_that_the_user_names_is_plain_and_of_bounded_size(name, what, tmp_path):
    called, read = READERS[name]
    OTHERS[what](tmp_path / called)
    refused(lambda: read(tmp_path / called), what)


def test_a_file_that_grows_while_it_is_read_is_refused(tmp_path):
    path = tmp_path / "growing.toml"
    path.write_text("a = 1\n")
    with opened(path, TABLE) as file:
        with path.open("a") as writer:
            writer.write("b = 2\n")
        refused(file.read, "grew while it was read")


def test_names_that_no_file_can_have_are_one_line(tmp_path):
    for name in ("a\0b", "half \ud800 a character", "x" * 5000, "a\nb"):
        assert len(refused(lambda name=name: text_in(tmp_path / name, TABLE))) < 700


def test_arrays_are_bounded_by_what_they_unpack_to(tmp_path):
    """6 MB of the file were 6.4 GB; not one array is made."""
    np.savez_compressed(tmp_path / "a.npz", colour=np.zeros((9000, 20_000, 3), np.uint8), depth_m=np.zeros((1, 1)))
    refused(lambda: sequences.open(tmp_path), "bytes, unpacked; expected at most 536870912")


def test_a_trace_has_so_many_rows_at_most(tmp_path, monkeypatch):
    lines = ["time_ns,x,y,z,qx,qy,qz,qw\n", *(f"{k}000000,0,1.6,0,0,0,0,1\n" for k in range(101))]
    monkeypatch.setattr(text_table, "MOST_ROWS", 100)
    (tmp_path / "head.csv").write_text("".join(lines[:-1]))
    assert len(load_trace(tmp_path / "head.csv").track) == 100
    (tmp_path / "head.csv").write_text("".join(lines))
    refused(lambda: load_trace(tmp_path / "head.csv"), "more than 100 rows; expected fewer: cut it")


@pytest.mark.skipif(not HAS_EXR, reason="OpenEXR is not installed")
def test_pixels_of_an_exr_are_bounded_by_what_they_unpack_to(tmp_path):
    """No pixel of it is read: it holds as many as before."""
    LAYOUTS["exr"].write(tmp_path, taken(1))
    (file,) = tmp_path.glob("*.exr")
    head, name, rest = file.read_bytes().partition(b"dataWindow\0box2i\0\x10\0\0\0")
    file.write_bytes(head + name + struct.pack("<4i", 0, 0, 6000, 6000) + rest[16:])
    form = Form("folder", print, SequenceOptions())
    refused(lambda: read_all(form, tmp_path), "bytes of pixels, unpacked", "at most 536870912")


@pytest.mark.skipif(not HAS_ROSBAGS, reason="rosbags is not installed")
@pytest.mark.parametrize(
    ("kind", "packed"),
    [(".bag", ["BZ2"]), (".bag", ["LZ4"]), (".db3", ["FILE", "ZSTD"]), (".db3", ["MESSAGE", "ZSTD"]),
     (".mcap", ["STORAGE", "ZSTD"])],
)  # fmt: skip
def test_a_bag_unpacks_to_so_many_bytes_at_most(tmp_path, kind, packed):
    """Of 17 MB of zeros and of one; what is packed is a few kB."""
    messages = Messages(1 if kind == ".bag" else 2)

    def topics(side: int) -> list[str]:
        folder = tmp_path / str(side)
        folder.mkdir()
        image = messages.image(BEGINS_NS, np.zeros((side, side, 3), np.uint8), "bgr8")
        write_bag(folder, kind, [("/camera", "sensor_msgs/Image", BEGINS_NS, image)], messages, packed)
        bag = bags.Bag(next(folder.glob("*.bag"), folder))
        return [topic for topic, _, _ in bag.messages(["/camera"])]

    assert topics(600) == ["/camera"]
    refused(lambda: topics(2400), "cannot be read as a bag", "unpacked")


# --- layouts of recorded frames


FRAMES = taken(3)


@pytest.fixture(scope="module", params=FORMS)
def recorded(request, tmp_path_factory):
    form, folder = form_of(request.param), tmp_path_factory.mktemp(request.param) / "taken"
    folder.mkdir()
    form.write(folder, FRAMES)
    return form, folder


def read_all(form: Form, folder: Path) -> list[object]:
    options = attrs.evolve(form.options, layout=form.reader)
    return [frame.read() for frame in sequences.open(folder, options).frames]


def one_of_each_kind(folder: Path) -> list[Path]:
    """The first file of each folder and ending."""
    found = {(path.parent, path.suffix): path for path in sorted(folder.rglob("*"), reverse=True) if path.is_file()}
    return sorted(found.values())


def in_its_place(path: Path, put: Callable[[Path], None], read: Callable[[], object]) -> str | None:
    """What is said where something else is at a path; None where it is not missed."""
    kept = path.with_name(path.name + ".kept")
    path.rename(kept)
    try:
        put(path)
        read()
    except InputError as error:
        return str(error)
    finally:
        if path.is_dir() and not path.is_symlink():
            path.rmdir()
        else:
            path.unlink(missing_ok=True)
        kept.rename(path)
    return None


def test_every_file_of_a_layout_is_plain_bounded_and_inside_its_folder(recorded, tmp_path):
    form, folder = recorded
    for path in one_of_each_kind(folder):
        if in_its_place(path, lambda path: None, lambda: read_all(form, folder)) is None:
            continue  # this reader does without it
        for put in OTHERS.values():
            said = in_its_place(path, put, lambda: read_all(form, folder))
            assert said is not None and "\n" not in said, (path.name, put.__name__)
        outside = tmp_path / path.name
        shutil.copy(path, outside)
        said = in_its_place(path, lambda path: path.symlink_to(outside), lambda: read_all(form, folder))  # noqa: B023
        assert said is not None and "lies outside" in said and "--allow-outside" in said, (path.name, said)


# Where a file of each names another one: in what file, what stands there, with the new name for {},
# and what it named.
NAMING = {
    "nerfstudio": ("transforms.json", '"depth/0.png"', '"{}"', "depth/0.png"),
    "tum": ("depth.txt", "depth/0.png", "{}", "depth/0.png"),
    "pictures": ("0.json", "{", '{{"depth": "{}", ', "0.depth.png"),
}


@pytest.mark.parametrize("up", ["..", "{}"], ids=["a way up", "an absolute name"])
@pytest.mark.parametrize("kind", NAMING)
def test_frames_name_files_of_their_own_folder_alone(kind, up, tmp_path, monkeypatch):
    form, folder, (file, found, put, target) = FORMS[kind], tmp_path / "taken", NAMING[kind]
    folder.mkdir()
    form.write(folder, FRAMES)
    shutil.copy(folder / target, tmp_path / "secret.png")
    text, name = (folder / file).read_text(), f"{up.format(tmp_path)}/secret.png"
    assert found in text
    (folder / file).write_text(text.replace(found, put.format(name), 1))
    refused(lambda: read_all(form, folder), "secret.png", "lies outside", "--allow-outside")
    monkeypatch.setenv("HMDWARP_ALLOW_OUTSIDE", "")  # given back after the test
    allow_outside(True)
    assert len(read_all(form, folder)) == len(FRAMES)


# --- scenes

# The scene, where it names a file, and which.
SCENES = {
    "buffer": ("scene.gltf", "scene.gltf", "all numbers.bin"),
    "picture": ("scene.gltf", "scene.gltf", "picture 0.png"),
    "materials": ("scene.obj", "scene.obj", "own.mtl"),
    "picture of materials": ("scene.obj", "own.mtl", "own.png"),
}
OBJ = "mtllib own.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"


def write_scenes(folder: Path) -> None:
    folder.mkdir()
    made = Glb()
    made.material(pbrMetallicRoughness={"baseColorTexture": made.texture(np.full((8, 8, 4), 200, np.uint8))})
    made.write_gltf(folder / "scene.gltf", inside=False)
    (folder / "scene.obj").write_text(OBJ)
    (folder / "own.mtl").write_text("newmtl m\nmap_Kd own.png\n")
    Image.new("RGB", (2, 2)).save(folder / "own.png")


@pytest.mark.parametrize("kind", SCENES)
def test_files_of_a_scene_are_plain_bounded_and_inside_its_folder(kind, tmp_path, monkeypatch):
    write_scenes(folder := tmp_path / "scene")
    scene, naming, beside = (folder / name for name in SCENES[kind])
    whole, right, outside = load_scene(scene).triangle_count, naming.read_text(), tmp_path / beside.name
    beside.rename(outside)
    for what, put in OTHERS.items():
        put(beside)
        if what == "a directory":  # as if there were none
            assert "picture" not in kind or load_scene(scene).notes
            beside.rmdir()
        else:
            refused(lambda: load_scene(scene), what)
            beside.unlink()
    beside.symlink_to(outside)
    for way in (beside.name, f"../{beside.name}", f"file://{outside}", str(outside)):
        naming.write_text(right.replace(beside.name.replace(" ", "%20"), way))
        refused(lambda: load_scene(scene), "lies outside", "--allow-outside")
    monkeypatch.setenv("HMDWARP_ALLOW_OUTSIDE", "")
    allow_outside(True)
    assert load_scene(scene).triangle_count == whole


# --- a study


@pytest.mark.parametrize(
    ("key", "name"),
    [("scene", "secret.glb"), ("headset", "secret.toml"), ("delay_trace", "secret.csv"), ("frames", "secret")],
)
def test_a_study_names_files_of_its_own_folder_alone(key, name, tmp_path):
    (tmp_path / "study").mkdir()
    for value in (f"../{name}", str(tmp_path / name)):
        refused(lambda value=value: resolve_paths(tmp_path / "study", {key: value}), key, "lies outside")
