"""The pool: same bits with any number of workers, bounded, and nothing left behind at its end."""

import gc
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import warnings
from pathlib import Path

import attrs
import numpy as np
import pytest

import hmdwarp
from hmdwarp.errors import HmdwarpError, InputError
from hmdwarp.metrics import QUALITY, Compared, QualityJob, QualityPool, SharedPool, measure

from .pictures import job, noise, turned

PPD = 20.0


def children() -> set[int]:
    """Processes whose parent is this one, zombies included."""
    found = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == os.getpid():
            found.add(int(stat.parent.name))
    return found


@pytest.fixture(autouse=True)
def nothing_left_behind():
    before, threads = children(), threading.active_count()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield
        gc.collect()
    assert children() == before
    assert threading.active_count() == threads


def run(workers: int, keys, **options):
    with QualityPool(workers, PPD, **options) as pool:
        for key in keys:
            pool.submit(key, job(key[0]), keep=key[0] % 3 == 0)
    return pool


def test_the_same_bits_with_any_number_of_workers():
    keys = [(frame, eye) for frame in range(4) for eye in range(2)]
    here, one, two = run(0, keys, worst=2), run(1, keys, worst=2), run(2, reversed(keys), worst=2)
    assert here.results == one.results == two.results
    assert list(here.results) == list(one.results) == list(two.results) == keys
    for others in (one, two):
        for mine, theirs in zip(here.worst + here.kept, others.worst + others.kept, strict=True):
            assert mine.key == theirs.key and np.array_equal(mine.result.error_map, theirs.result.error_map)
    assert all(
        set(values) == set(QUALITY) and {type(v) for v in values.values()} == {float}
        for values in here.results.values()
    )


def test_runs_of_one_resolution_share_their_processes():
    """A run finds nothing of the one before; another resolution has processes of its own."""
    others = children()
    with SharedPool() as pools:
        first = pools.of(1, PPD)
        mine = children() - others
        first.submit((0, 0), job(0), keep=True)
        first.wait()
        found = first.results
        again = pools.of(1, PPD)
        assert children() == mine | others and not again.results and not again.kept
        again.submit((0, 0), job(0))
        again.wait()
        assert again.results == found
        pools.of(1, 2 * PPD)
        assert not children() & mine


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_waiting_is_until_all_is_measured(workers):
    with QualityPool(workers, PPD) as pool:
        pool.wait()
        for round_ in range(3):
            keys = [(round_, number) for number in range(5)]
            for key in keys:
                pool.submit(key, job(key[1]))
            pool.wait()
            assert [key for key in pool.results if key[0] == round_] == keys


def test_waiting_ends_when_a_worker_dies():
    with pytest.raises(HmdwarpError, match="measuring"), QualityPool(1, PPD) as pool:
        pool._workers[0].kill()
        pool.submit((0, 0), job(0))
        pool.wait()
        raise AssertionError("a dead worker was waited for in vain")


def test_regions_come_with_the_jobs_that_ask_for_them():
    wanted = attrs.evolve(job(1), regions=True)
    with QualityPool(1, PPD) as pool:
        pool.submit((0, 0), wanted)
        pool.submit((1, 0), job(1))
    assert list(pool.regions) == [(0, 0)]
    assert pool.regions[0, 0] == measure(wanted, PPD).regions
    assert pool.results[0, 0] == pool.results[1, 0]
    with pytest.raises(InputError, match="coverage"):
        attrs.evolve(job(1), covered=None, regions=True)


def test_a_kept_job_keeps_its_late_picture():
    pool = run(1, [(0, 0), (1, 0), (3, 0)])
    assert [kept.key for kept in pool.kept] == [(0, 0), (3, 0)]
    assert np.array_equal(pool.kept[0].job.rendered_picture, job(0).rendered_picture)
    assert pool.kept[0].result.error_map.shape == (30, 40)
    assert pool.worst == []


def test_figures_without_their_inputs_are_none():
    now = Compared(noise(1), noise(2), turned(0))
    values = measure(QualityJob(now), PPD).values
    assert {name for name, value in values.items() if value is None} == {"hole_share", "border_share", "flicker"}
    covered = np.zeros((30, 40))
    assert measure(QualityJob(now, covered=covered), PPD).values["border_share"] is None
    assert measure(QualityJob(now, covered=covered), PPD).values["hole_share"] == 1


def test_jobs_that_do_not_fit_together():
    now = Compared(noise(1), noise(2), turned(0))
    with pytest.raises(InputError, match="coverage"):
        QualityJob(now, covered=np.ones((40, 30)))
    with pytest.raises(InputError, match="inverse depth"):
        QualityJob(now, truth_inverse_depth=np.ones((40, 30)))
    with pytest.raises(InputError, match="shapes"):
        Compared(noise(1), noise(2, (3, 3)), turned(0))


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_a_measurement_that_fails_is_one_clear_error(workers):
    with pytest.raises(InputError, match=r"picture \(7, 0\).*pixels per degree"), QualityPool(workers, -3.0) as pool:
        pool.submit((7, 0), job(1))
    if workers:
        # What makes flip-evaluator or pickle fall over in the worker is our fault, not the input's.
        broken = attrs.evolve(job(1), rendered_size=(0, 0))
        with pytest.raises(HmdwarpError, match=r"picture 5 failed: \w+Error: "), QualityPool(workers, PPD) as pool:
            pool.submit(5, broken)


def test_submit_raises_after_a_failure_and_does_not_hang():
    with pytest.raises(InputError, match="picture 0"), QualityPool(1, -3.0) as pool:
        for key in range(50):  # far more than the queue holds
            pool.submit(key, job(1))


def test_a_worker_that_dies_is_one_clear_error():
    others = children()
    with (
        pytest.raises(HmdwarpError, match=r"picture \d+ failed: a measuring process ended \(killed.*fewer"),
        QualityPool(1, PPD) as pool,
    ):
        pool.submit(0, job(0))
        (worker,) = children() - others
        os.kill(worker, signal.SIGKILL)
        for key in range(1, 20):
            pool.submit(key, job(key))


def test_a_worker_that_cannot_start_says_why(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parent)])
    with pytest.raises(HmdwarpError, match="exit status 1.*No module named"), QualityPool(1, PPD) as pool:
        pool.submit(0, job(0))


def test_the_queue_is_bounded():
    """With the only worker stopped, one job is with it and one waits.

    The third submit must wait too.
    """
    others = children()
    with QualityPool(1, PPD) as pool:
        pool.submit(0, job(0))
        while not pool.results:
            time.sleep(0.01)
        (worker,) = children() - others
        os.kill(worker, signal.SIGSTOP)
        handed_in = []

        def submit_many():
            for key in range(1, 6):
                pool.submit(key, job(key))
                handed_in.append(key)

        thread = threading.Thread(target=submit_many)
        thread.start()
        thread.join(timeout=1.0)
        waiting = list(handed_in)
        os.kill(worker, signal.SIGCONT)
        thread.join()
    assert len(waiting) <= 2
    assert list(pool.results) == list(range(6))


def test_leaving_by_an_exception_drops_the_rest():
    with pytest.raises(KeyboardInterrupt), QualityPool(2, PPD) as pool:
        for key in range(3):
            pool.submit(key, job(key))
        raise KeyboardInterrupt
    with pytest.raises(HmdwarpError, match="closed"):
        pool.submit(9, job(9))


def test_an_unused_pool():
    with QualityPool(2, PPD) as pool:
        pass
    assert pool.results == {} and pool.finish() == {}


SCRIPT = """
import sys, signal
sys.path[:0] = [{package!r}, {tests!r}]
from metrics.pictures import job
from hmdwarp.metrics import QualityPool, SharedPool
# No `if __name__ == "__main__"`: the workers must not run this script again.
try:
    with QualityPool(2, 20.0) as pool:
        pool.submit(0, job(0))
        while not pool.results: pass
        print("ready", flush=True)
        for key in range(1, 100000):
            pool.submit(key, job(key % 10))
except KeyboardInterrupt:
    print("interrupted", len(pool.results) > 0, flush=True)
    sys.exit(130)
"""


def test_ctrl_c_in_a_terminal(tmp_path):
    """The terminal signals the whole foreground process group.

    The loop alone hears it, and nothing is printed but its own words.
    """
    script = tmp_path / "script.py"
    package = Path(hmdwarp.__file__).parents[1]
    script.write_text(textwrap.dedent(SCRIPT).format(package=str(package), tests=str(Path(__file__).parents[1])))
    command = [sys.executable, "-X", "dev", "-W", "error", script]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    with process:
        assert process.stdout.readline() == "ready\n", process.stderr.read()
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (out, err, process.returncode) == ("interrupted True\n", "", 130)
    # Its session is empty: no worker is left in it.
    assert not [s for s in Path("/proc").glob("[0-9]*/stat") if _session(s) == process.pid]


def _session(stat: Path) -> int:
    try:
        return int(stat.read_text().rsplit(")", 1)[1].split()[3])
    except OSError:
        return -1
