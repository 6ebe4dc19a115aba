"""Runs in a scene that reacts: an input is answered late, and a run is repeated bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from replays import each_refresh, run, small
from scipy.spatial.transform import Rotation

from hmdwarp.base import InputError
from hmdwarp.display import MOVED, Command
from hmdwarp.geometry import Pose
from hmdwarp.gpu import download
from hmdwarp.pipeline.options import ProxyOptions
from hmdwarp.poses import PoseTrack
from hmdwarp.run import LiveOptions
from hmdwarp.scenes import load_scene, read_inputs

from .offscreen import RATE_HZ, OffscreenDisplay, closed_at, run_on

MS = 1_000_000
ACTED = {"scene": "playroom", "size": (48, 40), "rate_hz": 20.0, "samples": 1, "latency_ms": 100.0, "images": 2}
HEADER = "time_ns,action,target,x,y,z,dx,dy,dz\n"


def test_a_run_with_inputs_is_repeated_bit_for_bit(tmp_path):
    usual = {**ACTED, "seconds": 1.0, "warp": "irradiance:updates=5"}
    first, again = (run(tmp_path / name, **usual, input="seed:9").summary for name in "ab")
    assert first["digests"] == again["digests"] and first["input"]["answered"] > 0


def test_the_response_time_is_the_latency_and_the_wait_for_pictures(tmp_path):
    """A picture is drawn within a refresh after an input, and shown the latency later."""
    path = tmp_path / "in.csv"
    times_ms = (320, 471, 600, 1400)
    path.write_text(HEADER + "".join(f"{at * MS},switch,lamp,0,0,0,0,0,1\n" for at in times_ms))
    found = run(tmp_path / "out", **ACTED, start_s=0.3, seconds=0.7, input=str(path)).summary
    # Refreshes are 50 ms apart: pictures of 350, 500 and 600 ms, each shown 100 ms later.
    took_ms, entry = [130.0, 129.0, 100.0], found["input"]
    assert entry["count"] == entry["answered"] == 3
    times = {"mean": np.mean(took_ms), "p95": np.percentile(took_ms, 95), "most": max(took_ms)}
    assert entry["response_time_ms"] == pytest.approx(times, abs=1e-3)
    assert any("(3 of 3 inputs)" in note for note in found["notes"])


def test_behind_a_proxy_the_response_time_has_both_links(tmp_path):
    """Its picture of 450 ms shows what the server drew at 350, with an input of 320 ms."""
    path = tmp_path / "in.csv"
    path.write_text(HEADER + f"{320 * MS},switch,lamp,0,0,0,0,0,1\n")
    beside = ProxyOptions(on=True, latency_ms=100.0, warp="none", fill="none")
    options = {**ACTED, "start_s": 0.3, "seconds": 0.7, "input": str(path), "warp": "none"}
    alone, proxied = (
        run(tmp_path / name, **options, **more).summary["input"]["response_time_ms"]["mean"]
        for name, more in (("alone", {}), ("proxied", {"proxy": beside}))
    )
    assert (alone, proxied) == (pytest.approx(130, abs=1e-3), pytest.approx(230, abs=1e-3))


@pytest.mark.parametrize("knows", ["foreseen", "extrapolated", "held"])
def test_the_answer_comes_late_wherever_the_client_does_not_foresee_it(tmp_path, knows):
    """The lamp goes off at 400 ms: the picture darkens at once, or with a frame drawn after."""
    path, dark = tmp_path / "in.csv", {}
    path.write_text(HEADER + f"{400 * MS - 1},switch,lamp,0,0,0,0,0,1\n")

    def look(setup, number, refresh):
        dark[round(refresh.shown_ns / MS)] = float(download(refresh.eyes[0].shown.texture)[..., :3].mean())

    each_refresh(
        small(**ACTED, start_s=0.3, seconds=0.4, input=str(path), warp="irradiance:updates=0.01", client_motion=knows),
        look,
    )
    expected = 400 if knows == "foreseen" else 500
    before, after = ([dark[at] for at in dark if (at >= expected) == late] for late in (False, True))
    assert len(before) >= 1 and len(after) >= 1
    assert max(after) < 0.75 * min(before)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"scene": "room", "input": "seed:1"}, "scene 'room' does not react to what people do: expected playroom"),
        ({"scene": "playroom", "input": "nowhere.csv"}, "nowhere.csv: cannot read inputs"),
    ],
)
def test_inputs_that_cannot_be_are_refused_before_anything_starts(tmp_path, options, why):
    with pytest.raises(InputError, match=why):
        run(tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


class Seen(OffscreenDisplay):
    """It keeps what each refresh shows, before the lens, by its instant."""

    def __init__(self, **more) -> None:
        super().__init__(**more)
        self.seen: dict[int, np.ndarray] = {}

    def show(self, refresh, label="") -> int:
        if refresh is not None:
            self.seen[refresh.shown_ns] = download(refresh.eyes[0].shown.texture)
        return super().show(refresh, label)


def looking_at(*seconds_and_names: tuple[float, str]) -> PoseTrack:
    """Return a head that looks at a thing of the playroom, then at the next."""
    things, eye = load_scene("playroom").inputs.things, np.array((0.1, 1.5, 0.2))
    ways = [things[name].handle(0) - eye for _, name in seconds_and_names]
    turns = [Rotation.align_vectors([way / np.linalg.norm(way)], [[0, 0, -1]])[0] for way in ways]
    return PoseTrack(
        time_ns=np.array([round(seconds * 1e9) for seconds, _ in seconds_and_names]),
        position_m=np.array([eye] * len(ways)),
        orientation_xyzw=np.array([turn.as_quat() for turn in turns]),
    )


ASKED = {
    2: [Command("grab")], 6: [Command("push")], 22: [Command("switch")],
    30: [Command("grab", True), Command("grab", True)], 33: [Command("grab", False), Command("grab", False)],
}  # fmt: skip
LIVE = {
    "scene": "playroom", "headset": "rift-dk1", "latency_ms": 20.0, "fill": "none", "predict": "none", "samples": 1,
    "guard": 1.0,
}  # fmt: skip


def test_a_session_with_inputs_is_recorded_and_replayed_bit_for_bit(monkeypatch, tmp_path):
    track = looking_at((0.0, "ball"), (0.1, "ball"), (0.15, "lamp"), (0.24, "lamp"), (0.28, "door"), (0.45, "door"))
    display = Seen(track=track, size=(48, 40), asked=dict(ASKED), events=closed_at(42))
    held = {**LIVE, "warp": "none", "client_motion": "held", "size": (48, 40), "headset": "rift-dk1"}
    recording = tmp_path / "head.csv"
    result = run_on(monkeypatch, display, LiveOptions(**held, lens="none", record=recording, out=tmp_path / "live"))
    inputs = read_inputs(tmp_path / "head.input.csv")
    done = [f"{event.action} {event.target}" for event in inputs]
    # The hand follows the head, which stands still at first: no news.
    assert [what for number, what in enumerate(done) if what not in done[:number]] == [
        "grab ball", "push ball", "switch lamp", "grab door", "release door",
    ]  # fmt: skip
    assert "5 inputs" in " ".join(display.said) or f"{len(inputs)} inputs" in " ".join(display.said)
    # A picture is drawn in the refresh after an input, and shown 20 ms later: 30, less the 1 ns.
    assert result.summary["input"]["answered"] == result.summary["input"]["count"] == 5
    assert result.summary["input"]["response_time_ms"]["most"] == pytest.approx(30, abs=1e-3)

    first_ns, again = min(display.seen), {}
    each_refresh(
        small(**held, rate_hz=RATE_HZ, trace=str(recording), input=str(tmp_path / "head.input.csv"), start_s=0.0,
              seconds=None),
        lambda setup, number, refresh: again.update({refresh.shown_ns: download(refresh.eyes[0].shown.texture)}),
    )  # fmt: skip
    both = [at_ns for at_ns in again if at_ns + first_ns in display.seen]
    assert len(both) > 30
    for at_ns in both:
        np.testing.assert_array_equal(again[at_ns], display.seen[at_ns + first_ns], err_msg=str(at_ns))
    assert len({again[at_ns].tobytes() for at_ns in both}) > 20


def test_what_a_controller_holds_follows_it_and_not_the_head(monkeypatch, tmp_path):
    track = looking_at((0.0, "ball"), (0.1, "ball"), (0.4, "door"), (9.0, "lamp"))
    first, then = (Pose(track.position_m[0] + (0.1 * k, 0, 0), track.orientation_xyzw[0]) for k in range(2))
    other = Pose(track.position_m[0], track.orientation_xyzw[-1])  # of the other hand, which points at the lamp
    asked = {
        1: [Command("grab", MOVED, hand=first)],  # of nothing
        3: [Command("grab", True, hand=first), Command("push", hand=other)],
        9: [Command("grab", MOVED, hand=first)],  # no news
        12: [Command("grab", MOVED, hand=then)],
        18: [Command("push", hand=then)],
        19: [Command("grab", MOVED, hand=first)],  # it was thrown
        20: [Command("grab", False)],
    }
    display = OffscreenDisplay(track=track, size=(48, 40), asked=asked, events=closed_at(24))
    run_on(monkeypatch, display, LiveOptions(**LIVE, warp="none", record=tmp_path / "head.csv"))
    done = read_inputs(tmp_path / "head.input.csv")
    assert [f"{event.action} {event.target}" for event in done] == ["grab ball", "push lamp", "grab ball", "push ball"]
    places = [first.position_m, other.position_m, then.position_m]
    assert np.allclose([event.origin_m for event in done[:3]], places)


def test_a_scene_that_does_not_react_says_so_and_a_run_without_inputs_writes_none(monkeypatch, tmp_path):
    display = OffscreenDisplay(asked={3: [Command("push")]}, events=closed_at(6))
    options = LiveOptions(
        scene="planes", headset="rift-dk1", latency_ms=0, warp="none", fill="none", record=tmp_path / "head.csv"
    )
    result = run_on(monkeypatch, display, options)
    assert any("scene 'planes' does not react to what people do: expected playroom" in line for line in display.said)
    assert "input" not in result.summary and not (tmp_path / "head.input.csv").exists()
