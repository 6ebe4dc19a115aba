"""How head traces of many layouts are read: files with known truth, a table for docs/traces.md.

Each layout is written from the recording `walk`: which way the person looked and which way was up
is known. Numbers and names are those of public files of that kind.
"""

from __future__ import annotations

import gzip
import json
import tempfile
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from scipy.spatial.transform import Rotation

from hmdwarp.errors import HmdwarpError
from hmdwarp.poses import LoadedTrace, PoseTrack, TraceOptions, load_trace
from hmdwarp.poses.reading.axes import Axes, parse_axes

EPOCH_NS = 1_700_000_000 * 10**9
RIGHT, OPTION, REFUSED, WRONG = "right by itself", "warned, with the option", "refused, with the option", "wrong"
_PLAIN = "openxr"


@attrs.frozen
class Layout:
    """A kind of file: its axes, how a row is written, and what a user has to state."""

    name: str
    axes: str
    text: Callable[[list[Row]], str]
    stated: dict[str, Any] = attrs.field(factory=dict)  # fields of TraceOptions; most need one
    packed: bool = False
    # What says so: documents of the data set or of its maker, and for the plain ones of OpenXR.
    proof: str = ""


@attrs.frozen
class Row:
    """One pose in the axes of a file: nanoseconds, position, quaternion xyzw, rotation matrix."""

    ns: int
    p: list[float]
    q: list[float]
    m: list[list[float]]

    @property
    def s(self) -> str:
        """Seconds, every digit."""
        return f"{self.ns // 10**9}.{self.ns % 10**9:09d}"

    def euler(self) -> list[float]:
        """Return Unity's angles about x, y and z in degrees."""
        z, x, y = Rotation.from_quat(self.q).as_euler("zxy", degrees=True)
        return [x, y, z]


def _csv(header: str, row: Callable[[Row], list], separator: str = ",") -> Callable[[list[Row]], str]:
    def text(rows: list[Row]) -> str:
        return "\n".join([*([header] if header else []), *(separator.join(map(str, row(r))) for r in rows), ""])

    return text


def _cm(values: list[float]) -> list[float]:
    return [100 * v for v in values]


def _wxyz(q: list[float]) -> list[float]:
    return [q[3], *q[:3]]


def _aria(rows: list[Row]) -> str:
    header = "graph_uid,tracking_timestamp_us,utc_timestamp_ns,tx_world_device,ty_world_device,tz_world_device,"
    header += "qx_world_device,qy_world_device,qz_world_device,qw_world_device,"
    header += "gravity_x_world,gravity_y_world,gravity_z_world,quality_score"
    lines = [
        ",".join(map(str, ["ab", (r.ns + late) // 1000, r.ns + late, *r.p, *r.q, 0, 0, -9.81, 1.0]))
        for r in rows
        for late in (0, 90_000)
    ]
    return "\n".join([header, *lines, ""])


def _matrix_4x4(r: Row) -> list[float]:
    return [*(v for row, t in zip(r.m, r.p, strict=True) for v in (*row, t)), 0.0, 0.0, 0.0, 1.0]


def _json_lines(rows: list[Row]) -> str:
    named = ((r, dict(zip("xyz", r.p, strict=True)), dict(zip("xyzw", r.q, strict=True))) for r in rows)
    return "\n".join(json.dumps({"time": r.ns / 1e6, "position": p, "orientation": q}) for r, p, q in named)


def _frames(rows: list[Row]) -> str:
    frames = [{"timestamp": r.ns / 1e9, "transform_matrix": np.reshape(_matrix_4x4(r), (4, 4)).tolist()} for r in rows]
    return json.dumps({"camera_angle_x": 1.2, "frames": frames})


def _bodies(rows: list[Row]) -> str:
    names = ("LeftHand", "CenterEyeAnchor", "RightHand")
    lines = [
        ",".join(map(str, [name, r.s, *([0.1, 0.9, 0.2, 0, 0, 0, 1] if "Hand" in name else [*r.p, *r.q])]))
        for r in rows
        for name in names
    ]
    return "\n".join(["device,time,px,py,pz,qx,qy,qz,qw", *lines, ""])


_ASL = "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []"
_POSE = "px,py,pz,qx,qy,qz,qw"
_HEAD = "HeadPosX,HeadPosY,HeadPosZ,HeadOrientationW,HeadOrientationX,HeadOrientationY,HeadOrientationZ"
_RDF = "time,pos_x,pos_y,pos_z,rot_x,rot_y,rot_z"
_ALYX = "delta_time_ms;timestamp;hmd_pos_x;hmd_pos_y;hmd_pos_z;hmd_rot_x;hmd_rot_y;hmd_rot_z;hmd_rot_w"
_HOLOLENS = "timestamp,HeadX,HeadY,HeadZ,HeadRotX,HeadRotY,HeadRotZ,HeadRotW"
_TUM = "# ground truth trajectory\n# timestamp tx ty tz qx qy qz qw"
_QUEST3 = "timestamp[ns],t_wo_x[m],t_wo_y[m],t_wo_z[m],q_wo_w,q_wo_x,q_wo_y,q_wo_z"
_ROS = "header.stamp.sec,header.stamp.nanosec,pose.position.x,pose.position.y,pose.position.z,"
_ROS += "pose.orientation.x,pose.orientation.y,pose.orientation.z,pose.orientation.w"


def _plain(r: Row) -> list:
    return [r.s, *r.p, *r.q]


def _asl(r: Row) -> list:
    return [EPOCH_NS + r.ns, *r.p, *_wxyz(r.q)]


def _questset(r: Row) -> list:
    return [*r.p, *_wxyz(r.q), 0.1, 0.9, 0.2, r.s]


def _ros(r: Row) -> list:
    return [*divmod(EPOCH_NS + r.ns, 10**9), *r.p, *r.q]


# Name, axes, how its text is made, what a user states, who says so; None: OpenXR.
_TABLE = (
    ("OpenXR logger, CSV", _PLAIN, _csv(f"time_s,{_POSE}", _plain), {}, None),
    (
        *("WebXR logger, JSON lines, gzip", _PLAIN, _json_lines, {}),
        "WebXR Device API, XRReferenceSpace: y up, -z forward",
    ),
    (
        *("QuestSet (Quest 2)", _PLAIN, _csv(f"{_HEAD},LeftTouchPosX,LeftTouchPosY,LeftTouchPosZ,time", _questset), {}),
        "its README: x across, y up, z in depth; signs by the gestures of its sample",
    ),
    ("rows of head and hands", _PLAIN, _bodies, {}, None),
    (
        *("HoloLens logger (Unity)", "unity", _csv(_HOLOLENS, _plain), {"axes": "unity"}),
        "Unity manual, Transform: left-handed, y up, z forward",
    ),
    (
        *("UXF tracker (Unity, Euler angles)", "unity", _csv(_RDF, lambda r: [r.s, *r.p, *r.euler()])),
        {"euler": "ZXY,deg", "axes": "unity"},
        "its PositionRotationTracker.cs: Transform.position and eulerAngles of Unity",
    ),
    (
        *("who-is-alyx (OpenVR, centimetres)", _PLAIN, _csv(_ALYX, lambda r: ["11.1", r.s, *_cm(r.p), *r.q], ";")),
        {"scale": 0.01},
        "its Readme: OpenVR, right-handed, y up; z and w change their sign for Unity",
    ),
    (
        *("Unreal logger (centimetres)", "unreal", _csv(f"Time,{_POSE}", lambda r: [r.s, *_cm(r.p), *r.q])),
        *({"axes": "unreal"}, "Unreal Engine documentation, coordinate system and spaces"),
    ),
    (
        *("TUM RGB-D ground truth", "tum-rgbd", _csv(_TUM, _plain, " "), {"axes": "tum-rgbd"}),
        "its page, file formats: optical centre of the colour camera; heights lie along z",
    ),
    ("evo, bare .tum of an OpenXR head", _PLAIN, _csv("", _plain, " "), {}, None),
    (
        *("eight bare columns, w first", _PLAIN, _csv("", lambda r: [r.s, *r.p, *_wxyz(r.q)], " ")),
        *({"quat_order": "wxyz"}, None),
    ),
    (
        *("EuRoC MAV", "euroc", _csv(_ASL, _asl), {"axes": "euroc"}),
        "T_BS of cam0 in its sensor.yaml: the camera's x is the body's y, its y the body's -x",
    ),
    ("TUM-VI", "tum-vi", _csv(_ASL, _asl), {"axes": "tum-vi"}, "T_cam_imu of its camchain.yaml"),
    (
        *("Aria MPS, HOT3D (Aria)", "aria", _aria, {"axes": "aria"}),
        "gravity_z_world of the file; Aria's viewers turn pictures by 90 degrees to be upright",
    ),
    (
        *("HOT3D (Quest 3), turned device", "hot3d-quest3", _csv(_QUEST3, lambda r: [r.ns, *r.p, *_wxyz(r.q)])),
        {"axes": "hot3d-quest3"},
        "its camera_models.json (optical axes along +x) and viewer (world y up)",
    ),
    (
        *("ARKit, 4x4 matrices", "arkit", _csv("", lambda r: [r.s, *_matrix_4x4(r)], " "), {}),
        "ARKit documentation, WorldAlignment.gravity: (0, -1, 0) is down, (0, 0, -1) ahead",
    ),
    (
        *("KITTI odometry, 3x4 matrices", "kitti", _csv("", lambda r: _matrix_4x4(r)[:12], " ")),
        *({"rate": 90.0, "axes": "kitti"}, "its devkit readme: left camera, z forward, rows of the first frame"),
    ),
    (
        *("nerfstudio transforms.json", "nerfstudio", _frames, {"axes": "nerfstudio"}),
        "nerfstudio documentation, data conventions",
    ),
    ("ROS 2 bag as CSV", "ros", _csv(_ROS, _ros), {}, "ROS REP 103"),
)
LAYOUTS = [Layout(*row[:4], "gzip" in row[0], row[4] or "OpenXR 1.1, 2.16") for row in _TABLE]


def written(layout: Layout, truth: PoseTrack, folder: Path) -> Path:
    """Write a file of the layout that holds `truth`."""
    axes: Axes = parse_axes(layout.axes)
    turned = axes.world.T @ Rotation.from_quat(truth.orientation_xyzw).as_matrix() @ axes.head
    quaternions = Rotation.from_matrix(turned).as_quat().tolist()
    places = (truth.position_m @ axes.world).tolist()
    rows = [Row(*row) for row in zip(truth.time_ns.tolist(), places, quaternions, turned.tolist(), strict=True)]
    text = layout.text(rows).encode()
    path = folder / ("head.csv.gz" if layout.packed else "head.csv")
    path.write_bytes(gzip.compress(text) if layout.packed else text)
    return path


def is_truth(loaded: LoadedTrace, truth: PoseTrack) -> bool:
    """Return whether the head is where it was and looks where it looked.

    Files hold every digit of a float64 (2e-16); a matrix, Euler angles in degrees or a change of
    axes cost a few of them, and the angle of a turn near zero has the square root of that, 1e-7.
    Aria's clock is in whole microseconds, so a stamp is off by up to 1000 ns, a difference by twice
    that.
    """
    track = loaded.track
    if len(track) != len(truth):
        return False
    turn = Rotation.from_quat(track.orientation_xyzw).inv() * Rotation.from_quat(truth.orientation_xyzw)
    apart = float(np.abs(track.position_m - truth.position_m).max())
    late = int(np.abs((track.time_ns - truth.time_ns) - (track.time_ns[0] - truth.time_ns[0])).max())
    return apart < 1e-6 and float(turn.magnitude().max()) < 1e-6 and late <= 2000


def verdict(layout: Layout, truth: PoseTrack, folder: Path) -> tuple[str, str]:
    """Return how a file of the layout is read, and the options that a user needs, in words."""
    path = written(layout, truth, folder)
    stated: dict[str, Any] = {}
    outcome = RIGHT
    for _ in range(1 + len(layout.stated)):
        try:
            loaded = load_trace(path, TraceOptions(**stated))
        except HmdwarpError as error:
            said, failed = str(error), REFUSED
        else:
            if is_truth(loaded, truth):
                return outcome, " ".join(f"`{_flag(name)} {value}`" for name, value in stated.items())
            said = " ".join(str(d) for d in loaded.defects if d.kind.endswith(("contradicted", "implausible", "tilt")))
            failed = OPTION
        named = next((name for name in layout.stated if name not in stated and _flag(name) in said), None)
        if named is None and "--axes" in said and "up" in layout.stated:
            named = "up"  # the same by another option
        if named is None:
            return WRONG, ""
        outcome = REFUSED if REFUSED in (outcome, failed) else OPTION
        stated[named] = layout.stated[named]
    return WRONG, ""


def _flag(name: str) -> str:
    return "--trace-rate" if name == "rate" else "--" + name.replace("_", "-")


def layouts_table() -> str:
    """Return the list of docs/traces.md."""
    truth = load_trace("walk").track
    with tempfile.TemporaryDirectory() as folder:
        rows = [(layout, *verdict(layout, truth, Path(folder))) for layout in LAYOUTS]
    return "\n".join(line(*row) for row in rows)


def line(layout: Layout, outcome: str, options: str) -> str:
    return f"- {layout.name} ({layout.proof}): {outcome} {options}".rstrip()


def contradicted_text() -> str:
    """Return what is said of a TUM RGB-D file that is read as it comes, for docs/traces.md."""
    layout = next(layout for layout in LAYOUTS if layout.name.startswith("TUM RGB-D"))
    with tempfile.TemporaryDirectory() as folder:
        loaded = load_trace(written(layout, load_trace("walk").track, Path(folder)))
    said = next(str(defect) for defect in loaded.defects if defect.kind == "axes-contradicted")
    return "\n".join(["```text", *textwrap.wrap(said, 96), "```"])


if __name__ == "__main__":
    print(layouts_table())
