"""From the texts of the command line to a network: delays, loss, pace, and what is refused."""

from __future__ import annotations

import itertools
import math

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.base import InputError
from hmdwarp.link import (
    Bandwidth,
    GilbertElliott,
    LinkOptions,
    Pacer,
    ResponseTime,
    TransitStats,
    delay_models,
    figures_of_parts,
)
from hmdwarp.link.delays import ConstantDelay, DelayTrace, NormalJitter, UniformJitter, read_delays

MS = 1_000_000


def test_each_text_says_what_it_should(tmp_path):
    trace = tmp_path / "delays.csv"
    trace.write_text("5\n7\n")
    said = [
        ({"jitter": "uniform:20"}, {"delay": UniformJitter(20)}),
        ({"jitter": " normal : 1.5 "}, {"delay": NormalJitter(1.5)}),
        ({"jitter": ""}, {"delay": ConstantDelay()}),
        ({"loss": "0.25"}, {"loss": GilbertElliott(0, 1, good=0.25)}),
        ({"bandwidth": "50"}, {"bandwidth": Bandwidth(50, 250)}),
        ({"bandwidth": "2.5", "queue": 100.0}, {"bandwidth": Bandwidth(2.5, 100)}),
        ({"response": "sum"}, {"response": "sum"}),
    ]
    for texts, fields in said:
        options = LinkOptions.of(texts)
        assert {name: getattr(options, name) for name in fields} == fields
        assert options.is_plain == (options == LinkOptions()), texts
    plain = LinkOptions.of({"jitter": "constant", "loss": "none", "link_seed": 5})
    assert plain.is_plain and plain.longest_ns(7) == plain.delay.typical_ns(7) == 7
    assert LinkOptions.of({"delay_trace": trace}).delay.delays_ms == (5, 7)
    assert next(LinkOptions.of({"loss": "1"}).loss.samples(np.random.default_rng(0))), "the first frame too"


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
        ({"server_rate": 0.0}, "server-rate 0 Hz: expected"),
        *(({"response": text}, "expected fixed or sum") for text in ("summ", "", "sum:render=8,encode=5")),
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


def test_a_latency_that_a_network_cannot_have_is_refused():
    with pytest.raises(InputError, match="uniform:20 around a latency of 10 ms would .* before they were sent"):
        LinkOptions.of({"jitter": "uniform:20"}).link(10 * MS)
    for latency in (-1, -(10**12), math.nan, math.inf, -math.inf):
        with pytest.raises(InputError, match=r"latency .* ms: expected 0 or more"):
            LinkOptions().link(latency)


def test_the_same_seed_is_the_same_network_whatever_is_sent_through_it():
    """Without a limit of bandwidth neither sizes of frames nor losses change their delays."""

    def delays(options: LinkOptions, size: int) -> dict[int, int]:
        link, out = options.link(100 * MS), {}
        for number in range(200):
            link.send(number, number * 11 * MS, size)
            if link.newest(number * 11 * MS) is not None:
                out[link.transit.number] = link.transit.delay_ns
        return out

    options = LinkOptions.of({"jitter": "normal:30", "loss": "0.14", "loss_burst": 3.3})
    found, lossless = delays(options, 0), delays(attrs.evolve(options, loss=None), 0)
    assert found == delays(options, 10**6) != delays(attrs.evolve(options, seed=1), 0)
    both = found.keys() & lossless.keys()
    assert len(both) > 50 and all(found[number] == lossless[number] for number in both)


def test_a_response_time_is_the_sum_of_its_parts():
    """Work at both ends is measured; the rest of the way is the link's, each part once."""
    transit = TransitStats(3, 100, 5000, queue_ns=2 * MS, transfer_ns=3 * MS, delay_ns=40 * MS, hold_ns=5 * MS)
    work = {"render_ms": 6, "encode_ms": 4, "decode_ms": 2, "warp_ms": 1.5}
    time = ResponseTime.of(transit, **work)
    assert time.parts() == {**work, "queue_ms": 7, "transfer_ms": 3, "round_trip_ms": 40}
    assert sum(time.parts().values()) == 63.5 == 13.5 + (transit.ready_ns - transit.sent_ns) / 1e6


def test_figures_are_means_of_the_parts_and_ends_of_the_sums():
    times = [ResponseTime(render_ms=1.0, warp_ms=float(number)) for number in range(101)]
    found = figures_of_parts([[*time.parts().values()] for time in times])
    assert {name: found[f"{name}_ms"] for name in ("render", "warp", "total", "median", "p95")} == pytest.approx(
        {"render": 1.0, "warp": 50.0, "total": 51.0, "median": 51.0, "p95": 96.0}
    )
    assert figures_of_parts([]) is None


MANY = 20_000


def drawn(model, latency_ns: int, count: int = MANY, seed: int = 1) -> np.ndarray:
    return np.array(list(itertools.islice(model.samples(latency_ns, np.random.default_rng(seed)), count)))


def example(name: str, folder):
    (folder / "delays.csv").write_text("12\n90\n3.5\n")
    arguments = {"constant": "", "trace": str(folder / "delays.csv")}
    return delay_models.get(name).parse(arguments.get(name, "15"))


@pytest.mark.parametrize("name", delay_models.names())
@pytest.mark.parametrize("latency_ms", [15, 200])
def test_every_model(name, latency_ms, tmp_path):
    """Bounds hold, the mean is the stated one, the seed decides. The mean of n samples that spread
    by s is within 5 s/sqrt(n) of it."""
    model = example(name, tmp_path)
    model.check(latency_ms * MS)
    delays = drawn(model, latency_ms * MS)
    assert 0 <= delays.min() <= delays.max() <= model.longest_ns(latency_ms * MS)
    count = len(delays) // 3 * 3 if name == "trace" else len(delays)  # whole rounds of the file
    assert abs(delays[:count].mean() - model.typical_ns(latency_ms * MS)) <= 5 * delays.std() / math.sqrt(count) + 1
    assert isinstance(next(model.samples(latency_ms * MS, np.random.default_rng(1))), int)
    assert (drawn(model, latency_ms * MS, 100) == delays[:100]).all()
    if name in ("uniform", "normal"):
        assert (drawn(model, latency_ms * MS, 100, seed=2) != delays[:100]).any()


def test_a_trace_is_read_with_its_comments_and_heading_and_loops(tmp_path):
    path = tmp_path / "delays.csv"
    path.write_bytes("\ufeff# measured on a Sunday\r\ndelay_ms\r\n\r\n12.5\r\n  40 # a burst\r\n1e1\r\n".encode())
    assert read_delays(path) == [12.5, 40.0, 10.0]
    model = delay_models.get("trace").parse(str(path))
    assert drawn(model, 999 * MS, 7).tolist() == [int(ms * MS) for ms in (12.5, 40, 10, 12.5, 40, 10, 12.5)]
    assert (model.longest_ns(0), model.typical_ns(0)) == (40 * MS, 20_833_333)


def lost(model: GilbertElliott, count: int = 50_000) -> np.ndarray:
    return np.array(list(itertools.islice(model.samples(np.random.default_rng(3)), count)))


def test_jitter_has_the_shape_that_it_is_named_for():
    """Counts and deviations of n samples are within 5 of their own standard deviations."""
    even, _ = np.histogram(drawn(UniformJitter(20), 200 * MS), bins=10, range=(180 * MS, 220 * MS))
    assert even.sum() == MANY and np.abs(even - MANY / 10).max() < 5 * math.sqrt(MANY / 10)
    delays = (drawn(NormalJitter(15), 200 * MS) / MS - 200) / 15
    assert abs(delays.std() - 1) < 5 / math.sqrt(2 * MANY)
    assert abs((np.abs(delays) < 1).mean() - 0.6827) < 5 * math.sqrt(0.6827 * 0.3173 / MANY)
    truncated = drawn(NormalJitter(30), 10 * MS)
    assert truncated.min() >= 0 and (truncated == 0).mean() < 1e-3, "none gathers at zero"
    for model, latency_ns in ((UniformJitter(0), 200 * MS), (NormalJitter(0), 200 * MS), (NormalJitter(0), 0)):
        assert set(drawn(model, latency_ns, 50).tolist()) == {latency_ns}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1\n2\n-3\n", "line 3: '-3'"), ("ms\n1\nnan\n", "line 3: 'nan'"), ("nan\n", "line 1: 'nan'"),
        ("1\ninf\n", "line 2: 'inf'"), ("1\n2,3\n", "line 2: '2,3'"), ("ms\nms\n1\n", "line 2: 'ms'"),
        ("1\n60001\n", "line 2: '60001'"), ("1\n" + "x" * 100, "line 2: '" + "x" * 37 + "...'"),
        ("", "holds no delay"), ("# nothing\nms\n", "holds no delay"), (b"\x89PNG\r\n\xff\xfe", "not a text file"),
        (None, "no such file"),
    ],
)  # fmt: skip
def test_traces_that_cannot_be_meant(text, message, tmp_path):
    path = tmp_path / "delays.csv"
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as caught:
        DelayTrace.parse(str(path))
    assert str(path) in str(caught.value) and message in str(caught.value)


# By model: the share that is lost, how long a burst lasts, and by how much of it either may be off:
# five standard deviations, each sqrt(2 / n) of it where 50,000 frames have n bursts.
LOSSES = [
    (GilbertElliott(0.07, 0.3), 0.07 / 0.37, 1 / 0.3, 0.14),
    (GilbertElliott(0.1, 0.1, good=0.05, bad=0.5), 0.275, None, 0.11),
    (GilbertElliott(0.2, 0.8), 0.2, 1.25, 0.06),  # without memory
    (GilbertElliott(0, 0), 0, None, 0),
    (GilbertElliott(0, 1, good=1), 1, None, 0),
    (GilbertElliott(1, 0), 1, None, 1e-4),  # but for the first
]


@pytest.mark.parametrize(("model", "share", "lasts", "within"), LOSSES, ids=str)
def test_losses_are_as_many_and_as_long_as_stated(model, share, lasts, within):
    losses = lost(model)
    assert model.mean == pytest.approx(share) and losses.mean() == pytest.approx(share, rel=within)
    if lasts:
        edges = np.flatnonzero(np.diff(losses.astype(int)))[int(losses[0]) :]
        assert np.diff(edges)[::2].mean() == pytest.approx(lasts, rel=within)
    assert (lost(model, 50) == losses[:50]).all(), "the seed decides"


RATES = st.one_of(st.sampled_from([10.0, 15.0, 24.0, 30.0, 59.94, 60.0, 72.0, 90.0, 144.0]), st.floats(1, 1000))


def refreshes(rate_hz: float, count: int, first_ns: int = 7) -> list[int]:
    return [first_ns + round(number * 1e9 / rate_hz) for number in range(count)]


@given(server_hz=RATES, display_hz=RATES)
def test_every_instant_comes_once_in_order_and_at_the_servers_rate(server_hz, display_hz):
    pacer, instants = Pacer(server_hz, display_hz), refreshes(display_hz, 60)
    found = [pacer.due(now) for now in instants]
    drawn = [instant for at in found for instant in at]
    assert drawn == sorted(set(drawn))
    assert found[0] == [instants[0]], "the first refresh has a frame"
    # Within a period of the server and of the display, and the thousandth that counts as a divisor.
    length_s = (instants[-1] - instants[0]) * 1e-9
    assert abs(len(drawn) - length_s * server_hz) <= 1 + 2e-3 * length_s * server_hz
    for before, now, at in zip(instants, instants[1:], found[1:], strict=False):
        assert all(before - 1001 <= instant <= now for instant in at), "each belongs to the refresh that asks for it"


def test_a_rate_draws_at_every_nth_refresh_or_between_them_and_after_a_stall_the_newest_alone():
    instants = refreshes(60.0, 31)
    for server_hz, every in ((None, 1), (60.0, 1), (30.0, 2), (20.0, 3), (10.0, 6)):
        found = [*map(Pacer(server_hz, 60.0).due, instants)]
        assert found == [[now] if n % every == 0 else [] for n, now in enumerate(instants)]
    pacer, faster = Pacer(25.0, 60.0), Pacer(120.0, 60.0)
    assert [len(faster.due(now)) for now in instants[:5]] == [1, 2, 2, 2, 2]
    drawn = [instant for now in refreshes(60.0, 31, first_ns=0) for instant in pacer.due(now)]
    assert drawn == [number * 40_000_000 for number in range(13)]
    assert pacer.due(10_000_000_000) == [9_960_000_000, 10_000_000_000]
    assert pacer.due(10_016_666_667) == []
