"""Runs in a scene that reacts: an input is answered late, and a run is repeated bit for bit."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from replays import each_refresh, run, small

from hmdwarp.errors import InputError
from hmdwarp.gpu import download
from hmdwarp.sources.feed.options import FeedOptions

MS = 1_000_000
ACTED = {"scene": "playroom", "size": (48, 40), "rate_hz": 20.0, "samples": 1, "latency_ms": 100.0, "images": 2}
HEADER = "time_ns,action,target,x,y,z,dx,dy,dz\n"


def test_a_run_with_inputs_is_repeated_bit_for_bit_from_what_it_wrote(tmp_path):
    first = run(tmp_path / "a", **ACTED, seconds=1.0, input="seed:9", warp="irradiance")
    again = run(tmp_path / "b", **ACTED, seconds=1.0, input=str(tmp_path / "a" / "inputs.csv"), warp="irradiance")
    other = run(tmp_path / "c", **ACTED, seconds=1.0, warp="irradiance")
    assert first.summary["digests"] == again.summary["digests"] != other.summary["digests"]
    assert (tmp_path / "a" / "inputs.csv").read_bytes() == (tmp_path / "b" / "inputs.csv").read_bytes()
    assert "input" not in other.summary and not (tmp_path / "c" / "inputs.csv").exists()


def test_the_response_time_is_the_latency_and_the_wait_for_pictures(tmp_path):
    """A picture is drawn within a refresh after an input, and shown the latency later."""
    path = tmp_path / "in.csv"
    times_ms = (320, 471, 600, 1400)
    path.write_text(HEADER + "".join(f"{at * MS},switch,lamp,0,0,0,0,0,1\n" for at in times_ms))
    found = run(tmp_path / "out", **ACTED, start_s=0.3, seconds=0.7, input=str(path)).summary
    with (tmp_path / "out" / "inputs.csv").open() as file:
        took = [float(row["response_ms"]) if row["response_ms"] else None for row in csv.DictReader(file)]
    # Refreshes are 50 ms apart: pictures of 350, 500 and 600 ms, each shown 100 ms later.
    assert took[:3] == pytest.approx([130.0, 129.0, 100.0], abs=1e-3) and took[3] is None
    assert found["input"]["count"] == found["input"]["answered"] == 3
    assert found["input"]["response_time_ms"]["mean"] == pytest.approx(359 / 3, abs=1e-3)
    assert any("(3 of 3 inputs)" in note for note in found["notes"])


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


def test_pictures_of_others_are_late_too(tmp_path):
    """With `none` the late picture is shown: drawn the latency before."""
    path, shown = tmp_path / "in.csv", {}
    path.write_text(HEADER + f"{400 * MS},push,ball,0,0,0,0,0,1\n")
    each_refresh(
        small(**ACTED, start_s=0.3, seconds=0.4, input=str(path), warp="none"),
        lambda setup, number, refresh: shown.update(
            {
                refresh.shown_ns: np.array_equal(
                    download(refresh.eyes[0].shown.texture),
                    download(
                        setup.server.draw(
                            refresh.frame.eyes[0].view, setup.size, time_ns=refresh.shown_ns - 100 * MS
                        ).colour
                    ),
                )
            }
        ),
    )
    assert shown and all(shown.values())


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


def test_a_seed_without_a_number_is_refused_with_the_options():
    with pytest.raises(InputError, match="--input seed:x: expected seed:N"):
        small(scene="playroom", input="seed:x")


def test_inputs_do_not_cross_a_network():
    with pytest.raises(InputError, match="--input with --connect: inputs do not cross the network"):
        small(**ACTED, input="seed:1", feed=FeedOptions(connect="127.0.0.1:5570"))
