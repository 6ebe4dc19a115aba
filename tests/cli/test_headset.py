"""hmdwarp headset: a picture of a headset, and its file from an export."""

from __future__ import annotations

import json

import attrs
import numpy as np
import pytest
from headsets.test_lens_models import hmdq_json, vive_json
from PIL import Image

from hmdwarp.headsets import headset_names, headset_toml, load_headset


@pytest.mark.parametrize("name", ["index", "rift-dk1", "vive.json"])
def test_a_picture_of_a_headset(command, tmp_path, name):
    if name.endswith("json"):
        name = str(tmp_path / name)
        (tmp_path / "vive.json").write_text(json.dumps(vive_json()))
    out = tmp_path / "shown.png"
    command("headset", "show", name, "--out", out).done()
    picture = np.asarray(Image.open(out).convert("RGB"))
    # White paper, the left eye's blue and the right eye's orange.
    for colour in ((255, 255, 255), (11, 99, 197), (194, 65, 12)):
        assert (np.abs(picture.astype(int) - colour).max(axis=-1) < 8).sum() > 100
    command("headset", "show", name, "--out", out).refused("exists already")
    command("headset", "show", name, "--out", tmp_path / "shown.jpg").refused("expected a .png file")


def test_an_export_becomes_a_file_of_the_same_eyes(command, tmp_path):
    (tmp_path / "mine.json").write_text(json.dumps(hmdq_json()))
    command("headset", "from-hmdq", tmp_path / "mine.json", "--out", tmp_path / "mine.toml").done()
    before, after = (load_headset(str(tmp_path / f"mine.{kind}")) for kind in ("json", "toml"))
    for one, other in zip(before.eyes, after.eyes, strict=True):
        assert other.head_from_eye.isclose(one.head_from_eye, 1e-12)
        assert other.fov.tangents == pytest.approx(one.fov.tangents) and other.hidden == one.hidden
    assert attrs.evolve(after, eyes=before.eyes) == before
    command("headset", "from-hmdq", tmp_path / "mine.json", "--out", tmp_path / "mine.txt").refused("a .toml file")
    listed = [
        json.loads(command("list", "headsets", tmp_path / f"mine.{kind}", "--json").done().out)
        for kind in ("json", "toml")
    ]
    assert listed[0] == listed[1] and listed[0][0]["eye_size"] == "x".join(map(str, before.eye_size_px))
    command("list", "headsets", "no.toml").refused("no.toml")


@pytest.mark.parametrize("name", [name for name in headset_names() if load_headset(name).lens is None])
def test_a_headset_written_and_read_is_the_same(tmp_path, name):
    before = load_headset(name)
    (tmp_path / "again.toml").write_text(headset_toml(before))
    after = load_headset(str(tmp_path / "again.toml"))
    assert after.cants_deg == pytest.approx(before.cants_deg)
    assert (after.ipd_m, after.overlap_deg) == pytest.approx((before.ipd_m, before.overlap_deg))
    for one, other in zip(before.eyes, after.eyes, strict=True):
        assert other.head_from_eye.isclose(one.head_from_eye, 1e-12) and other.hidden == one.hidden
