"""Measuring threads: same bits with any number, and bounded."""

import threading

import attrs
import numpy as np
import pytest

from hmdwarp.base import HmdwarpError, InputError
from hmdwarp.metrics import (
    QUALITY,
    Compared,
    Input,
    MeasuringThreads,
    QualityJob,
    QualityPool,
    measure,
    metrics_in_order,
)

from .pictures import job, noise, turned

BROKEN = attrs.evolve(job(1), rendered_size=(0, 0))  # a size of no pixels is our fault, not the input's


def run(workers: int, keys, **options):
    with MeasuringThreads(workers) as threads:
        pool = QualityPool(threads, **options)
        for key in keys:
            pool.submit(key, job(key[0]), keep=key[0] % 3 == 0)
        pool.wait()
    return pool


def measured(threads: MeasuringThreads, *jobs: QualityJob, **how) -> QualityPool:
    pool = QualityPool(threads)
    for number, each in enumerate(jobs):
        pool.submit((number, 0), each, **how)
    pool.wait()
    return pool


def test_the_same_bits_with_any_number_of_workers():
    keys = [(frame, eye) for frame in range(4) for eye in range(2)]
    here, one, two = run(0, keys, worst=2), run(1, keys, worst=2), run(2, reversed(keys), worst=2)
    assert here.results == one.results == two.results
    assert list(here.results) == list(one.results) == list(two.results) == keys
    for others in (one, two):
        for mine, theirs in zip(here.worst + here.kept, others.worst + others.kept, strict=True):
            assert mine.key == theirs.key and np.array_equal(mine.result.error_map, theirs.result.error_map)
    for values in here.results.values():
        assert set(values) == set(QUALITY) and {type(value) for value in values.values()} == {float}
    for kept in two.kept:
        assert kept.key[0] % 3 == 0 and kept.result.error_map.shape == (30, 40)
        assert np.array_equal(kept.job.rendered_picture, job(kept.key[0]).rendered_picture)
    assert run(2, [(1, 0)]).worst == run(2, []).kept == []


def test_regions_come_with_the_jobs_that_ask_for_them():
    wanted = attrs.evolve(job(1), regions=True)
    with MeasuringThreads(1) as threads:
        pool = measured(threads, wanted, job(1))
    assert [*pool.regions] == [(0, 0)] and np.array_equal(pool.regions[0, 0], measure(wanted).regions)
    assert pool.results[0, 0] == pool.results[1, 0]


def test_figures_without_their_inputs_are_none_and_inputs_must_fit_together():
    now = Compared(noise(1), noise(2), turned(0))
    values = measure(QualityJob(now)).values
    missing = {name for name, value in values.items() if value is None}
    assert missing == {"flip", "ssim", "hole_share", "border_share", "flicker"}
    values = measure(QualityJob(now, covered=np.zeros((30, 40)))).values
    assert values["border_share"] is None and values["hole_share"] == 1
    for given, words in (({"covered": np.ones((40, 30))}, "coverage"), ({"regions": True}, "coverage"),
                         ({"truth_inverse_depth": np.ones((40, 30))}, "inverse depth")):  # fmt: skip
        with pytest.raises(InputError, match=words):
            QualityJob(now, **given)
    with pytest.raises(InputError, match="shapes"):
        Compared(noise(1), noise(2, (3, 3)), turned(0))


UNDECLARED = [attrs.evolve(each, needs=Input.TRUTH) for each in metrics_in_order() if each.needs is not Input.TRUTH]


@pytest.mark.parametrize("metric", UNDECLARED, ids=lambda each: each.name)
def test_what_a_metric_reads_it_declares(metric, monkeypatch):
    monkeypatch.setattr("hmdwarp.metrics.metric.metrics_in_order", lambda: [metric])
    with pytest.raises(HmdwarpError, match="`needs` does not declare it"):
        measure(QualityJob(Compared(noise(1), noise(2), turned(0))))


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_a_measurement_that_fails_is_one_clear_error(workers):
    with MeasuringThreads(workers) as threads:
        pool = QualityPool(threads)
        with pytest.raises(HmdwarpError, match=r"measuring picture \(7, \d+\) failed: \w+Error: "):
            for key in range(50):  # far more than wait: no submit hangs
                pool.submit((7, key), BROKEN)


def test_an_error_of_the_input_stays_one(monkeypatch):
    def refused(_: QualityJob) -> None:
        raise InputError("no such picture")

    monkeypatch.setattr("hmdwarp.metrics.pool.measure", refused)
    refusal = pytest.raises(InputError, match=r"^measuring picture 3 failed: no such picture$")
    with MeasuringThreads(0) as threads, refusal:
        QualityPool(threads).submit(3, job(1))


def test_no_more_jobs_than_two_for_each_thread_are_held(monkeypatch):
    """With the only thread held up, one job is with it and one waits; the third submit waits."""
    go_on, handed_in = threading.Event(), []
    monkeypatch.setattr("hmdwarp.metrics.pool.measure", lambda job: go_on.wait() and measure(job))
    with MeasuringThreads(1) as threads:
        pool = QualityPool(threads)

        def submit_many():
            for key in range(6):
                pool.submit(key, job(key))
                handed_in.append(key)

        thread = threading.Thread(target=submit_many)
        thread.start()
        thread.join(timeout=0.5)
        waiting = list(handed_in)
        go_on.set()
        thread.join()
        pool.wait()
    assert waiting == [0, 1]
    assert list(pool.results) == list(range(6))
