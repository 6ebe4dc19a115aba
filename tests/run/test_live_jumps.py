"""A recentre, snap turn or teleport of a live head is a jump: no prediction crosses it."""

from __future__ import annotations

import csv
from contextlib import ExitStack

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from serving import Serving

from hmdwarp.geometry import Pose
from hmdwarp.poses import LoopedSource, Origin, PoseSample, PoseTrack, Walker, predict
from hmdwarp.poses.predictors import predictors
from hmdwarp.run import LiveOptions, live
from hmdwarp.run.live_run import RecentPoses
from hmdwarp.sources.feed import FeedOptions

MS = 1_000_000
PERIOD_NS, AT = 11_111_111, 90  # of the samples, and the first one that is elsewhere
KINDS = {"recentre": (75.0, (0, 0, 0)), "snap turn": (30.0, (0, 0, 0)), "teleport": (0.0, (3.0, 0, 1.0))}
SMALL = (12.0, (0.1, 0, 0))


def head(kind: str, count: int = 180) -> PoseTrack:
    """A head that turns and walks, and is elsewhere from sample AT on."""
    index = np.arange(count)
    seconds, after = index * PERIOD_NS * 1e-9, index >= AT
    yaw, place = KINDS.get(kind, SMALL)
    turned = Rotation.from_euler("y", (40 * seconds + yaw * after)[:, None], degrees=True).as_quat()
    position = np.array([0, 1.6, 0]) + 0.4 * seconds[:, None] * (1, 0, 0) + after[:, None] * np.array(place)
    return PoseTrack(index * PERIOD_NS, position, turned, jumps=[AT - 1])


class Poses:
    """Each instant as the track has it, and how often the space has changed by then."""

    def __init__(self, track: PoseTrack, spaces: bool = False) -> None:
        self._track, self._spaces = track, spaces

    def start(self) -> None: ...

    def close(self) -> None: ...

    def head_at(self, time_ns: int) -> PoseSample:
        sample = self._track.at(time_ns)
        space = int(self._spaces and time_ns >= AT * PERIOD_NS)
        return PoseSample(time_ns, sample.pose, Origin.MEASURED, space=space)


def misses(method: str, source, track: PoseTrack) -> tuple[float, float]:
    """The largest error of a prediction for 100 ms after the jump: degrees, metres."""
    recent, worst = RecentPoses(source), [0.0, 0.0]
    for step in range(60, 125):
        now = step * PERIOD_NS
        recent.head_at(now + 2 * PERIOD_NS)  # for the display, as a refresh does
        found = predict(recent.track_until(now), now, now + 100 * MS, method)
        if step > AT:
            truth = track.at(now + 100 * MS).pose
            turn = Rotation.from_quat(truth.orientation_xyzw).inv() * Rotation.from_quat(found.pose.orientation_xyzw)
            worst[0] = max(worst[0], float(np.degrees(turn.magnitude())))
            worst[1] = max(worst[1], float(np.linalg.norm(found.pose.position_m - truth.position_m)))
    return worst[0], worst[1]


@pytest.mark.parametrize("method", [predictor.name for predictor in predictors])
@pytest.mark.parametrize("kind", [*KINDS, "small"])
def test_no_predictor_extrapolates_across_a_jump(kind, method):
    """A small change of space counts where the source says so."""
    track = head(kind)
    degrees, metres = misses(method, Poses(track, spaces=kind == "small"), track)
    # Without any prediction it is what the head does in 100 ms: 4 degrees and 4 cm, a refresh more.
    assert degrees < 5 and metres < 0.05


def test_what_the_runtime_foretold_in_the_space_of_before_is_forgotten():
    """The display's pose lies ahead: of a recentre it knows only when that has happened."""
    before, after = Pose((0, 1.6, 0)), Pose((0, 1.6, 0), (0, 1, 0, 0))
    answers = iter([(0, before), (10, before), (40, before), (20, after), (50, after)])

    class Source(Poses):
        def head_at(self, time_ns):
            at, pose = next(answers)
            return PoseSample(at * MS, pose, Origin.PREDICTED)

    recent = RecentPoses(Source(head("recentre")))
    for _ in range(3):
        recent.head_at(0)
    track = recent.track_until(20 * MS)
    assert track.at(20 * MS).pose.isclose(after) and track.jumps == (1,)
    assert track.time_ns.tolist() == [0, 10 * MS, 20 * MS]


def test_a_fast_head_is_no_jump():
    """The fastest recorded heads turn at 800 degrees a second."""
    times = np.arange(100) * PERIOD_NS * 1e-9
    turned = Rotation.from_euler("y", 800 * times[:, None], degrees=True).as_quat()
    track = PoseTrack((times * 1e9).astype(np.int64), np.zeros((100, 3)) + (0, 1.6, 0), turned)
    recent = RecentPoses(Poses(track))
    for time_ns in track.time_ns[:60].tolist():
        recent.head_at(time_ns)
    assert recent.track_until(int(track.time_ns[60])).jumps == ()


def test_a_walker_that_recentres_and_a_recording_that_begins_again_say_so():
    walker = Walker(0)
    walker.turn(0, 0.2, 0)
    before = walker.head_at(500 * MS).space
    walker.recentre(500 * MS)
    assert walker.head_at(501 * MS).space == before + 1
    looped = LoopedSource(head("recentre"), lambda: 0)
    looped.restart()
    assert looped.head_at(0).space == 1


@pytest.mark.parametrize("way", ["here", "proxy"])
def test_a_live_run_draws_no_frame_for_a_head_that_is_not_there(way, tmp_path):
    """Two refreshes showed frames that were drawn 169 degrees away; also over feed and proxy."""
    track = head("recentre")
    lines = ["time_ns,x_m,y_m,z_m,qx,qy,qz,qw"]
    rows = zip(track.time_ns, track.position_m, track.orientation_xyzw, strict=True)
    lines += [",".join(map(str, (t, *p, *q))) for t, p, q in rows]
    (tmp_path / "recentre.csv").write_text("\n".join(lines), encoding="utf-8")
    with ExitStack() as stack:
        feed = FeedOptions()
        if way == "proxy":
            server = stack.enter_context(Serving())
            proxy = stack.enter_context(Serving("--connect", server.address, command="proxy"))
            feed = FeedOptions(connect=proxy.address)
        live(
            LiveOptions(
                scene="planes", source="offscreen", trace=str(tmp_path / "recentre.csv"), headset="flat-90",
                size=(48, 40), pictures=120, warp="rotation", fill="none", lens="none", rate_hz=90.0, feed=feed,
                out=tmp_path / "out", **({} if feed.connect else {"latency_ms": 100.0}),
            )
        )  # fmt: skip
    with (tmp_path / "out" / "frames.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    drawn, shown = ([[float(row[f"{what}_q{axis}"]) for axis in "xyzw"] for row in rows] for what in ("drawn", "shown"))
    apart = np.degrees((Rotation.from_quat(drawn).inv() * Rotation.from_quat(shown)).magnitude())
    # 75 degrees, and what the head does at 40 degrees a second while the frame grows old.
    age_s = np.array([float(row["age_ms"]) for row in rows]) * 1e-3
    assert len(rows) > 100 and (apart < 75 + 40 * age_s + 4).all()
