"""fuzz.py finds what it must; `make fuzz` runs it (tests/test_make.py)."""

from __future__ import annotations

import random
import re

import fuzz
import pytest


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
FOUND = {
    "a matrix whose rows have several lengths": (
        "frames redwood",
        "camera_intrinsic.json",
        rb"40\.0, 0,",
        b"40.0, [1, 2],",
    ),
    "an instant beyond 64 bits": ("frames pictures", "1.json", rb'"time_s": [\d.]+', b'"time_s": 1e308'),
    "an instant that is a list of lists": ("frames pictures", "1.json", rb'"time_s": [\d.]+', b'"time_s": [1, [2]]'),
    "pixels whose library prints three lines of its own": ("frames exr", "1.exr", rb"(?s).{40}\Z", b"\xff" * 40),
    "a display window of 10^16 pixels": (
        "frames exr",
        "1.exr",
        rb"(?s)(?<=displayWindow\x00box2i\x00.{12}).{8}",
        b"\xff\xff\xff\x05" * 2,
    ),
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


def test_damage_gets_past_lengths_and_checksums():
    """Half of the damaged containers or more can still be opened as such."""
    import io
    import zipfile

    import numpy as np
    from PIL import Image
    from scenes.glb import Glb

    opened, rng = {"npz": 0, "png": 0}, random.Random(1)
    packed, picture = io.BytesIO(), io.BytesIO()
    np.savez(packed, colour=np.ones((4, 4, 3)))
    Image.new("RGB", (4, 4)).save(picture, "PNG")
    for _ in range(50):
        archive = zipfile.ZipFile(io.BytesIO(fuzz.damaged_zip(packed.getvalue(), rng)))
        opened["npz"] += archive.testzip() is None
        opened["png"] += fuzz.damaged_png(picture.getvalue(), rng)[:4] == b"\x89PNG"
        assert fuzz.damaged_glb(Glb().data(), rng)[:4] == b"glTF"
    assert min(opened.values()) == 50
