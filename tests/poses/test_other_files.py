"""Files as other people's software writes them: `files/` holds one pose track, `head`, in each.

`files.toml` tells what some need, `files.txt` how each was read. After an intended change
look at what differs, then write it:

    HMDWARP_GOLDEN=write .venv/bin/python -m pytest tests/poses/test_other_files.py
"""

from __future__ import annotations

import json
import os
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.poses import LoadedTrace, PoseTrack, TraceOptions, load_trace
from hmdwarp.poses.assumptions import By
from hmdwarp.study.export.write import channels_json, channels_text, motion_text

from .traces import head, kinds, matrices, refusal, same_motion, write

FILES = Path(__file__).parent / "files"
GOLDEN = FILES.with_suffix(".txt")
STATED = tomllib.loads(FILES.with_suffix(".toml").read_text(encoding="utf-8"))
NAMES = sorted(
    path.relative_to(FILES).as_posix()
    for path in FILES.rglob("*")
    if path.is_file() and (path.parent == FILES or path.stem.endswith("_motion") and path.suffix == ".tsv")
)
TRACK = head(120)
TURNS = Rotation.from_quat(TRACK.orientation_xyzw)
SECONDS = TRACK.time_ns / 1e9
EXACT = 1e-9


def by(loaded: LoadedTrace, what: str) -> By:
    """Who says a fact."""
    return next(assumption.by for assumption in loaded.assumptions if assumption.what == what)


def fields(*columns: np.ndarray) -> list[list[str]]:
    """Rows of numbers with every digit, side by side."""
    return [list(map(repr, row)) for row in np.column_stack(columns).tolist()]


def told(name: str, loaded: LoadedTrace) -> str:
    """How a file was read, in words."""
    about = [f"format: {loaded.format}", *([f"device: {loaded.device}"] if loaded.device else [])]
    about += [f"clock: {loaded.time_unit} from {loaded.track.epoch_ns}", *map(str, loaded.assumptions)]
    defects = (f"defect: {defect}".replace("\0", "NUL") for defect in loaded.defects)
    return "\n".join([f"# {name}", *about, *defects, ""])


@pytest.mark.parametrize("name", NAMES)
def test_a_file_is_read_right_and_as_it_was(name):
    """All hold poses of one track, rounded as their software rounds."""
    stated = dict(STATED.get(name, {}))
    if said := stated.pop("refused", None):
        assert said in refusal(FILES / name)
    count, late_ns, lost = stated.pop("count", 16), stated.pop("late_ns", 50_000), stated.pop("lost", [])
    loaded, wanted = load_trace(FILES / name, TraceOptions(**stated)), head(count)
    kept = np.delete(np.arange(count), lost)
    turn = Rotation.from_quat(loaded.track.orientation_xyzw).inv() * Rotation.from_quat(wanted.orientation_xyzw[kept])
    # IWER has three decimals, so has our own page; Unity's strings five; clocks of both 0.1 ms.
    turned, moved = (2e-3, 6e-4) if loaded.format in ("iwer", "browser") else (1e-4, 1e-4)
    assert turn.magnitude().max() < turned
    if "no-position" not in kinds(loaded):
        assert np.abs(loaded.track.position_m - wanted.position_m[kept]).max() < moved
    late = loaded.track.time_ns - (wanted.time_ns[kept] - wanted.time_ns[kept][0])
    assert np.abs(late).max() <= late_ns
    text = told(name, loaded)
    if os.environ.get("HMDWARP_GOLDEN") == "write":
        before = GOLDEN.read_text(encoding="utf-8") if name != NAMES[0] else ""
        GOLDEN.write_text(before + text + "\n", encoding="utf-8")
    assert text + "\n" in GOLDEN.read_text(encoding="utf-8"), "see how it is read now, and the top of this file"


def test_columns_stated_as_a_vector_are_read():
    loaded = load_trace(
        FILES / "vector-called-angles.csv", TraceOptions(columns="t=1,p=2+3+4,e=5+6+7", euler="vector,rad")
    )
    assert np.abs(loaded.track.orientation_xyzw - head(16).orientation_xyzw).max() < 1e-6
    assert by(loaded, "columns") is By.USER


def test_what_is_missing_is_named(tmp_path):
    assert "are no rotations" in refusal(FILES / "matrix-stated.csv", columns="t=2,m=2-17")
    text = (FILES / "motive.csv").read_text(encoding="utf-8")
    (tmp_path / "take.csv").write_text(text.replace("Rigid Body", "Marker"))
    assert "without rigid bodies" in refusal(tmp_path / "take.csv")
    shutil.copy(next(FILES.glob("bids-quaternions/*_motion.tsv")), tmp_path)
    assert "channels.tsv, which is not beside it" in refusal(next(tmp_path.glob("*_motion.tsv")))


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


def inverse(track: PoseTrack) -> PoseTrack:
    """The same head as head from world."""
    turned = np.linalg.inv(matrices(track))
    return track.evolve(position_m=turned[:, :3, 3], orientation_xyzw=Rotation.from_matrix(turned[:, :3, :3]).as_quat())


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


def test_our_own_bids_export_comes_back(tmp_path):
    stem = str(tmp_path / "sub-a_tracksys-hmd")
    Path(f"{stem}_motion.tsv").write_text(motion_text(TRACK))
    Path(f"{stem}_channels.tsv").write_text(channels_text())
    Path(f"{stem}_channels.json").write_text(json.dumps(channels_json()))
    back = load_trace(f"{stem}_motion.tsv")
    assert same_motion(back.track.evolve(time_ns=TRACK.time_ns), TRACK, atol=EXACT)


def stamped(folder: Path, stamps: list, name: str = "time", track: PoseTrack = TRACK) -> Path:
    rows = zip(stamps, track.position_m.tolist(), track.orientation_xyzw.tolist(), strict=True)
    table = [[s if isinstance(s, str) else repr(s), *map(repr, [*p, *q])] for s, p, q in rows]
    return write(folder / "c.csv", table, f"{name},x,y,z,qx,qy,qz,qw")


@pytest.mark.parametrize(
    ("bits", "step_ns", "name", "low"),
    [
        *((32, step, name, 0) for name, step in (("time_ms", 10**6), ("time_us", 10**3))),
        *((32, step, name, -(2**31)) for name, step in (("time_ms", 10**6), ("time_us", 10**3))),
    ],
)
def test_clocks_of_32_bits_are_counted_on(tmp_path, bits, step_ns, name, low):
    long = head(600)
    ticks = (long.time_ns // step_ns - 10**9 // step_ns) % 2**bits + low  # a second before the wrap at first
    loaded = load_trace(stamped(tmp_path, ticks.tolist(), name, long))
    assert len(loaded.track) == 600 and len(loaded.segments) == 1
    assert abs(loaded.track.duration_ns - long.duration_ns) <= step_ns
    assert "clock-changes" in kinds(loaded)


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
    assert "clock-changes" not in kinds(loaded) and len(loaded.segments) == 2
