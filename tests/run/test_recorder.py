"""A recording is on the disk while it grows, survives what ends the program, and reads back bit for
bit.
"""

import subprocess
import sys
import threading

import attrs
import numpy as np
import pytest

from hmdwarp.base import InputError, MachineError
from hmdwarp.geometry import Pose
from hmdwarp.poses import Origin, PoseSample, load_trace
from hmdwarp.run import Recorder, origin_of
from hmdwarp.run import recorder as recording

ABOUT = {"runtime": "Monado", "runtime_version": "25.0", "headset": "Simulated HMD"}


def samples(count, first_ns=10**15, step_ns=11_111_111, seed=1):
    """A head that sways, with random digits to the last one."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        # About 0.2 degrees: a larger jump is none that a head can make.
        near = rng.normal(0, 1e-3, 4) + (0, 0, 0, 1)
        yield PoseSample(first_ns + k * step_ns, Pose(rng.normal(0, 1e-3, 3), near), Origin.MEASURED)


def record(path, heads, **more):
    told = []
    with Recorder(path, told.append, **more) as recorder:
        recorder.begin(ABOUT, 90.0)
        for head in heads:
            recorder.add(head)
    return told


def test_a_recording_reads_back_bit_for_bit(tmp_path):
    heads = list(samples(200))
    told = record(tmp_path / "a.csv", heads)
    loaded = load_trace(tmp_path / "a.csv")
    assert loaded.format == "native" and not loaded.defects
    track = loaded.track
    assert track.origin == "hmdwarp live, Monado 25.0, headset 'Simulated HMD'"
    assert origin_of("hmdwarp record", {"runtime": "", "window": "X11"}) == "hmdwarp record, window 'X11'"
    assert track.epoch_ns == heads[0].time_ns
    assert (track.time_ns == [h.time_ns - heads[0].time_ns for h in heads]).all()
    assert (track.position_m == [h.pose.position_m for h in heads]).all()
    assert (track.orientation_xyzw == [h.pose.orientation_xyzw for h in heads]).all()
    assert told == [f"{tmp_path / 'a.csv'}: 200 poses, 2.211 s"]


def test_an_existing_file_is_never_touched_and_kept_where_a_forced_recording_never_begins(tmp_path):
    """As where no headset answers."""
    (tmp_path / "a.csv").write_text("precious " * 1000)
    with pytest.raises(InputError, match="exists already.*--force"):
        Recorder(tmp_path / "a.csv")
    with pytest.raises(MachineError), Recorder(tmp_path / "a.csv", force=True):
        raise MachineError("no headset")
    assert (tmp_path / "a.csv").read_text() == "precious " * 1000
    record(tmp_path / "a.csv", samples(2), force=True)
    assert len(load_trace(tmp_path / "a.csv").track) == 2
    assert "precious" not in (tmp_path / "a.csv").read_text()


def test_an_early_end_saves_the_trace_so_far(tmp_path):
    one, two = (Recorder(tmp_path / name) for name in ("one.csv", "two.csv"))
    for recorder, count in ((one, 1), (two, 2)):
        recorder.begin(ABOUT, 90.0)
        for head in samples(count):
            recorder.add(head)
    assert one.save() == "" and two.save() == f"the recording until then is in {tmp_path / 'two.csv'}"
    assert [path.name for path in tmp_path.iterdir()] == ["two.csv"]
    assert len(load_trace(tmp_path / "two.csv").track) == 2
    for recorder in (one, two):
        with recorder:
            pass


@pytest.mark.parametrize("count", [0, 1])
def test_an_unreadable_trace_is_not_left_behind(tmp_path, count):
    (told,) = record(tmp_path / "a.csv", samples(count))
    assert "nothing recorded" in told and not list(tmp_path.iterdir())


def test_time_that_does_not_rise_is_left_out_and_told(tmp_path):
    a, b, c, d = samples(4)
    told = record(tmp_path / "a.csv", [a, b, a, b, c, c, d])
    assert load_trace(tmp_path / "a.csv").track.time_ns.tolist() == [x.time_ns - a.time_ns for x in (a, b, c, d)]
    assert "went back by 0.011 s" in told[0] and "3 whose time did not rise" in told[-1] and len(told) == 2


def test_held_poses_make_a_gap(tmp_path):
    heads = [attrs.evolve(h, origin=Origin.HELD) if 20 <= k < 60 else h for k, h in enumerate(samples(80))]
    told = record(tmp_path / "a.csv", heads)
    track = load_trace(tmp_path / "a.csv").track
    # 41 steps of 11 ms are longer than what is interpolated, 100 ms.
    assert len(track) == 40 and track.broken.sum() == 1
    assert "40 held (tracking lost)" in told[0]


def test_what_is_flushed_is_on_the_disk_while_it_runs(tmp_path):
    with Recorder(tmp_path / "a.csv") as recorder:
        recorder.begin(ABOUT, 90.0)
        for head in samples(30):
            recorder.add(head)
        recorder.flush()
        assert len(load_trace(tmp_path / "a.csv").track) == 30


# What it loses is counted in poses, each 5 ms at least after the one before: none comes while it
# stands still. The disk's own time comes on top.
CHILD = """
import os, sys, time
from pathlib import Path
from hmdwarp.geometry import Pose
from hmdwarp.run import Recorder
from hmdwarp.poses import Origin, PoseSample
os.fsync = lambda file: None
with Recorder(Path(sys.argv[1])) as recorder:
    recorder.begin({"headset": "none"}, 200.0)
    while True:
        now = time.monotonic_ns()
        recorder.add(PoseSample(now, Pose((0, 1.6, 0)), Origin.MEASURED))
        print(now, flush=True)
        time.sleep(0.005)
"""


def test_a_killed_program_has_lost_a_second_at_most(tmp_path):
    child = subprocess.Popen([sys.executable, "-c", CHILD, str(tmp_path / "a.csv")], stdout=subprocess.PIPE, text=True)
    try:
        taken = [int(child.stdout.readline())]
        while taken[-1] - taken[0] < 2.3e9:
            taken.append(int(child.stdout.readline()))
    finally:
        child.kill()
        rest = child.communicate()[0].split("\n")
    taken += map(int, rest[:-1])
    text = (tmp_path / "a.csv").read_text()
    assert text.endswith("\n")
    track = load_trace(tmp_path / "a.csv").track
    kept = [taken[0] + at for at in track.time_ns.tolist()]
    assert track.epoch_ns == taken[0] and kept == taken[: len(kept)]
    assert len(taken) - len(kept) < 1 / 0.005


def test_a_disk_that_stands_still_holds_no_pose_up_and_its_backlog_is_bounded(tmp_path, monkeypatch):
    stands, go = threading.Event(), threading.Event()

    def stalled(_):
        stands.set()
        go.wait(60)

    monkeypatch.setattr(recording.os, "fsync", stalled)
    monkeypatch.setattr(recording, "MOST_WAITING", 20_000)
    heads, told = list(samples(1000)), []
    recorder = Recorder(tmp_path / "a.csv", told.append)
    with pytest.raises(MachineError, match="does not answer"), recorder:
        recorder.begin(ABOUT, 90.0)
        recorder.add(heads[0])
        assert stands.wait(60)
        try:
            for head in heads[1:]:
                recorder.add(head)
        finally:
            go.set()
    assert 100 < recorder.count < 300  # 20,000 characters of about 130 each
    assert len(load_trace(tmp_path / "a.csv").track) >= recorder.count  # the disk came back in time
