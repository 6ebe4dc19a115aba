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
from multiprocessing import resource_tracker
from pathlib import Path

import attrs
import numpy as np
import pytest
from cli.test_signals import children_of

import hmdwarp
from hmdwarp.errors import HmdwarpError, InputError
from hmdwarp.metrics import QUALITY, Compared, MeasuringProcesses, QualityJob, QualityPool, measure

from .pictures import job, noise, turned


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


def test_runs_share_their_processes():
    """A run finds nothing of the one before."""
    others = children()
    with MeasuringProcesses(1) as processes:
        first = QualityPool(processes)
        first.submit((0, 0), job(0), keep=True)
        first.wait()
        mine = children() - others
        again = QualityPool(processes)
        assert not again.results and not again.kept
        again.submit((0, 0), job(0))
        again.wait()
        assert again.results == first.results and children() - others == mine and len(mine) == 1


def test_processes_that_were_ended_begin_again():
    """As for the next case of a sweep, after one that failed."""
    with MeasuringProcesses(1) as processes:
        pool = QualityPool(processes)
        pool.submit(0, attrs.evolve(job(1), rendered_size=(0, 0)))
        with pytest.raises(HmdwarpError):
            pool.wait()
        processes.close()
        again = QualityPool(processes)
        again.submit(0, job(0))
        again.wait()
        assert list(again.results) == [0]


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_waiting_is_until_all_is_measured(workers):
    with MeasuringProcesses(workers) as processes:
        pool = QualityPool(processes)
        pool.wait()
        for round_ in range(3):
            keys = [(round_, number) for number in range(5)]
            for key in keys:
                pool.submit(key, job(key[1]))
            pool.wait()
            assert [key for key in pool.results if key[0] == round_] == keys


def test_regions_come_with_the_jobs_that_ask_for_them():
    wanted = attrs.evolve(job(1), regions=True)
    with MeasuringProcesses(1) as processes:
        pool = QualityPool(processes)
        pool.submit((0, 0), wanted)
        pool.submit((1, 0), job(1))
        pool.wait()
    assert list(pool.regions) == [(0, 0)]
    assert pool.regions[0, 0] == measure(wanted).regions
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
    values = measure(QualityJob(now)).values
    missing = {name for name, value in values.items() if value is None}
    assert missing == {"flip", "ssim", "hole_share", "border_share", "flicker"}
    covered = np.zeros((30, 40))
    assert measure(QualityJob(now, covered=covered)).values["border_share"] is None
    assert measure(QualityJob(now, covered=covered)).values["hole_share"] == 1


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
    # A size of no pixels is our fault, not the input's.
    broken = attrs.evolve(job(1), rendered_size=(0, 0))
    with MeasuringProcesses(workers) as processes:
        pool = QualityPool(processes)
        with pytest.raises(HmdwarpError, match=r"measuring picture \(7, \d+\) failed: \w+Error: "):
            for key in range(50):  # far more than wait: no submit hangs
                pool.submit((7, key), broken)


def test_an_error_of_the_input_stays_one(monkeypatch):
    monkeypatch.setattr("hmdwarp.metrics.pool.measure", refused)
    pool = QualityPool(MeasuringProcesses(0))
    with pytest.raises(InputError, match=r"^measuring picture 3 failed: no such picture$"):
        pool.submit(3, job(1))


def refused(_: QualityJob) -> None:
    raise InputError("no such picture")


def test_a_worker_that_dies_is_one_clear_error():
    others = children()
    with MeasuringProcesses(1) as processes:
        pool = QualityPool(processes)
        pool.submit(0, job(0))
        pool.wait()
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
        pool = QualityPool(processes)
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


def test_leaving_by_an_exception_drops_the_rest():
    with pytest.raises(KeyboardInterrupt), MeasuringProcesses(2) as processes:
        pool = QualityPool(processes)
        for key in range(3):
            pool.submit(key, job(key))
        raise KeyboardInterrupt


def test_processes_without_work_are_none():
    with MeasuringProcesses(2) as processes:
        pool = QualityPool(processes)
        pool.wait()
    assert pool.results == {}


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
    return [stat for stat in Path("/proc").glob("[0-9]*/stat") if _session(stat) == process.pid and _works(stat)]


def test_ctrl_c_in_a_terminal(tmp_path):
    """The terminal signals the whole foreground process group.

    The loop alone hears it, and nothing is printed but its own words.
    """
    command = [sys.executable, "-X", "dev", "-W", "error", a_script(tmp_path)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
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


def _works(stat: Path) -> bool:
    try:
        return b"spawn_main" in (stat.parent / "cmdline").read_bytes()
    except OSError:
        return False


def _session(stat: Path) -> int:
    try:
        return int(stat.read_text().rsplit(")", 1)[1].split()[3])
    except OSError:
        return -1
