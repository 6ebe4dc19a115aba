"""fuzz.py finds what it must; `make fuzz` runs it (tests/test_make.py)."""

from __future__ import annotations

import importlib.util
import re

import fuzz
import pytest
from ros_bags import FORMS

from hmdwarp import poses
from hmdwarp.client.classes import client_names
from hmdwarp.headsets import headset_names
from hmdwarp.poses import load_trace
from hmdwarp.poses.formats import formats
from hmdwarp.sources.sequences.readers import readers
from hmdwarp.study.scales import scale_names


@pytest.mark.parametrize(
    ("work", "told"),
    [
        (lambda: 1 / 0, "ZeroDivisionError"),
        (lambda: bytes(4 << 30) and 0, "MemoryError"),
        (lambda: sum(iter(int, 1)), "killed|over 1 s of CPU"),
    ],
    ids=["fault", "memory", "time"],
)
def test_what_a_case_must_not_do_is_found(work, told, tmp_path, monkeypatch):
    monkeypatch.setattr(fuzz, "MOST_CPU_S", 1)
    outcome = fuzz.in_child(work, tmp_path / "told")
    assert outcome.status not in (fuzz.READ, fuzz.REFUSED)
    assert any(each in outcome.text for each in told.split("|"))


# What the fuzzer found once: a target, its file, and what stood there instead of what.
INSTANT = ("frames pictures", "1.json", rb'"time_s": [\d.]+')
FOUND = {
    "a matrix whose rows have several lengths": (
        *("frames redwood", "camera_intrinsic.json", rb"40\.0, 0,"),
        b"40.0, [1, 2],",
    ),
    "an instant beyond 64 bits": (*INSTANT, b'"time_s": 1e308'),
    "an instant that is a list of lists": (*INSTANT, b'"time_s": [1, [2]]'),
    "pixels whose library prints three lines of its own": ("frames exr", "1.exr", rb"(?s).{40}\Z", b"\xff" * 40),
    "a display window of 10^16 pixels": (
        *("frames exr", "1.exr", rb"(?s)(?<=displayWindow\x00box2i\x00.{12}).{8}"),
        b"\xff\xff\xff\x05" * 2,
    ),
    "rows of a bench that are a number": ("bench merge", "one/bench.json", rb'(?s)"rows": \[.*\]', b'"rows": 0.3'),
    "blocks of a bench that are a list": ("bench merge", "two/bench.json", rb'"blocks": {[^}]*}', b'"blocks": [1]'),
    "2^64 points of an image": ("frames colmap_dense", "sparse/images.bin", rb"(?s).{8}(?=.{24}\Z)", b"\xff" * 8),
}


@pytest.mark.parametrize("found", FOUND)
def test_what_was_found_is_refused_in_one_line(found, tmp_path, capfd):
    name, file, there, instead = FOUND[found]
    target = fuzz.targets().get(name) or pytest.skip(f"{name}: its package is not installed")
    target.write(tmp_path)
    valid = (tmp_path / file).read_bytes()
    damaged = re.sub(there, instead, valid, count=1)
    (tmp_path / file).write_bytes(damaged)
    assert damaged != valid and fuzz.read(target, tmp_path, None) == fuzz.REFUSED
    printed = capfd.readouterr()
    assert printed.out.count("\n") == 1 and not printed.err


def test_every_reader_of_a_registry_has_a_target(tmp_path, monkeypatch):
    """A new format or layout is damaged like the others from its first day."""
    seen: set[str] = set()

    def spy(path, options=None):
        loaded = load_trace(path, options)
        seen.add(loaded.format)
        return loaded

    monkeypatch.setattr(poses, "load_trace", spy)
    targets = fuzz.targets()
    for number, (name, target) in enumerate(targets.items()):
        if name.startswith("trace "):
            (tmp_path / str(number)).mkdir()
            target.write(tmp_path / str(number))
            target.read(tmp_path / str(number), None)
    packaged = {"rosbag": "rosbags"}
    here = {name for name in formats.names() if name not in packaged or importlib.util.find_spec(packaged[name])}
    assert here <= seen
    assert {form.reader for form in FORMS.values()} >= set(readers.names())
    for kind, names in {"headset": headset_names(), "client": client_names(), "scale": scale_names()}.items():
        assert {f"{kind} {name}" for name in names} <= targets.keys()
