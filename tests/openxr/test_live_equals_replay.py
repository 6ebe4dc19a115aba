"""Live and replay are one pipeline.

The same head, fed to a real runtime pose by pose, gives the same poses and the same pictures.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from replays import small

from hmdwarp.colour import picture_from_linear
from hmdwarp.geometry import Eyes, Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.pipeline import Loop, ServerFrames
from hmdwarp.poses import angle_between, load_trace
from hmdwarp.run import ReplayRun, set_up_replay

from .live_runs import SMALL, Here, quick

# What a float32 holds exactly: a runtime speaks in those. Of the left eye; the right one's is
# mirrored.
FOV = Fov(left=-0.84375, right=0.6875, down=-0.78125, up=0.65625)
IPD_M = 0.0625
SCENE, LATENCY_MS, POSES = "room", 175.0, 16
HEADSET = f"""
name = "remote"
summary = "what Monado's remote device is told to be"
source = "this test"
[panel]
eye_size_px = [{SMALL[0]}, {SMALL[1]}]
eye_size_m = [0.06, 0.07]
refresh_hz = 20
[eyes]
ipd_m = {IPD_M}
[fov_deg]
left = {math.degrees(FOV.left)}
right = {math.degrees(FOV.right)}
down = {math.degrees(FOV.down)}
up = {math.degrees(FOV.up)}
"""


def fed_poses() -> list[Pose]:
    """A quarter of a second apart in a recording.

    The head turns and moves by several pixels each time.
    """
    track = load_trace("look-around").track
    return [track.at(track.start_ns + number * 250_000_000).pose for number in range(POSES)]


def eyes() -> list[tuple[Pose, Fov]]:
    mirrored = Fov(-FOV.right, -FOV.left, FOV.down, FOV.up)
    return [(Pose((-IPD_M / 2, 0, 0)), FOV), (Pose((IPD_M / 2, 0, 0)), mirrored)]


class Shown(NamedTuple):
    """A refresh of the live run, as its log has it."""

    head: Pose  # at display
    drawn: Pose  # when its frame was drawn
    age_ms: float  # of the frame


class EyesAsTheyWere:
    """Eyes as the runtime had them at one refresh after the other: views by the number of it."""

    def __init__(self) -> None:
        self.known: list[list[View]] = []
        self.handed_over: list[list[NDArray[np.uint8]]] = []  # pictures, left and right
        self.at = 0

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """At refresh number `at`, as Eyes.views."""
        return tuple(
            View(world_from_head @ eye.head_from_eye, eye.fov, eye.head_from_eye, eye.hidden)
            for eye in self.known[self.at]
        )


def run_live(here: Here, remote_head, out: Path, recording: Path, passes: dict[str, str]) -> EyesAsTheyWere:
    """Each of `fed_poses` is there for exactly one refresh."""
    poses, were = fed_poses(), EyesAsTheyWere()
    remote_head.put_eyes(eyes())
    remote_head.put(poses[0])

    def after(number: int) -> None:
        refresh = here.watched.shown[-1]
        were.known.append([given.shown for given in refresh.inputs])
        were.handed_over.append([picture_from_linear(download(eye.panel.texture)) for eye in refresh.eyes])
        if number < POSES:
            remote_head.put(poses[number])
            while np.abs(here.head().position_m - poses[number].position_m).max() > 1e-5:
                pass  # not arrived yet; the next refresh begins after it has

    # A gather that writes its depth for the runtime places colours by other rounding.
    how = {"samples": 1, "depth_layer": not passes["warp"].startswith("iterative")}
    how |= {"latency_ms": LATENCY_MS, "record": recording, "out": out}
    here.run(quick(scene=SCENE, pictures=POSES, **how, **passes), after)
    return were


def rows_of(folder: Path) -> list[Shown]:
    with (folder / "frames.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["eye"] == "0"]
    return [Shown(_pose(row, "shown"), _pose(row, "drawn"), float(row["age_ms"])) for row in rows]


def _pose(row: dict[str, str], which: str) -> Pose:
    values = [float(row[f"{which}_{part}"]) for part in ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")]
    return Pose(values[:3], values[3:])


def replay_of(folder: Path, passes: dict[str, str]) -> ReplayRun:
    """A replay of what head.csv there holds."""
    (folder / "remote.toml").write_text(HEADSET, encoding="utf-8")
    told = {"trace": str(folder / "head.csv"), "headset": str(folder / "remote.toml"), "rate_hz": 20.0}
    return set_up_replay(small(folder / "replay", latency_ms=0.0, scene=SCENE, size=SMALL, **told, **passes))


def replayed(setup: ReplayRun, rows: list[Shown], eyes: Eyes) -> list[list[NDArray[np.uint8]]]:
    """Both pictures of each refresh from the replay of the recording, of frames as old as those of
    the live run.

    A live frame is drawn a while before the instant its refresh is seen, and a machine under load
    makes that while now longer, now shorter: so here each frame is drawn when the log says it was
    first used, and the link passes it on at once.
    """
    made, found, last = setup, [], None
    frames = ServerFrames(made.server, made.requested, eyes)
    loop = Loop(made.requested, frames, made.channel, made.loop.history, made.loop.compensator, eyes)
    number_of = {tuple(row.head.position_m): number for number, row in enumerate(rows)}
    times = setup.track.time_ns.tolist()
    for number, (row, time_ns) in enumerate(zip(rows, times, strict=True)):
        drawn = number_of[tuple(row.drawn.position_m)]
        if drawn != last:
            last = eyes.at = drawn
            loop.draw(times[drawn])
        eyes.at = number
        found.append([picture_from_linear(download(eye.panel.texture)) for eye in loop.show(time_ns).eyes])
    return found


PASSES = [{"warp": "forward", "fill": "interpolate"}, {"warp": "iterative:frames=1", "fill": "none"}]


@pytest.mark.parametrize("passes", PASSES, ids=lambda passes: passes["warp"])
def test_the_same_poses_and_pictures(remote_head, no_screen, monkeypatch, tmp_path, passes):
    out = tmp_path / "out"
    were = run_live(Here(monkeypatch), remote_head, out, tmp_path / "head.csv", passes)
    rows = rows_of(out)
    for row, fed in zip(rows, fed_poses(), strict=True):
        assert np.abs(row.head.position_m - fed.position_m).max() < 1e-4
        assert angle_between(row.head.orientation_xyzw, fed.orientation_xyzw) < 1e-4
        assert row.age_ms >= LATENCY_MS
    assert len({tuple(row.drawn.position_m) for row in rows}) > POSES / 3  # frames went by, and late ones were warped
    with replay_of(tmp_path, passes) as made:
        np.testing.assert_array_equal(replayed(made, rows, were), were.handed_over)
