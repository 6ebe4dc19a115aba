"""From the texts of the command line to a network, and what is said about texts that cannot be
meant.
"""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.errors import InputError
from hmdwarp.link import Bandwidth, GilbertElliott, LinkOptions, ResponseTime, TransitStats, response_figures
from hmdwarp.link.delays.models import ConstantDelay, NormalJitter, UniformJitter

MS = 1_000_000


def test_default_options_delay_by_the_latency_alone():
    options = LinkOptions.of({})
    assert options == LinkOptions() == LinkOptions.of({"jitter": "constant", "loss": "none"})
    assert options.is_plain
    assert options.longest_ns(7) == options.typical_ns(7) == 7


def test_each_text_says_what_it_should(tmp_path):
    trace = tmp_path / "delays.csv"
    trace.write_text("5\n7\n")
    assert LinkOptions.of({"jitter": "uniform:20"}).delay == UniformJitter(20)
    assert LinkOptions.of({"jitter": " normal : 1.5 "}).delay == NormalJitter(1.5)
    assert LinkOptions.of({"jitter": ""}).delay == ConstantDelay()
    assert LinkOptions.of({"delay_trace": trace}).delay.delays_ms == (5, 7)
    assert next(LinkOptions.of({"loss": "1"}).loss.samples(np.random.default_rng(0))), "the first frame too"
    assert LinkOptions.of({"loss": "0.25"}).loss == GilbertElliott(0, 1, good=0.25)
    assert LinkOptions.of({"bandwidth": "50"}).bandwidth == Bandwidth(50, 250)
    assert LinkOptions.of({"bandwidth": "2.5", "queue": 100.0}).bandwidth == Bandwidth(2.5, 100)
    assert not any(
        LinkOptions.of({name: text}).is_plain
        for name, text in [("jitter", "normal:1"), ("loss", "0.1"), ("bandwidth", "9")]
    )
    assert LinkOptions.of({"link_seed": 5}).is_plain


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"jitter": "unifrom:20"}, "did you mean 'uniform'"),
        ({"jitter": "uniform"}, "jitter uniform '': expected milliseconds"),
        ({"jitter": "uniform:-1"}, "jitter uniform '-1'"), ({"jitter": "normal:nan"}, "jitter normal 'nan'"),
        ({"jitter": "normal:1e9"}, "from 0 to 60000"), ({"jitter": "constant:5"}, "takes no number"),
        ({"jitter": "trace"}, "expected a file"),
        ({"loss": "p=0.02,r=0.3"}, "bursts have an option of their own, --loss-burst"),
        ({"loss": "some"}, "expected a share of the frames"), ({"loss": "1.1"}, "from 0 to 1"),
        ({"loss": "nan"}, "from 0 to 1"), ({"loss": "0.1", "loss_burst": 0.5}, "--loss-burst 0.5: expected 1 to"),
        ({"loss": "0.1", "loss_burst": math.nan}, "--loss-burst nan: expected 1 to"),
        ({"loss": "0.7", "loss_burst": 2.0}, "expected a share of at most 0.667"),
        ({"loss_burst": 2.0}, "--loss-burst 2 without --loss: expected"),
        ({"bandwidth": "0"}, "bandwidth 0 Mbit/s: expected 0.001"), ({"bandwidth": "-5"}, "bandwidth -5"),
        ({"bandwidth": "nan"}, "bandwidth nan"), ({"bandwidth": "inf"}, "leave it out"),
        ({"bandwidth": "50Mbit"}, "expected Mbit/s"),
        ({"bandwidth": "50,queue=100"}, "the longest wait before it has an option of its own, --queue"),
        ({"bandwidth": "50", "queue": -1.0}, "--queue -1 ms: expected"),
        ({"bandwidth": "50", "queue": math.nan}, "--queue nan ms: expected"),
        ({"queue": 100.0}, "--queue 100 ms without --bandwidth: expected"), ({"link_seed": -1}, "seed -1"),
        ({"jitter": "normal:5", "delay_trace": "delays.csv"}, "leave one of them out"),
    ],
)  # fmt: skip
def test_texts_that_cannot_be_meant(given, message):
    with pytest.raises(InputError, match="expected|did you mean|takes no number|leave one") as caught:
        LinkOptions.of(given)
    assert message in str(caught.value)


@given(st.floats(0, 1), st.floats(1, 1000))
def test_bursts_lose_the_share_of_the_frames_that_was_set(share, frames):
    try:
        loss = LinkOptions.of({"loss": str(share), "loss_burst": frames}).loss
    except InputError as error:
        assert share > frames / (frames + 1) and "longer bursts" in str(error)
    else:
        assert loss.mean == pytest.approx(share) and 1 / loss.r == pytest.approx(frames)


@given(st.text(alphabet="0123456789.,:=-+eEprnafqu \t", max_size=20), st.sampled_from(["jitter", "loss", "bandwidth"]))
def test_any_text_is_understood_or_refused_with_a_sentence(text, which):
    try:
        LinkOptions.of({which: text})
    except InputError as error:
        assert str(error)


def test_a_jitter_wider_than_the_latency_is_refused_when_the_latency_is_known():
    with pytest.raises(InputError, match="uniform:20 around a latency of 10 ms would .* before they were sent"):
        LinkOptions.of({"jitter": "uniform:20"}).link(10 * MS)


def test_the_same_seed_is_the_same_network_whatever_is_sent_through_it():
    """What becomes of each frame without a limit of bandwidth does not depend on its size, nor on
    whether the losses were drawn.
    """

    def delays(options: LinkOptions, size: int) -> dict[int, int]:
        link, out = options.link(100 * MS), {}
        for number in range(200):
            link.send(number, number * 11 * MS, size)
            if link.newest(number * 11 * MS) is not None:
                out[link.transit.number] = link.transit.delay_ns
        return out

    options = LinkOptions.of({"jitter": "normal:30", "loss": "0.14", "loss_burst": 3.3})
    assert delays(options, 0) == delays(options, 10**6)
    assert delays(options, 0) != delays(attrs.evolve(options, seed=1), 0)
    lossless = delays(attrs.evolve(options, loss=None), 0)
    both = delays(options, 0).keys() & lossless.keys()
    assert len(both) > 50
    assert all(delays(options, 0)[number] == lossless[number] for number in both)


def test_a_response_time_is_the_sum_of_its_parts():
    transit = TransitStats(3, 100, 5000, queue_ns=2 * MS, transfer_ns=3 * MS, delay_ns=40 * MS, hold_ns=5 * MS)
    time = ResponseTime.of(transit, render_ms=6, encode_ms=4, decode_ms=2, warp_ms=1.5)
    work = {"render_ms": 6, "encode_ms": 4, "decode_ms": 2, "warp_ms": 1.5}
    assert time.parts() == {**work, "queue_ms": 7, "transfer_ms": 3, "round_trip_ms": 40}
    assert time.total_ms == 63.5
    # All that the link adds is in it.
    assert time.queue_ms + time.transfer_ms + time.round_trip_ms == pytest.approx(
        (transit.ready_ns - transit.sent_ns) / 1e6
    )


def test_means_of_the_parts_add_up_to_the_mean_of_the_sums():
    times = [ResponseTime(render_ms=a, warp_ms=b) for a, b in [(1, 9), (2, 2), (9, 1)]]
    found = response_figures(times)
    assert (found["render_ms"], found["warp_ms"], found["total_ms"]) == (4, 4, 8)
    assert found["median_ms"] == 10 and found["p95_ms"] == 10  # of 10, 4 and 10
    assert response_figures([]) is None
