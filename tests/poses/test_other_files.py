"""Files as other people's software writes them, each with a truth computed another way."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.poses import LoadedTrace, PoseTrack, TraceOptions, load_trace, synthesise
from hmdwarp.poses.assumptions import By
from hmdwarp.poses.reading.axes import parse_axes
from hmdwarp.study.export.write import channels_json, channels_text, motion_text

from .traces import found, head, kinds, matrices, refusal, same_motion, write

TRACK = head(120)
TURNS = Rotation.from_quat(TRACK.orientation_xyzw)
SECONDS = TRACK.time_ns / 1e9
EXACT = 1e-9
ROUNDED = 2e-4  # of five decimals in a quaternion, four in a position


def inverse(track: PoseTrack) -> PoseTrack:
    """The same head as head from world."""
    turned = np.linalg.inv(matrices(track))
    return track.evolve(position_m=turned[:, :3, 3], orientation_xyzw=Rotation.from_matrix(turned[:, :3, :3]).as_quat())


def by(loaded: LoadedTrace, what: str) -> By:
    """Who says a fact."""
    return next(assumption.by for assumption in loaded.assumptions if assumption.what == what)


def value(loaded: LoadedTrace, what: str) -> str:
    """What a fact was taken as."""
    return next(assumption.value for assumption in loaded.assumptions if assumption.what == what)


def fields(*columns: np.ndarray) -> list[list[str]]:
    """Rows of numbers with every digit, side by side."""
    return [list(map(repr, row)) for row in np.column_stack(columns).tolist()]


def lined(path: Path, lines: list[str], end: str = "\n") -> Path:
    """A file of these lines."""
    path.write_bytes(end.join([*lines, ""]).encode())
    return path


def in_axes(track: PoseTrack, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Positions and quaternions of a track in a file's axes."""
    axes = parse_axes(name)
    turned = axes.world.T @ Rotation.from_quat(track.orientation_xyzw).as_matrix() @ axes.head
    return track.position_m @ axes.world, Rotation.from_matrix(turned).as_quat()


# Matrices


@pytest.mark.parametrize("order", ["rows", "columns"])
@pytest.mark.parametrize(
    "form", ["bare", "among others", "m00", "M11", "m[0][0]", "flat names", "nested", "flat", "typed array", "cell"]
)
def test_the_place_of_0_0_0_1_says_rows_or_columns(tmp_path, form, order):
    """Column-major as WebXR, three.js, glm, ARKit and .NET write them."""
    turned = matrices(TRACK) if order == "rows" else matrices(TRACK).transpose(0, 2, 1)
    flat = turned.reshape(-1, 16).tolist()
    times = SECONDS.tolist()
    if form in ("nested", "flat", "typed array"):
        shapes = {"nested": turned.tolist(), "flat": flat}
        shown = shapes.get(form) or [{str(i): v for i, v in enumerate(m)} for m in flat]
        path = tmp_path / "m.json"
        path.write_text(json.dumps([{"time": t, "matrix": m} for t, m in zip(times, shown, strict=True)]))
    else:
        cells = [(r, c) for r in range(4) for c in range(4)]
        names = {
            "m00": "time," + ",".join(f"m{r}{c}" for r, c in cells),
            "M11": "time," + ",".join(f"M{r + 1}{c + 1}" for r, c in cells),
            "m[0][0]": "time," + ",".join(f"m[{r}][{c}]" for r, c in cells),
            "flat names": "time," + ",".join(f"elements{i}" for i in range(16)),
            "cell": "time,matrix",
        }.get(form, "")
        table = [[repr(t), *map(repr, m)] for t, m in zip(times, flat, strict=True)]
        if form == "among others":
            table = [[str(i), *row, "90.5", "1"] for i, row in enumerate(table)]
        if form == "cell":
            table = [[row[0], f'"[{", ".join(row[1:])}]"'] for row in table]
        path = write(tmp_path / "m.csv", table, header=names)
    loaded = load_trace(path)
    assert same_motion(loaded.track, TRACK, atol=1e-6)
    assert by(loaded, "orientation") is By.FILE and value(loaded, "orientation").startswith(f"matrix by {order}")


def test_a_4x3_matrix_by_columns_is_told_from_a_3x4_by_rows(tmp_path):
    columns = matrices(TRACK)[:, :3].transpose(0, 2, 1).reshape(-1, 12).tolist()
    table = [[repr(t), *map(repr, m)] for t, m in zip(SECONDS.tolist(), columns, strict=True)]
    loaded = load_trace(write(tmp_path / "m.txt", table, header="", separator=" "))
    assert same_motion(loaded.track, TRACK, atol=1e-6)
    assert value(loaded, "orientation") == "matrix by columns (4x3)"


def test_nine_numbers_are_by_rows_unless_the_motion_shows_columns(tmp_path):
    walk = load_trace("walk").track
    turns = Rotation.from_quat(walk.orientation_xyzw).as_matrix()
    names = "time,x,y,z," + ",".join(f"r{r}{c}" for r in range(3) for c in range(3))
    for order, numbers in (("rows", turns), ("columns", turns.transpose(0, 2, 1))):
        table = fields(walk.time_ns / 1e9, walk.position_m, numbers.reshape(-1, 9))
        path = write(tmp_path / "r.csv", table, names)
        loaded = load_trace(path, TraceOptions(matrix=order))
        assert by(loaded, "orientation") is By.USER
        assert np.abs(loaded.track.position_m - walk.position_m).max() < EXACT
        assert np.abs(Rotation.from_quat(loaded.track.orientation_xyzw).as_matrix() - turns).max() < 1e-6
        if order == "rows":
            assert by(load_trace(path), "orientation") is By.DEFAULT
        else:
            assert "--matrix columns" in refusal(path)


def test_stated_columns_name_a_matrix(tmp_path):
    nines = np.full(len(TRACK), 9)
    table = fields(nines, SECONDS, matrices(TRACK).reshape(-1, 16), nines)
    path = write(tmp_path / "m.csv", table, header=",".join(f"c{'abcdefghijklmnopqrs'[i]}" for i in range(19)))
    assert same_motion(load_trace(path, TraceOptions(columns="t=2,m=3-18")).track, TRACK, atol=1e-6)
    assert "are no rotations" in refusal(path, columns="t=2,m=2-17")


# The direction of poses


@pytest.mark.parametrize("name", ["walk", "look-around", "reversals", "fast-turns"])
def test_poses_the_other_way_round_are_suggested_by_the_motion_and_read_on_request(tmp_path, name):
    truth = load_trace(name).track
    turned = inverse(truth)
    table = fields(turned.time_ns / 1e9, turned.position_m, turned.orientation_xyzw)
    path = write(tmp_path / "i.csv", table)
    loaded = load_trace(path)
    assert any("--pose inverse" in str(d) for d in loaded.defects if d.kind == "pose-contradicted")
    assert "contradicts" in loaded.axes and by(loaded, "pose") is By.DEFAULT
    right = load_trace(path, TraceOptions(pose="inverse"))
    assert same_motion(right.track.evolve(time_ns=truth.time_ns), truth, atol=1e-6)
    assert "pose-contradicted" not in kinds(right) and by(right, "pose") is By.USER
    assert "pose-contradicted" not in kinds(load_trace(name))


WAYS = {
    **dict.fromkeys(("c2w", "T_world_cam", "matrixWorld"), "direct"),
    **dict.fromkeys(
        ("w2c", "T_head_world", "worldToCamera", "extrinsic", "viewMatrix", "matrixWorldInverse"), "inverse"
    ),
    **dict.fromkeys(("pose", "HeadWorldMatrix"), None),
}


@pytest.mark.parametrize(("name", "way"), WAYS.items())
def test_names_of_poses_say_which_way_they_go(tmp_path, name, way):
    turned = np.linalg.inv(matrices(TRACK)) if way == "inverse" else matrices(TRACK)
    path = tmp_path / "m.json"
    path.write_text(json.dumps([{"t": t, name: m} for t, m in zip(SECONDS.tolist(), turned.tolist(), strict=True)]))
    loaded = load_trace(path)
    assert by(loaded, "pose") is (By.FILE if way else By.DEFAULT)
    assert same_motion(loaded.track, TRACK, atol=1e-6)


def test_of_several_matrices_the_one_of_the_pose_is_read(tmp_path):
    """A camera of three.js, by columns: its view and its projection are no poses."""
    names = {
        "viewMatrix": np.linalg.inv(matrices(TRACK)),
        "projectionMatrix": np.tile(np.eye(4), (120, 1, 1)),
        "matrix": matrices(TRACK),
    }
    flat = {name: m.transpose(0, 2, 1).reshape(-1, 16).tolist() for name, m in names.items()}
    path = tmp_path / "m.json"
    path.write_text(json.dumps([{"t": t} | {n: m[i] for n, m in flat.items()} for i, t in enumerate(SECONDS.tolist())]))
    assert same_motion(load_trace(path).track, TRACK, atol=1e-6)


# JSON


def iwer_frames(track: PoseTrack) -> list[list]:
    """Frames as ActionRecorder.compressActionFrame of IWER has them."""
    rows = zip((track.time_ns / 1e6 + 1234.5).tolist(), track.position_m, track.orientation_xyzw, strict=True)
    ray = [0, 0.158, 1.215, -0.409, 0, 0, 0, 1, [0, 0, 0, 0, 0, 0, 1], [[0, 0, 0], None, 0]]
    return [[round(t, 1), *p.round(3).tolist(), *q.round(3).tolist(), *([ray] if t > 1300 else [])] for t, p, q in rows]


def test_iwer_recordings_begin_with_their_first_frame(tmp_path):
    schema = [[0, {"handedness": "right", "targetRayMode": "tracked-pointer", "profiles": ["a"], "hasGrip": True}]]
    path = tmp_path / "iwer.json"
    path.write_text(json.dumps({"schema": schema, "frames": iwer_frames(TRACK)}))
    loaded = load_trace(path)
    assert loaded.format == "iwer" and len(loaded.track) == len(TRACK)
    assert loaded.track.epoch_ns == 1_234_500_000 and by(loaded, "axes") is By.FORMAT
    assert np.abs(loaded.track.position_m - TRACK.position_m).max() <= 0.0005 + EXACT


def records() -> list[dict]:
    """A record for each pose."""
    return [
        {"t": t, "pos": p, "rot": dict(zip("xyzw", q, strict=True))}
        for t, p, q in zip(SECONDS.tolist(), TRACK.position_m.tolist(), TRACK.orientation_xyzw.tolist(), strict=True)
    ]


FLAT = np.column_stack([SECONDS, TRACK.position_m, TRACK.orientation_xyzw]).tolist()
NAMES = ["t", "x", "y", "z", "qx", "qy", "qz", "qw"]
JSON_FORMS = {
    "plain": records(),
    "in a document": {"poses": records()},
    "header first": [{"version": 2, "device": "Quest 3", "started": "2026-11-26"}, *records()],
    "names first": [NAMES, *FLAT],
    "columns and data": {"columns": NAMES, "index": list(range(len(FLAT))), "data": FLAT},
    "table schema": {
        "schema": {"fields": [{"name": name, "type": "number"} for name in NAMES]},
        "data": [dict(zip(NAMES, row, strict=True)) for row in FLAT],
    },
    "a list for each column": {"device": "Quest", **{n: [r[i] for r in FLAT] for i, n in enumerate(NAMES)}},
    "columns of vectors": {
        "time": [row[0] for row in FLAT],
        "position": [row[1:4] for row in FLAT],
        "rotation": [dict(zip("xyzw", row[4:], strict=True)) for row in FLAT],
    },
    "events between": [
        record for i, r in enumerate(records()) for record in ([{"event": "click"}, r] if i % 7 == 3 else [r])
    ],
    "names under schema": {"schema": NAMES, "frames": FLAT},
    "one recording in a list": [{"name": "take 1", "samples": records()}],
}


@pytest.mark.parametrize("lines", [False, True])
@pytest.mark.parametrize("form", JSON_FORMS)
def test_json_with_entries_that_are_no_poses(tmp_path, form, lines):
    document = JSON_FORMS[form]
    if lines and not (isinstance(document, list) and len(document) > 1):
        pytest.skip("no form of JSON lines")
    path = tmp_path / "r.json"
    path.write_text("\n".join(map(json.dumps, document)) if lines else json.dumps(document))
    loaded = load_trace(path)
    assert same_motion(loaded.track, TRACK, atol=EXACT)
    assert ("record-of-another-kind" in kinds(loaded)) == (form in ("header first", "events between"))


# Several numbers in a cell


def vector_rows(
    position: str, rotation: str, separator: str = ",", header: str = "Time,HeadPosition,HeadRotation"
) -> str:
    """A table whose cells are made by two format strings."""
    rows = [
        separator.join((f"{t:.6f}", position.format(*p), rotation.format(*q)))
        for t, p, q in zip(SECONDS.tolist(), TRACK.position_m.tolist(), TRACK.orientation_xyzw.tolist(), strict=True)
    ]
    return "\n".join([*([header.replace(",", separator)] if header else []), *rows, ""])


VECTORS = {
    "Unity in quotes": vector_rows('"({:.4f}, {:.4f}, {:.4f})"', '"({:.5f}, {:.5f}, {:.5f}, {:.5f})"'),
    "Unity without quotes": vector_rows("({:.4f}, {:.4f}, {:.4f})", "({:.5f}, {:.5f}, {:.5f}, {:.5f})"),
    "NumPy": vector_rows("[{:.4f} {:.4f} {:.4f}]", "[{:.5f} {:.5f} {:.5f} {:.5f}]"),
    "Python lists in quotes": vector_rows('"[{:.4f}, {:.4f}, {:.4f}]"', '"[{:.5f}, {:.5f}, {:.5f}, {:.5f}]"'),
    "semicolons around commas": vector_rows("{:.4f},{:.4f},{:.4f}", "{:.5f},{:.5f},{:.5f},{:.5f}", ";"),
    "tabs around blanks in brackets": vector_rows("({:.4f} {:.4f} {:.4f})", "({:.5f} {:.5f} {:.5f} {:.5f})", "\t"),
    "type names": vector_rows("Vector3({:.4f}, {:.4f}, {:.4f})", "Quaternion(x={:.5f}, y={:.5f}, z={:.5f}, w={:.5f})"),
    "JSON in quotes": vector_rows(
        '"{{x: {:.4f}, y: {:.4f}, z: {:.4f}}}"', '"{{x: {:.5f}, y: {:.5f}, z: {:.5f}, w: {:.5f}}}"'
    ),
    "decimal commas": vector_rows("({:.4f}; {:.4f}; {:.4f})", "({:.5f}; {:.5f}; {:.5f}; {:.5f})", "\t")
    .replace(".", ",")
    .replace(";", ","),
    "no header": vector_rows("({:.4f}, {:.4f}, {:.4f})", "({:.5f}, {:.5f}, {:.5f}, {:.5f})", header=""),
    "letters in the header": vector_rows(
        '"({:.4f}, {:.4f}, {:.4f})"',
        '"({3:.5f}, {0:.5f}, {1:.5f}, {2:.5f})"',
        header='Time,"Head Position (x, y, z)","Head Rotation (w, x, y, z)"',
    ),
}


@pytest.mark.parametrize("form", VECTORS)
def test_several_numbers_in_a_cell(tmp_path, form):
    path = tmp_path / "v.csv"
    path.write_text(VECTORS[form])
    loaded = load_trace(path)
    assert loaded.format == "vectors"
    assert same_motion(loaded.track.evolve(time_ns=TRACK.time_ns), TRACK, atol=ROUNDED)
    named = form in ("type names", "JSON in quotes", "letters in the header")
    assert by(loaded, "orientation") is (By.FILE if named else By.DEFAULT)
    assert by(loaded, "columns") is (By.DEFAULT if form == "no header" else By.FILE)


def unreal_rotator(q: np.ndarray) -> tuple[float, float, float]:
    """Pitch, yaw, roll in degrees as FQuat::Rotator of Unreal Engine computes them."""
    x, y, z, w = q
    yaw = np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    pitch = np.degrees(np.arcsin(2 * (z * x - w * y)))
    roll = np.degrees(np.arctan2(-2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))
    return float(pitch), float(yaw), float(roll)


def unreal(form: str = "quaternion") -> list[str]:
    """Lines with ToString of FVector, FQuat and FRotator: centimetres, left-handed, z up."""
    places, turns = in_axes(TRACK, "unreal")
    rows = ["Time,Location,Rotation"]
    for t, p, q in zip(SECONDS.tolist(), 100 * places, turns, strict=True):
        turn = "X={:.9f} Y={:.9f} Z={:.9f} W={:.9f}".format(*q)
        if form == "rotator":
            turn = "P={:.6f} Y={:.6f} R={:.6f}".format(*unreal_rotator(q))
        place = "X={:.3f} Y={:.3f} Z={:.3f}".format(*p)
        if form == "exported":  # as ExportText and its configuration files have it
            place = f'"({place.replace(" ", ",")})"'
            turn = '"(Pitch={:.6f},Yaw={:.6f},Roll={:.6f})"'.format(*unreal_rotator(q))
        rows.append(f"{t:.6f},{place},{turn}")
    return rows


@pytest.mark.parametrize("form", ["quaternion", "rotator", "exported"])
def test_unreals_strings(tmp_path, form):
    loaded = load_trace(lined(tmp_path / "u.csv", unreal(form)))
    assert loaded.format == "unreal" and by(loaded, "axes") is By.FORMAT
    assert same_motion(loaded.track.evolve(time_ns=TRACK.time_ns), TRACK, atol=1e-5)


# Rotation vectors


@pytest.mark.parametrize(
    ("names", "unit"),
    [
        ("time,tvec_x,tvec_y,tvec_z,rvec_x,rvec_y,rvec_z", None),
        ("time,x,y,z,rvec_0,rvec_1,rvec_2", None),
        ("time,x,y,z,rotation_vector_x,rotation_vector_y,rotation_vector_z", None),
        ("time,x,y,z,rotvec_x [deg],rotvec_y [deg],rotvec_z [deg]", "deg"),
        ("time,x,y,z,axis_angle_x [rad],axis_angle_y [rad],axis_angle_z [rad]", "rad"),
    ],
)
def test_rotation_vectors(tmp_path, names, unit):
    vectors = TURNS.as_rotvec(degrees=unit == "deg")
    table = fields(SECONDS, TRACK.position_m, vectors)
    loaded = load_trace(write(tmp_path / "v.csv", table, names))
    assert same_motion(loaded.track, TRACK, atol=1e-6)
    assert by(loaded, "orientation") is (By.FILE if unit else By.DEFAULT)


def test_an_axis_beside_its_angle(tmp_path):
    vectors = TURNS.as_rotvec()
    angles = np.linalg.norm(vectors, axis=1)
    rows = fields(SECONDS, TRACK.position_m, vectors / angles[:, None], angles)
    path = write(tmp_path / "a.csv", rows, "time,px,py,pz,axis_x,axis_y,axis_z,angle")
    assert same_motion(load_trace(path).track, TRACK, atol=1e-6)
    stated = TraceOptions(columns="t=1,p=2+3+4,a=5+6+7+8")
    assert same_motion(load_trace(path, stated).track, TRACK, atol=1e-6)


def test_three_bare_angles_may_be_a_vector_where_the_user_says_so(tmp_path):
    table = fields(SECONDS, TRACK.position_m, TURNS.as_rotvec())
    bare = write(tmp_path / "b.csv", table, "time,x,y,z,rx,ry,rz")
    assert "vector,rad" in refusal(bare)
    assert same_motion(load_trace(bare, TraceOptions(euler="vector,rad")).track, TRACK, atol=1e-6)
    path = write(tmp_path / "v.csv", table, "time,x,y,z,rot_x,rot_y,rot_z")
    assert "vector,rad" in refusal(path)
    for stated in (TraceOptions(euler="vector,rad"), TraceOptions(columns="t=1,p=2+3+4,r=5+6+7")):
        assert same_motion(load_trace(path, stated).track, TRACK, atol=1e-6)


# Motion capture


def motive(lost: int = -1) -> list[str]:
    """Lines of an export as OptiTrack's Data Export: CSV has it, and the data of pathviewr."""
    about = "Format Version,1.23,Take Name,take,Take Notes,,Capture Frame Rate,60.000000,Export Frame Rate,60.000000,"
    about += "Capture Start Time,2019-09-18 04.30.02.695 PM,Total Frames in Take,120,Total Exported Frames,120,"
    about += "Rotation Type,Quaternion,Length Units,Millimeters,Coordinate Space,Global"
    parts = ["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"]
    bodies = ["wand", "HMD"]
    lines = [
        about,
        "",
        ",Type," + ",".join(["Rigid Body"] * 16 + ["Rigid Body Marker"] * 3),
        ",Name," + ",".join([b for b in bodies for _ in range(8)] + ["HMD:Marker1"] * 3),
        ",ID," + ",".join([f'"{b}9E20"' for b in bodies for _ in range(8)] + ['"1"'] * 3),
        ",," + ",".join(parts * 2 + ["Position"] * 3),
        "Frame,Time (Seconds)," + ",".join([*"XYZWXYZ", ""] * 2 + [*"XYZ"]),
    ]
    for i, (t, p, q) in enumerate(zip(SECONDS.tolist(), TRACK.position_m, TRACK.orientation_xyzw, strict=True)):
        hmd = [*map(repr, [*q.tolist(), *(1000 * p).tolist()]), "0.1"] if i != lost else [""] * 8
        lines.append(",".join([str(i), repr(t), *"0001", *"123", "0.1", *hmd, *"123"]))
    return lines


def test_motive_exports(tmp_path):
    lines = motive(lost=50)
    path = lined(tmp_path / "take.csv", lines)
    loaded = load_trace(path)
    assert (loaded.format, loaded.device, len(loaded.track)) == ("motive", "HMD", len(TRACK) - 1)
    kept = np.arange(len(TRACK)) != 50
    assert np.abs(loaded.track.position_m - TRACK.position_m[kept]).max() < EXACT
    assert by(loaded, "length") is By.FILE and by(loaded, "axes") is By.DEFAULT
    assert "wand" in str(found(loaded, "devices-interleaved"))
    path.write_text("\n".join(lines[:2] + [line.replace("Rigid Body", "Marker") for line in lines[2:]]))
    assert "without rigid bodies" in refusal(path)


def qualisys(clocked: bool = True) -> list[str]:
    """Lines of an export as QTM's manual has it under 6DOF data (.tsv): mm, Rot[] by columns."""
    keys = ["NO_OF_FRAMES\t120", "NO_OF_CAMERAS\t8", "NO_OF_BODIES\t2", "FREQUENCY\t60", "NO_OF_ANALOG\t0"]
    keys += ["ANALOG_FREQUENCY\t0", "DESCRIPTION\t--", "TIME_STAMP\t2020-01-22, 17:47:17\t22107.99179716"]
    keys += ["DATA_INCLUDED\t6D", "BODY_NAMES\tKnife\tHead"]
    each = "X\tY\tZ\tRoll\tPitch\tYaw\tResidual\t" + "\t".join(f"Rot[{i}]" for i in range(9))
    first = "Frame\tTime\t" if clocked else ""
    lines = [*keys, f"{first}Knife {each}\tHead {each}\t"]
    for i, (t, m) in enumerate(zip(SECONDS.tolist(), matrices(TRACK), strict=True)):
        numbers = [*(1000 * m[:3, 3]).tolist(), 1.0, 2.0, 3.0, 0.5, *m[:3, :3].T.ravel().tolist()]
        clock = [str(i + 1), f"{t:.5f}"] if clocked else []
        lines.append("\t".join([*clock, *["1.0"] * 7, *"100010001", *map(repr, numbers), ""]))
    return lines


def test_qualisys_exports(tmp_path):
    for lines in (qualisys(), qualisys(clocked=False), qualisys()[10:]):  # the last without lines of key words
        loaded = load_trace(lined(tmp_path / "head_6D.tsv", lines, "\r\n"))
        assert (loaded.format, loaded.device) == ("qualisys", "Head")
        assert np.abs(loaded.track.position_m - TRACK.position_m).max() < EXACT
        turn = Rotation.from_quat(loaded.track.orientation_xyzw).inv() * TURNS
        assert turn.magnitude().max() < 1e-6
        assert abs(loaded.track.duration_ns - TRACK.duration_ns) < 20_000
        assert by(loaded, "orientation") is By.FORMAT and by(loaded, "length") is By.FORMAT


def bids(folder: Path, channels: list[tuple[str, ...]], rows: np.ndarray, frame: dict | None = None, **about) -> Path:
    """The files of BIDS "Motion" for one tracking system."""
    stem = str(folder / "sub-01_task-walk_tracksys-hmd")
    text = ["\t".join(("name", "component", "type", "tracked_point", "units", "reference_frame"))]
    Path(f"{stem}_channels.tsv").write_text("\n".join([*text, *map("\t".join, channels), ""]))
    Path(f"{stem}_motion.json").write_text(json.dumps({"SamplingFrequency": 60, **about}))
    if frame is not None:
        Path(f"{stem}_channels.json").write_text(json.dumps({"reference_frame": {"Levels": {"global": frame}}}))
    path = Path(f"{stem}_motion.tsv")
    path.write_text("\n".join("\t".join(map(repr, row)) for row in rows.tolist()) + "\n")
    return path


def test_bids_motion_with_quaternions_in_unitys_axes(tmp_path):
    places, turns = in_axes(TRACK, "unity")
    channels = [(f"h_{p}", p, "ORNT", "head", "n/a", "global") for p in ("quat_w", "quat_x", "quat_y", "quat_z")]
    channels += [(f"hand_{p}", p, "POS", "hand", "m", "global") for p in "xyz"]
    channels += [(f"h_{p}", p, "POS", "head", "mm", "global") for p in "xyz"]
    rows = np.column_stack([turns[:, [3, 0, 1, 2]], places * 0, 1000 * places])
    frame = {"SpatialAxes": "RSA", "RotationRule": "left-hand"}
    path = bids(tmp_path, channels, rows, frame)
    loaded = load_trace(path)
    assert loaded.format == "bids"
    assert same_motion(loaded.track.evolve(time_ns=TRACK.time_ns), TRACK, atol=1e-6)
    assert by(loaded, "axes") is By.FILE and by(loaded, "length") is By.FILE and by(loaded, "clock") is By.FORMAT
    (tmp_path / "sub-01_task-walk_tracksys-hmd_channels.tsv").unlink()
    assert "channels.tsv, which is not beside it" in refusal(path)


@pytest.mark.parametrize("rule", ["right-hand", "left-hand"])
def test_bids_motion_with_angles_and_latency(tmp_path, rule):
    """Axes ALS: x ahead, y left, z up, as ROS; a left-hand rule turns against them."""
    places, turns = in_axes(TRACK, "ros")
    sign = -1 if rule == "left-hand" else 1
    angles = sign * Rotation.from_quat(turns).as_euler("zxy", degrees=True)[:, [1, 2, 0]]
    channels = [("t", "n/a", "LATENCY", "n/a", "s", "n/a")]
    channels += [(f"p{a}", a, "POS", "head", "m", "global") for a in "xyz"]
    channels += [(f"r{a}", a, "ORNT", "head", "deg", "global") for a in "xyz"]
    frame = {"SpatialAxes": "ALS", "RotationOrder": "ZXY", "RotationRule": rule}
    loaded = load_trace(bids(tmp_path, channels, np.column_stack([SECONDS, places, angles]), frame))
    assert same_motion(loaded.track, TRACK, atol=1e-6)
    assert by(loaded, "orientation") is By.FILE


def test_our_own_bids_export_comes_back(tmp_path):
    stem = str(tmp_path / "sub-a_tracksys-hmd")
    Path(f"{stem}_motion.tsv").write_text(motion_text(TRACK))
    Path(f"{stem}_channels.tsv").write_text(channels_text())
    Path(f"{stem}_channels.json").write_text(json.dumps(channels_json()))
    back = load_trace(f"{stem}_motion.tsv")
    assert same_motion(back.track.evolve(time_ns=TRACK.time_ns), TRACK, atol=EXACT)


# Clocks


def stamped(folder: Path, stamps: list, name: str = "time", track: PoseTrack = TRACK) -> Path:
    rows = zip(stamps, track.position_m.tolist(), track.orientation_xyzw.tolist(), strict=True)
    table = [[s if isinstance(s, str) else repr(s), *map(repr, [*p, *q])] for s, p, q in rows]
    return write(folder / "c.csv", table, f"{name},x,y,z,qx,qy,qz,qw")


@pytest.mark.parametrize(
    ("bits", "step_ns", "name", "low"),
    [
        *((32, step, name, 0) for name, step in (("time_ms", 10**6), ("time_us", 10**3), ("time_ns", 1))),
        *((32, step, name, -(2**31)) for name, step in (("time_ms", 10**6), ("time_us", 10**3), ("time_ns", 1))),
        *((33, 1000, "time", 0), (30, 1000, "time", 0), (24, 1000, "time", 0), (24, 10**6, "time", 0)),
        (16, 10**6, "time", 0),
    ],
)
def test_clocks_of_few_bits_are_counted_on(tmp_path, bits, step_ns, name, low):
    long = head(600)
    ticks = (long.time_ns // step_ns - 10**9 // step_ns) % 2**bits + low  # a second before the wrap at first
    loaded = load_trace(stamped(tmp_path, ticks.tolist(), name, long))
    assert len(loaded.track) == 600 and len(loaded.segments) == 1
    assert abs(loaded.track.duration_ns - long.duration_ns) <= step_ns
    assert "clock-wrap" in kinds(loaded) and by(loaded, "clock wrap") is By.DEFAULT


def test_a_32_bit_clock_of_microseconds_written_as_seconds(tmp_path):
    ticks = (TRACK.time_ns // 1000 + 2**32 - 10**6) % 2**32
    loaded = load_trace(stamped(tmp_path, [f"{t // 10**6}.{t % 10**6:06d}" for t in ticks.tolist()], "time_s"))
    assert len(loaded.track) == len(TRACK) and abs(loaded.track.duration_ns - TRACK.duration_ns) <= 2000


def test_key_frames_with_unix_time_are_seconds(tmp_path):
    """A map has one a second; in milliseconds they would make a thousand a second."""
    stamps = [f"{1_700_000_000 + 1.35 * i:.6f}" for i in range(len(TRACK))]
    loaded = load_trace(stamped(tmp_path, stamps))
    assert loaded.track.duration_ns == pytest.approx(1.35e9 * (len(TRACK) - 1), rel=1e-6)


def test_a_restart_is_no_wrap(tmp_path):
    """The head is elsewhere in the second recording."""
    ticks = [*(2**31 + TRACK.time_ns[:70] // 1000).tolist(), *(TRACK.time_ns[70:] // 1000).tolist()]
    other = np.r_[:70, :50]
    track = TRACK.evolve(position_m=TRACK.position_m[other], orientation_xyzw=TRACK.orientation_xyzw[other])
    loaded = load_trace(stamped(tmp_path, ticks, "time_us", track))
    assert "clock-wrap" not in kinds(loaded) and len(loaded.segments) == 2


@pytest.mark.parametrize("stamp", ["1000000000.0", "0.0", "-5.0", "99999999999"])
@pytest.mark.parametrize("at", [0, 1, 30, 59])
def test_one_absurd_stamp_is_dropped(tmp_path, stamp, at):
    short = head(60)
    stamps = [f"{t / 1e9 + 100:.6f}" for t in short.time_ns.tolist()]
    stamps[at] = stamp
    loaded = load_trace(stamped(tmp_path, stamps, "time_s", short))
    assert len(loaded.track) == 59
    assert loaded.track.duration_ns <= short.duration_ns + 1000
    told = {"stamp-absurd", "clock-restart", "last-row-cut"} & kinds(loaded)
    assert told, "the row is gone without a word"


# Upright


def test_auto_turns_a_tilted_world_upright_as_up_advises(tmp_path):
    truth = load_trace("look-around").track
    tilt = Rotation.from_euler("xz", [50, 35], degrees=True)
    turned = truth.evolve(
        position_m=tilt.apply(truth.position_m.copy()),
        orientation_xyzw=(tilt * Rotation.from_quat(truth.orientation_xyzw)).as_quat(),
    )
    path = stamped(tmp_path, (turned.time_ns / 1e9).tolist(), "time_s", turned)
    advised = next(str(d) for d in load_trace(path).defects if d.kind == "tilt")
    assert "--up=" in advised
    loaded = load_trace(path, TraceOptions(axes="auto"))
    assert "tilt-set" in kinds(loaded) and by(loaded, "up") is By.MOTION
    crown = Rotation.from_quat(loaded.track.orientation_xyzw).apply([0, 1, 0])
    true = Rotation.from_quat(truth.orientation_xyzw).apply([0, 1, 0])
    # What is left is less than what is worth a note.
    assert np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", crown, true), -1, 1))).max() < 10


def test_gravity_columns_set_a_tilted_world_upright(tmp_path):
    truth = load_trace("look-around").track
    tilt = Rotation.from_euler("xz", [20, -25], degrees=True)
    down = tilt.apply([0, -9.81, 0])
    names = "time_s,x,y,z,qx,qy,qz,qw,gravity_x_world,gravity_y_world,gravity_z_world"
    quaternions = (tilt * Rotation.from_quat(truth.orientation_xyzw)).as_quat()
    places, gravity = tilt.apply(truth.position_m.copy()), np.tile(down, (len(truth), 1))
    path = write(tmp_path / "g.csv", fields(truth.time_ns / 1e9, places, quaternions, gravity), names)
    loaded = load_trace(path, TraceOptions(axes="auto"))
    assert by(loaded, "up") is By.FILE
    height = loaded.track.position_m[:, 1]
    assert np.abs(height - truth.position_m[:, 1]).max() < EXACT


@pytest.mark.parametrize("gravity", [True, False])
@pytest.mark.parametrize("name", ["aria", "tum-rgbd", "ros", "unreal"])
def test_auto_sets_a_head_upright_though_its_gaze_is_unclear(tmp_path, name, gravity):
    """A person who stands still: 92 degrees on its side, where the file has gravity columns."""
    truth = synthesise("still")
    places, turns = in_axes(truth, name)
    down = np.tile(parse_axes(name).world.T @ [0, -9.81, 0], (len(truth), 1))
    names = "time_s,x,y,z,qx,qy,qz,qw,gravity_x_world,gravity_y_world,gravity_z_world"
    columns = [truth.time_ns / 1e9, places, turns, down][: None if gravity else 3]
    path = write(tmp_path / "g.csv", fields(*columns), ",".join(names.split(",")[: 11 if gravity else 8]))
    loaded = load_trace(path, TraceOptions(axes="auto"))
    crown = Rotation.from_quat(loaded.track.orientation_xyzw).apply([0, 1, 0])
    assert crown[:, 1].min() > 0.9
    undecided = not gravity and name in ("ros", "unreal")  # world and head alike stand on another axis
    assert ("--axes or --up states it" if undecided else "which way it looks is not clear") in loaded.axes


def test_a_file_that_shows_nothing_names_an_option_that_helps(tmp_path):
    still = TRACK.evolve(orientation_xyzw=np.tile([0, 0, 0, 1.0], (len(TRACK), 1)))
    loaded = load_trace(stamped(tmp_path, SECONDS.tolist(), "time_s", still), TraceOptions(axes="auto"))
    assert "--axes or --up states it" in loaded.axes
