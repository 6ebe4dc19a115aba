"""hmdwarp study withdraw, as typed.

It tells what there is, asks, erases, and says what it cannot reach.
"""

from __future__ import annotations

import subprocess
import sys

import pytest
from commands import hmdwarp

from hmdwarp.study.store import PILOT, SIMULATED, Store

from .sessions import TEXT, begun, whole


@pytest.fixture
def study(tmp_path):
    """A study's file with two participants' data beside it."""
    (tmp_path / "late.toml").write_text(TEXT, encoding="utf-8")
    with Store(tmp_path / "late-data", create=True) as store:
        whole(store, "P01")
        whole(store, "P02")
    return tmp_path / "late.toml"


def ran(*words: object) -> subprocess.CompletedProcess:
    return hmdwarp("study", "withdraw", *words)


def codes(study) -> list[str]:
    with Store(study.with_name("late-data")) as store:
        return [session.code for session in store.contents().sessions]


@pytest.mark.filterwarnings(
    "ignore:This process .* is multi-threaded:DeprecationWarning"
)  # of pexpect's fork, where a test left threads
@pytest.mark.parametrize(
    ("answer", "left", "told"), [("y", ["P02"], "has withdrawn; erased"), ("n", ["P01", "P02"], "Nothing was")]
)
def test_it_asks_on_a_terminal(study, answer, left, told):
    pexpect = pytest.importorskip("pexpect")
    words = ["-m", "hmdwarp", "study", "withdraw", str(study), "p01"]
    screen = pexpect.spawn(sys.executable, words, encoding="utf-8", timeout=120, dimensions=(24, 200))
    screen.expect("Participant P01 in .*: 1 session, .*revisions included.*Exports call .*Erase it for good.*: ")
    screen.sendline(answer)
    screen.expect(told)
    screen.expect(pexpect.EOF)
    screen.close()
    assert screen.exitstatus == 0 and codes(study) == left


def test_no_terminal_needs_yes(study):
    done = ran(study, "P01")
    assert done.returncode == 2 and "--yes" in done.stderr and codes(study) == ["P01", "P02"]


def test_not_while_a_session_runs(study):
    with Store(study.with_name("late-data")) as store:
        begun(store, "P03")
        done = ran(study, "P01", "--yes")
    assert done.returncode == 3 and "running already" in done.stderr and done.stderr.count("\n") == 1
    assert codes(study) == ["P01", "P02", "P03"]


def test_pilots_and_simulated_participants_withdraw_from_stores_of_their_own(study):
    for origin in (PILOT, SIMULATED):
        with Store(study.with_name(f"late-{origin}-data"), create=True) as store:
            whole(store, "P01", origin=origin)
            (session,) = store.contents(pilot=origin == PILOT).sessions
        done = ran(study, "P01", "--yes", f"--{origin}")
        holds, word, erased = done.stdout.splitlines()
        assert done.returncode == 0 and erased.startswith("Participant P01 has withdrawn; erased: 1 session")
        assert holds.startswith("Participant P01 in ") and ": 1 session" in holds and f" {session.sub}: " in word
    assert codes(study) == ["P01", "P02"]
    both = ran(study, "P01", "--yes", "--pilot", "--simulated")
    assert both.returncode == 2 and "never mixed" in both.stderr


def test_a_broken_plan_does_not_prevent_withdrawal(study):
    study.write_text("title = ", encoding="utf-8")
    assert ran(study, "P01", "--yes").returncode == 2
    done = ran(study, "P01", "--yes", "--store", study.with_name("late-data"))
    assert done.returncode == 0 and codes(study) == ["P02"]


def test_no_data_and_no_such_participant(study, tmp_path):
    for words, told in (
        ((study, "P99"), "P99 is not known here"),
        ((study, "P01", "--store", tmp_path / "x"), "holds no data of a study"),
    ):
        done = ran(*words, "--yes")
        assert done.returncode == 2 and told in done.stderr and done.stderr.count("\n") == 1
