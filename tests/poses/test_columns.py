"""Which columns, which clock, which device; angles and matrices instead of quaternions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.poses import TraceOptions, load_trace

from .traces import found, head, kinds, refusal, rows, same_motion, write

TRACK = head()
TABLE = rows(TRACK)
HEADER = "time,x,y,z,qx,qy,qz,qw"


# columns


@pytest.mark.parametrize("text", ["t=1,p=2+3+4,q=5+6+7+8", "q=a4+a5+a6+a7,t=a0,p=a1+a2+a3", "p=2+a2+4,q=5+6+7+8,t=1"])
def test_stated_columns_are_read_by_name_or_number(tmp_path, text):
    path = write(tmp_path / "c.csv", TABLE, ",".join(f"a{i}" for i in range(8)))
    loaded = load_trace(path, TraceOptions(columns=text))
    assert same_motion(loaded.track, TRACK) and loaded.format == "columns"


def test_stated_columns_follow_the_stated_order(tmp_path):
    path = write(tmp_path / "c.csv", rows(TRACK, "wxyz"), header="")
    options = TraceOptions(columns="t=1,p=2+3+4,q=5+6+7+8", quat_order="wxyz")
    assert same_motion(load_trace(path, options).track, TRACK)


# devices


def of_devices(*names: str, zero: str = "") -> list[list[str]]:
    """Rows of several devices, the last of which holds the track; `zero` never tracked."""
    poses = {name: ["5", "5", "5", "1", "0", "0", "0"] for name in names} | {zero: ["0"] * 7}
    return [[name, r[0], *(r[1:] if name == names[-1] else poses[name])] for r in TABLE for name in names]


def test_a_device_name_of_any_length_is_one_of_its_own(tmp_path):
    long = "a tracker whose name is longer than most"
    table = [[f"{long} {i}", *r[:1], str(i), *r[2:]] for r in TABLE for i in (1, 2)]
    path = write(tmp_path / "d.csv", table, "device," + HEADER)
    for i in (1, 2):
        track = load_trace(path, TraceOptions(device=f"{long} {i}")).track
        assert len(track) == len(TABLE) and (track.position_m[:, 0] == i).all()


def test_the_stated_device_is_read(tmp_path):
    path = write(tmp_path / "d.csv", of_devices("head", "glasses"), "device," + HEADER)
    assert same_motion(load_trace(path, TraceOptions(device="glasses")).track, TRACK)
    assert "there are those of glasses, head" in refusal(path, device="hat")
    assert "leave --device out" in refusal(write(tmp_path / "n.csv", TABLE), device="head")


# JSON


@pytest.mark.parametrize("text", ["[1, 2, 3]", "{}", '{"poses": []}', "[{", '{"a": 1}'])
def test_json_without_poses_is_refused(tmp_path, text):
    path = tmp_path / "poses.json"
    path.write_text(text)
    assert refusal(path)


# clocks


# angles and matrices


def test_rows_without_a_turn_among_matrices_are_dropped(tmp_path):
    turns = Rotation.from_quat(TRACK.orientation_xyzw).as_matrix()
    turns[20:23], turns[40] = 0.0, np.diag([1.0, 1.0, -1.0])
    rows_of = np.concatenate([turns, TRACK.position_m[:, :, None]], axis=2).reshape(-1, 12)
    table = [[r[0], *map(repr, numbers)] for r, numbers in zip(TABLE, rows_of.tolist(), strict=True)]
    loaded = load_trace(write(tmp_path / "m.txt", table, header="", separator=" "))
    defect = found(loaded, "zero-quaternion")
    assert defect.count == 4 and "matrix that is no rotation" in defect.what
    assert len(loaded.track) == len(TRACK) - 4


@pytest.mark.parametrize(("unit", "right"), [("deg", "rad"), ("rad", "deg")])
def test_angles_in_another_unit_are_reported(tmp_path, unit, right):
    turns = Rotation.from_quat(TRACK.orientation_xyzw).as_euler("zxy", degrees=right == "deg")
    table = [[*r[:4], *map(repr, (x, y, z))] for r, (z, x, y) in zip(TABLE, turns.tolist(), strict=True)]
    path = write(tmp_path / "e.csv", table, "time,x,y,z,rot_x,rot_y,rot_z")
    loaded = load_trace(path, TraceOptions(euler=f"ZXY,{unit}"))
    assert any(f"--euler ZXY,{right}" in d.done for d in loaded.defects if d.kind == "angles-implausible")
    assert "angles-implausible" not in kinds(load_trace(path, TraceOptions(euler=f"ZXY,{right}")))
