"""Delay models and loss.

What they are named for, the same for the same seed, and within the bounds they state.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

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
