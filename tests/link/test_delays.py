"""Delay models and loss.

What they are named for, the same for the same seed, and within the bounds they state.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.errors import InputError
from hmdwarp.link import GilbertElliott, delay_models
from hmdwarp.link.delays.models import NormalJitter, UniformJitter
from hmdwarp.link.delays.trace import DelayTrace, read_delays

MS = 1_000_000
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
    """Bounds hold, the mean is the stated one, the seed decides.

    The mean of n samples that spread by s is within 5 s/sqrt(n) of it.
    """
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


def test_uniform_jitter_is_even():
    """A tenth of the samples in each tenth of the range, within 5 standard deviations."""
    counts, _ = np.histogram(drawn(UniformJitter(20), 200 * MS), bins=10, range=(180 * MS, 220 * MS))
    assert counts.sum() == MANY
    assert np.abs(counts - MANY / 10).max() < 5 * math.sqrt(MANY / 10)


def test_normal_jitter_has_its_deviation_and_its_shape():
    delays = (drawn(NormalJitter(15), 200 * MS) / MS - 200) / 15
    # The deviation of n samples of a normal distribution is known to 1/sqrt(2n); 5 of those.
    assert abs(delays.std() - 1) < 5 / math.sqrt(2 * MANY)
    assert abs((np.abs(delays) < 1).mean() - 0.6827) < 5 * math.sqrt(0.6827 * 0.3173 / MANY)


def test_truncated_means_that_none_gathers_at_zero():
    delays = drawn(NormalJitter(30), 10 * MS)
    assert delays.min() >= 0
    assert (delays == 0).mean() < 1e-3


def test_no_jitter_is_a_constant_delay():
    for model in (UniformJitter(0), NormalJitter(0)):
        assert set(drawn(model, 200 * MS, 50).tolist()) == {200 * MS}
    assert set(drawn(NormalJitter(0), 0, 50).tolist()) == {0}


def test_a_trace_is_read_with_its_comments_and_heading_and_loops(tmp_path):
    path = tmp_path / "delays.csv"
    path.write_bytes("\ufeff# measured on a Sunday\r\ndelay_ms\r\n\r\n12.5\r\n  40 # a burst\r\n1e1\r\n".encode())
    assert read_delays(path) == [12.5, 40.0, 10.0]
    model = delay_models.get("trace").parse(str(path))
    assert drawn(model, 999 * MS, 7).tolist() == [int(ms * MS) for ms in (12.5, 40, 10, 12.5, 40, 10, 12.5)]
    assert (model.longest_ns(0), model.typical_ns(0)) == (40 * MS, 20_833_333)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1\n2\n-3\n", "line 3: '-3'"),
        ("ms\n1\nnan\n", "line 3: 'nan'"),
        ("nan\n", "line 1: 'nan'"),
        ("1\ninf\n", "line 2: 'inf'"),
        ("1\n2,3\n", "line 2: '2,3'"),
        ("ms\nms\n1\n", "line 2: 'ms'"),
        ("1\n60001\n", "line 2: '60001'"),
        ("1\n" + "x" * 100, "line 2: '" + "x" * 37 + "...'"),
        ("", "holds no delay"),
        ("# nothing\nms\n", "holds no delay"),
    ],
)
def test_traces_that_cannot_be_meant(text, message, tmp_path):
    path = tmp_path / "delays.csv"
    path.write_text(text)
    with pytest.raises(InputError, match="expected") as caught:
        read_delays(path)
    assert str(caught.value).startswith(str(path))
    assert message in str(caught.value)


def test_traces_that_cannot_be_read(tmp_path):
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n\xff\xfe")
    for name, said in (("none.csv", "no such file"), (".", "is a directory"), ("picture.png", "not a text file")):
        with pytest.raises(InputError, match=said):
            DelayTrace.parse(str(tmp_path / name))


def lost(model: GilbertElliott, count: int = 50_000) -> np.ndarray:
    return np.array(list(itertools.islice(model.samples(np.random.default_rng(3)), count)))


def bursts(losses: np.ndarray) -> np.ndarray:
    """The lengths of the runs of losses that have both ends."""
    edges = np.flatnonzero(np.diff(losses.astype(int)))
    if losses[0]:
        edges = edges[1:]
    return np.diff(edges)[::2] if len(edges) > 1 else np.array([])


def test_losses_come_in_bursts_of_the_stated_length():
    """Mean share p/(p+r); bursts last 1/r frames.

    Both within 5 standard deviations, of about 3000 bursts.
    """
    model = GilbertElliott(0.07, 0.3)
    losses = lost(model)
    lengths = bursts(losses)
    assert model.mean == pytest.approx(0.07 / 0.37)
    assert abs(lengths.mean() - 1 / 0.3) < 5 * math.sqrt(0.7) / 0.3 / math.sqrt(len(lengths))
    # Bursts and the gaps between them both vary by about their own length: the share by about
    # sqrt(2/n) of itself.
    assert abs(losses.mean() / model.mean - 1) < 5 * math.sqrt(2 / len(lengths))


def test_states_that_lose_only_some():
    losses = lost(GilbertElliott(0.1, 0.1, good=0.05, bad=0.5))
    # The states last 10 frames each: 2500 of each kind, 0.225 / sqrt(2500) * 5.
    assert abs(losses.mean() - 0.275) < 0.03


def test_losses_without_memory():
    losses = lost(GilbertElliott(0.2, 0.8))
    assert abs(losses[1:][losses[:-1]].mean() - 0.2) < 5 * math.sqrt(0.16 / 10_000)


def test_none_and_all():
    assert not lost(GilbertElliott(0, 0), 1000).any()
    assert lost(GilbertElliott(1, 0), 1000)[1:].all()
    assert lost(GilbertElliott(0, 1, good=1), 1000).all()


@settings(max_examples=30)
@given(st.floats(0, 1), st.floats(0, 1), st.integers(0, 99))
def test_loss_is_the_same_for_the_same_seed(p, r, seed):
    model = GilbertElliott(p, r)
    one, two = (list(itertools.islice(model.samples(np.random.default_rng(seed)), 50)) for _ in range(2))
    assert one == two
    assert 0 <= model.mean <= 1
