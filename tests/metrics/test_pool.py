"""Measuring processes: same bits with any number, bounded, and nothing left behind."""

import gc
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import warnings
from contextlib import suppress
from multiprocessing import resource_tracker
from pathlib import Path

import attrs
import numpy as np
import pytest
from cli.test_signals import children_of

import hmdwarp
from hmdwarp.errors import HmdwarpError, InputError
from hmdwarp.metrics import (
    QUALITY,
    Compared,
    Input,
    MeasuringProcesses,
    QualityJob,
    QualityPool,
    measure,
    metrics_in_order,
)

from .pictures import job, noise, turned

BROKEN = attrs.evolve(job(1), rendered_size=(0, 0))  # a size of no pixels is our fault, not the input's


def children() -> set[int]:
    """Processes whose parent is this one, zombies included."""
    return set(children_of(os.getpid()))


@pytest.fixture(autouse=True)
def nothing_left_behind():
    resource_tracker.ensure_running()  # Python's own, which ends with this program
    before, threads = children(), threading.active_count()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield
        gc.collect()
    assert children() == before
    assert threading.active_count() == threads


def run(workers: int, keys, **options):
    with MeasuringProcesses(workers) as processes:
        pool = QualityPool(processes, **options)
        for key in keys:
            pool.submit(key, job(key[0]), keep=key[0] % 3 == 0)
        pool.wait()
    return pool


def measured(processes: MeasuringProcesses, *jobs: QualityJob, **how) -> QualityPool:
    pool = QualityPool(processes)
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


def test_runs_share_their_processes_which_begin_again_once_they_were_ended():
    """A run finds nothing of the one before; as for the next case of a sweep, after one that
    failed.
    """
    others = children()
    with MeasuringProcesses(1) as processes:
        first = measured(processes, job(0), keep=True)
        mine = children() - others
        assert not QualityPool(processes).results and not QualityPool(processes).kept
        again = measured(processes, job(0))
        assert again.results == first.results and children() - others == mine and len(mine) == 1
        with pytest.raises(HmdwarpError):
            measured(processes, BROKEN)
        processes.close()
        assert measured(processes, job(0)).results == first.results


def test_regions_come_with_the_jobs_that_ask_for_them():
    wanted = attrs.evolve(job(1), regions=True)
    with MeasuringProcesses(1) as processes:
        pool = measured(processes, wanted, job(1))
    assert pool.regions == {(0, 0): measure(wanted).regions}
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
    with MeasuringProcesses(workers) as processes:
        pool = QualityPool(processes)
        with pytest.raises(HmdwarpError, match=r"measuring picture \(7, \d+\) failed: \w+Error: "):
            for key in range(50):  # far more than wait: no submit hangs
                pool.submit((7, key), BROKEN)


def test_an_error_of_the_input_stays_one(monkeypatch):
    def refused(_: QualityJob) -> None:
        raise InputError("no such picture")

    monkeypatch.setattr("hmdwarp.metrics.pool.measure", refused)
    with pytest.raises(InputError, match=r"^measuring picture 3 failed: no such picture$"):
        QualityPool(MeasuringProcesses(0)).submit(3, job(1))


def test_a_worker_that_dies_is_one_clear_error():
    others = children()
    with MeasuringProcesses(1) as processes:
        pool = measured(processes, job(0))
        (worker,) = children() - others
        os.kill(worker, signal.SIGKILL)
        ended = r"picture \d+ failed: a measuring process ended \(killed, perhaps for memory\); use fewer"
        with pytest.raises(HmdwarpError, match=ended):
            for key in range(1, 20):
                pool.submit(key, job(key))


def test_what_a_worker_prints_is_not_seen_but_says_why_it_ended(capfd):
    with MeasuringProcesses(1) as processes:
        found = processes.submit(says_and_ends, 3)
        with pytest.raises(Exception) as caught:
            found.result()
        assert str(processes.explained(caught.value)) == (
            "a measuring process ended (exit status 3): the last words; use fewer metric workers, or 0"
        )
    assert capfd.readouterr() == ("", "")


def says_and_ends(status: int) -> None:
    print("words", flush=True)
    print("the last words", file=sys.stderr, flush=True)
    os._exit(status)


def test_no_more_jobs_than_two_for_each_worker_are_held():
    """With the only worker stopped, one job is with it and one waits; the third submit waits."""
    others = children()
    with MeasuringProcesses(1) as processes:
        pool = measured(processes)
        pool.submit(0, job(0))
        pool.wait()
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
        pool.wait()
    assert len(waiting) <= 2
    assert list(pool.results) == list(range(6))


SCRIPT = """
import sys, signal
sys.path[:0] = [{package!r}, {tests!r}]
from metrics.pictures import job
from hmdwarp.metrics import MeasuringProcesses, QualityPool
# No `if __name__ == "__main__"`: the workers must not run this script again.
try:
    with MeasuringProcesses(2) as processes:
        pool = QualityPool(processes)
        pool.submit(0, job(0))
        pool.wait()
        print("ready", flush=True)
        for key in range(1, 100000):
            pool.submit(key, job(key % 10))
except KeyboardInterrupt:
    print("interrupted", len(pool.results) > 0, flush=True)
    sys.exit(130)
"""


def a_script(folder: Path) -> Path:
    package, path = Path(hmdwarp.__file__).parents[1], folder / "script.py"
    path.write_text(textwrap.dedent(SCRIPT).format(package=str(package), tests=str(Path(__file__).parents[1])))
    return path


def workers_of(process: subprocess.Popen) -> list[Path]:
    """Measuring processes in the session of a program."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has just ended
            session = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[3])
            if session == process.pid and b"spawn_main" in (folder / "cmdline").read_bytes():
                found.append(folder)
    return found


def test_ctrl_c_in_a_terminal(tmp_path):
    """The terminal signals the whole foreground process group.

    The loop alone hears it, and nothing is printed but its own words.
    """
    command = [sys.executable, "-X", "dev", "-W", "error", a_script(tmp_path)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(command, **pipes, start_new_session=True)
    with process:
        assert process.stdout.readline() == "ready\n", process.stderr.read()
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (out, err, process.returncode) == ("interrupted True\n", "", 130)
    # Python's own tracker ends once it hears of the end.
    assert not workers_of(process)


def test_workers_end_with_a_program_that_is_killed(tmp_path):
    said = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    with subprocess.Popen([sys.executable, a_script(tmp_path)], **said, start_new_session=True) as process:
        assert process.stdout.readline() == "ready\n"
        process.kill()
        process.wait()
        while workers_of(process):
            time.sleep(0.01)  # until the last has ended: it hears of it as soon as it may run
