"""A proxy: the server's frames over one link, its finished pictures over another."""

from __future__ import annotations

import functools
import json

import attrs
import numpy as np
import pytest
from commands import hmdwarp
from hypothesis import given, settings
from hypothesis import strategies as st
from replays import each_refresh, run, small

from hmdwarp.base import InputError, PlanError
from hmdwarp.geometry import Pose
from hmdwarp.gpu import download
from hmdwarp.headsets import load_headset
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding
from hmdwarp.pipeline import PipelineOptions, build_plan_for
from hmdwarp.pipeline.options import ProxyOptions
from hmdwarp.pipeline.proxy import GuardedEyes
from hmdwarp.poses import angle_between
from hmdwarp.report import coding_rows

MS = 1_000_000
# What hmdwarp replay takes for warp none: the picture as it is.
SHOWN = {"warp": "none", "fill": "none", "guard": 1.0}
REFRESH_MS = 1e3 / 60


def proxied(latency_ms: float, first_ms: float, **about: object) -> dict[str, object]:
    return {**SHOWN, "latency_ms": latency_ms, "proxy": ProxyOptions(on=True, latency_ms=first_ms, **about)}


def pictures(**options: object) -> list[np.ndarray]:
    """Every shown picture of a short run, of the same refreshes whatever the latency."""
    found: list[np.ndarray] = []
    asked = {"start_s": 1.0, "seconds": 0.1, "scene": "room", **options}
    each_refresh(
        small(**asked), lambda setup, number, refresh: found.extend(download(eye.shown.texture) for eye in refresh.eyes)
    )
    return found


@functools.cache
def as_drawn() -> list[np.ndarray]:
    """What a client shows 50 ms after it was drawn."""
    return pictures(**SHOWN, latency_ms=50.0)


def same(some: list[np.ndarray], others: list[np.ndarray]) -> bool:
    return len(some) == len(others) and all(map(np.array_equal, some, others))


@pytest.mark.parametrize("warp", ["none", "iterative", "backward"])
def test_next_to_the_server_it_changes_no_bit(warp):
    """Frames that are not late are shown as they were drawn, by the proxy as by a client."""
    assert same(pictures(**proxied(50.0, 0.0, warp=warp, guard=1.0)), as_drawn())


@pytest.mark.parametrize(
    ("warp", "fill", "scene"),
    [("iterative", "memory+pyramid", "room"), ("multi", "none", "room"), ("iterative", "pyramid", "workshop")],
)
def test_next_to_the_client_it_shows_what_the_client_would_have_made(warp, fill, scene):
    """With the effects that a scene calls for."""
    alone = pictures(warp=warp, fill=fill, scene=scene, guard=1.5, latency_ms=100.0)
    assert same(pictures(**proxied(0.0, 100.0, warp=warp, fill=fill), scene=scene), alone)


def test_what_it_sends_is_drawn_for_the_clients_eyes_at_the_instant_of_the_request():
    """With the guard band alone in between: poses, places in the head and instants stay."""
    eyes, head = load_headset("quest-3"), Pose((0.1, 1.6, 0.2), (0.1, 0.2, 0.3, 0.9))
    for own, wide in zip(eyes.views(head), GuardedEyes(eyes, 1.5, (48, 40)).views(head), strict=True):
        assert str(wide.pose) == str(own.pose) and str(wide.head_from_eye) == str(own.head_from_eye)
        assert (wide.fov.tangents[[1, 3]] > own.fov.tangents[[1, 3]]).all()
    found: list[tuple[int, ...]] = []

    def look(setup, number, refresh) -> None:
        drawn_ns = refresh.frame.drawn_ns
        found.append((refresh.shown_ns - drawn_ns, *(drawn_ns - eye.drawn_ns for eye in refresh.frame.eyes)))

    each_refresh(small(start_s=1.0, seconds=0.05, scene="planes", **proxied(50.0, 50.0)), look)
    assert found and set(found) == {(50 * MS, 0, 0)}


def test_effects_are_compensated_by_the_proxy():
    of_proxy = proxied(0.0, 100.0, warp="iterative", fill="pyramid")
    scene = {"scene": "workshop"}
    assert same(
        pictures(**of_proxy, **scene), pictures(warp="iterative", fill="pyramid", guard=1.5, latency_ms=100.0, **scene)
    )
    assert not same(pictures(**of_proxy, **scene), pictures(**of_proxy, **scene, effects="none"))


def test_both_links_tell_their_bytes_and_each_machine_its_work(tmp_path):
    options = proxied(50.0, 100.0, warp="iterative", fill="pyramid")
    summary = run(tmp_path, coding=Coding("h264"), **options).summary
    link = summary["link"]
    first = link["proxy"]
    assert list(link["layers_mbit_s"]) == ["colour"], "a client gets no depth"
    assert set(first["layers_mbit_s"]) == {"colour", "inverse_depth"}
    # Guard band 1.5 around 96x80 pixels: 144x120 of 12 bytes for each eye.
    assert (first["codec"], first["frame_bytes"]) == ("none", 2 * 144 * 120 * 12)
    assert link["codec"] == "h264" and 0 < link["mbit_s"] < first["mbit_s"]
    assert (first["latency_ms"], first["total_latency_ms"]) == (100, 150)
    assert first["age_ms"]["median"] == pytest.approx(6 * REFRESH_MS)
    assert set(first["time_ms"]) == {"warp", "fill", "total"}
    assert first["time_ms"]["total"]["median"] > 0 and link["response_ms"]["render_ms"] > 0
    coded = run(tmp_path / "coded", **proxied(50.0, 100.0, codec="h264")).summary["link"]["proxy"]
    assert coded["codec"] == "h264" and 0 < coded["mbit_s"] < first["mbit_s"] / 10
    told = dict(coding_rows(summary))
    assert told["proxy"] == "iterative + pyramid"
    assert told["from the server to the proxy"] == f"100 ms, {first['mbit_s']:.1f} Mbit/s uncompressed"


@settings(max_examples=10)
@given(
    first_ms=st.sampled_from([0.0, 10.0, 50.0, 75.0]),
    latency_ms=st.sampled_from([0.0, 20.0, 50.0]),
    jitter_ms=st.integers(0, 20),
    loss=st.sampled_from([{}, {"loss": "0.2"}, {"loss": "0.3", "loss_burst": 2.0}]),
    rate=st.sampled_from([None, 15.0, 25.0]),
    seed=st.integers(0, 9),
)
def test_no_frame_is_early_and_none_comes_after_a_newer_one(first_ms, latency_ms, jitter_ms, loss, rate, seed):
    """On both links, whatever the second one does and however slow the server is."""
    said = {**loss, "link_seed": seed, "server_rate": rate}
    if jitter_ms:
        said["jitter"] = f"uniform:{min(jitter_ms, int(latency_ms))}"
    network = LinkOptions.of(said)
    drawn: list[tuple[int, int]] = []

    def look(setup, number, refresh) -> None:
        shown = setup.loop.source.shown
        least_ms = max(0.0, latency_ms - jitter_ms)
        # Two nanoseconds: refreshes are rounded to whole ones.
        assert refresh.age_ns >= least_ms * MS - 2 and shown.age_ns >= first_ms * MS - 2
        drawn.append((shown.frame.drawn_ns, refresh.frame.drawn_ns))

    options = {**proxied(latency_ms, first_ms, warp="none"), "network": network, "size": (16, 12), "seconds": 0.2}
    try:
        each_refresh(small(**options), look)
    except AssertionError as error:
        # Nothing but lost frames at the start: there is nothing to show yet.
        if "refresh is not None" not in str(error):
            raise
    assert all(before[0] <= after[0] and before[1] <= after[1] for before, after in zip(drawn, drawn[1:], strict=False))


def test_a_predicted_head_is_that_of_the_instant_at_which_it_is_seen():
    """The server predicts over both links, the proxy over the second."""
    options = {**proxied(50.0, 100.0), "predict": "constant_velocity", "horizon_ms": 1000.0, "start_s": 2.0}
    ahead: list[list[float]] = [[], []]

    def look(setup, number, refresh) -> None:
        first = setup.loop.source.shown.frame
        for errors, frame, late_ms in zip(ahead, (first, refresh.frame), (150, 50), strict=True):
            then, now = (setup.track.at(frame.drawn_ns + ms * MS).pose for ms in (late_ms, 0))
            moved = np.linalg.norm(then.position_m - now.position_m)
            errors.append(float(np.linalg.norm(then.position_m - frame.head.pose.position_m) / moved))
            assert angle_between(then.orientation_xyzw, frame.head.pose.orientation_xyzw) < 1.0

    each_refresh(small(trace="walk", seconds=0.2, **options), look)
    # Predicted over another time, it would miss by a third of the way or more.
    assert np.median(ahead[0]) < 0.3 and np.median(ahead[1]) < 0.3


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"strategy": "proxy", "warp": "iterative"}, "--warp iterative beside --strategy proxy"),
        ({"proxy": True, "warp": "iterative", "fill": "none"}, "finished picture alone: show it by --warp none"),
        ({"proxy": True, "warp": "rotation", "fill": "memory"}, "finished picture alone"),
        ({"proxy": True, "warp": "environment", "fill": "none"}, "finished picture alone"),
        ({"proxy": True, "warp": "auto", "budget": 5.0}, "--proxy with --warp auto"),
        ({"proxy": True, "warp": "none", "send": "changes"}, "--proxy with --send changes"),
        ({"proxy_latency": 100.0}, "--proxy-latency 100.0: there is no proxy"),
        ({"proxy_fill": "none"}, "--proxy-fill none: there is no proxy"),
        ({"proxy": True, "warp": "none", "proxy_warp": "iterativ"}, "did you mean 'iterative'"),
        ({"strategy": "proxy:client=forward"}, "expected client=none or client=rotation"),
        ({"proxy": True, "proxy_latency": -1.0}, "--proxy-latency -1 ms: expected"),
    ],
)
def test_contradictory_options_are_refused(said, words):
    with pytest.raises(InputError, match=words):
        build_plan_for(PipelineOptions.of(said), None, None)


def test_a_comparison_that_reads_depth_is_refused(tmp_path):
    with pytest.raises(PlanError, match="inverse_depth"):
        run(tmp_path, against="forward", **proxied(50.0, 50.0))
    assert run(tmp_path, against="rotation", **proxied(50.0, 50.0)).against


def test_the_strategy_takes_a_client_that_turns_the_picture():
    turned = PipelineOptions.of({"strategy": "proxy:client=rotation", "proxy_latency": 120.0, "latency": 80.0})
    assert (turned.warp, turned.fill, turned.proxy.on) == ("rotation", "none", True)
    assert turned.total_latency_ms == 200
    assert attrs.evolve(turned, strategy="").proxy.warp == "iterative"


def test_plan_tells_both():
    done = hmdwarp("plan", "--strategy", "proxy", "--scene", "workshop", "--headset", "rift-dk1", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    told = json.loads(done.stdout)
    assert [step["name"] for step in told["passes"]] == ["warp none", "lens radial"]
    assert "warp iterative" in [step["name"] for step in told["proxy"]["passes"]]
    assert list(told["frame"]["layers"]) == ["rendered.colour"]
    assert any("the proxy compensates it" in entry["reason"] for entry in told["left_out"])
    done = hmdwarp("plan", "--strategy", "proxy", "--size", "96x80")
    assert "Passes of the proxy, in order:" in done.stdout
