"""Sessions of the real program that are killed again and again, until so many kills are done.

And what must be true of the store then.

A kill is SIGKILL: no handler runs, what the program had not given to the kernel is gone. What the
kernel has not given to the disk stays, so this is no test of a power cut; that every commit is
followed by an fsync is asked of SQLite (synchronous=FULL), and tests/study/store looks at that.

STUDY_KILLS (8) says how many, STUDY_KILL_SEED which moments; `make test-kill` does 500.
"""

from __future__ import annotations

import json
import math
import os
import random
import signal
import socket
import sqlite3
import subprocess
import sys
import threading
import time
from collections import Counter
from contextlib import closing, suppress
from pathlib import Path

import attrs
import numpy as np
import pytest

from hmdwarp.base import InputError
from hmdwarp.poses import load_trace
from hmdwarp.study.design import Ask, Show, load_design, steps_of
from hmdwarp.study.respondents import answers_of, load_model, person_of
from hmdwarp.study.store import COMPLETE, Answer, Contents, Session, Store

from . import tiny

PHASES = {"answer": "after an answer", "showing": "while showing", "shown": "after a trial", "event": "after an event"}
KILLS, SEED = (int(os.environ.get(name, usual)) for name, usual in (("STUDY_KILLS", "8"), ("STUDY_KILL_SEED", "1")))
SHORTLY_S = (1e-5, 0.02)  # after a line of the witness: at once, in the middle of the next commit, or between two


@attrs.frozen
class Life:
    """One run of the program."""

    told: list[list]  # lines of the witness
    status: int  # as waitpid has it, negative for a signal
    seconds: float
    said: str


class Nursery:
    """Programs forked from one that has everything imported. A context manager; calling it starts
    one, one at a time.
    """

    def __enter__(self) -> Nursery:
        self._link, theirs = socket.socketpair()
        command = [sys.executable, "-m", "tests.study.witness", str(theirs.fileno())]
        self._process = subprocess.Popen(command, pass_fds=[theirs.fileno()], cwd=tiny.ROOT)
        theirs.close()
        self._link.settimeout(tiny.PATIENCE_S)
        self._lines = self._link.makefile()
        return self

    def __exit__(self, *_: object) -> None:
        self._lines.close()
        self._link.close()
        self._process.kill()
        self._process.wait()

    def __call__(self, arguments: list[str], told: int, said: int) -> Nursery:
        socket.send_fds(self._link, [json.dumps(arguments).encode()], [told, said])
        self._pid = self.wait()
        return self

    def kill(self) -> None:
        with suppress(ProcessLookupError):  # it has come to its end by itself
            os.kill(self._pid, signal.SIGKILL)

    def wait(self) -> int:
        return int(self._lines.readline())


def live(start: Nursery, arguments: list[str], *, after_s: float | None = None, after_line: int | None = None) -> Life:
    """Run the program and kill it after so long, or so long after so many lines of its witness."""
    (told, told_by), (said, said_by) = os.pipe(), os.pipe()
    lines: list[list] = []
    started = time.monotonic()
    process = start(arguments, told_by, said_by)
    os.close(told_by)
    os.close(said_by)
    timer = threading.Timer(after_s or 0.0, process.kill)
    if after_s is not None and after_line is None:
        timer.start()
    with os.fdopen(told) as pipe:  # its end is the end of the program
        for line in pipe:
            lines.append(json.loads(line))
            if len(lines) == after_line:
                time.sleep(after_s or 0.0)
                process.kill()
    if timer.ident is not None:
        timer.cancel()
        timer.join()
    with os.fdopen(said) as pipe:
        return Life(lines, process.wait(), time.monotonic() - started, pipe.read())


@attrs.define
class Killed:
    """Sessions of a study until `kills` runs were killed and the last session is complete."""

    folder: Path
    seed: int
    kills: int
    told: list[list] = attrs.field(factory=list)  # by all witnesses
    tally: Counter = attrs.field(factory=Counter)  # what the program was about when it was killed
    codes: list[str] = attrs.field(factory=list)  # whose sessions

    def run(self) -> None:
        """All of it."""
        study, model = tiny.write(self.folder)
        chance = random.Random(self.seed)
        with Nursery() as nursery:
            first = tiny.session(study, model, "first", "--store", str(self.folder / "first"))
            live(nursery, first)
            usual = live(nursery, [*first, "--new-session"])  # how long and how talkative a life is
            assert usual.status == 0, usual
            while not self.is_enough:
                self.codes.append(f"person-{len(self.codes) + 1}")
                arguments = tiny.session(study, model, self.codes[-1], "--store", str(self.store))
                # It may be killed after its end, during the last plate.
                while (status := self.status()) != COMPLETE:
                    again = ["--resume"] if status else []
                    self._take(live(nursery, [*arguments, *again], **self._moment(chance, usual)))

    @property
    def is_enough(self) -> bool:
        """Whether so many were killed, most of them in a session: a slow machine starts slowly."""
        count = sum(self.tally.values())
        return count >= self.kills and self.tally["starting"] < count / 2

    @property
    def store(self) -> Path:
        """Where the data are."""
        return self.folder / "data"

    def _take(self, one: Life) -> None:
        self.told += one.told
        if one.status == -signal.SIGKILL:
            self.tally[PHASES[one.told[-1][0]] if one.told else "starting"] += 1
        else:
            assert one.status == 0, f"seed {self.seed}: {one.status} {one.said}"

    def _moment(self, chance: random.Random, usual: Life) -> dict:
        """Half of them at any time of a life, half shortly after something was stored, where
        commits are close to each other.
        """
        if self.is_enough:
            return {}
        if chance.random() < 0.5:
            return {"after_s": chance.uniform(0, usual.seconds)}
        shortly_s = math.exp(chance.uniform(*map(math.log, SHORTLY_S)))
        return {"after_line": chance.randint(1, len(usual.told)), "after_s": shortly_s}

    def status(self) -> str:
        """Of the session, as somebody else who reads the store sees it. "" where there is none to
        go on with.
        """
        try:
            with Store(self.store) as store:
                found = store.contents().sessions
        except InputError:  # there is none yet, or one that was not made to its end
            return ""
        return next((session.status for session in found if session.code == self.codes[-1]), "")


def check(killed: Killed) -> None:
    """Nothing is wrong with the store, and nothing was lost."""
    with Store(killed.store) as store:
        contents = store.contents()
        for session in contents.sessions:
            check_session(killed, contents, session, store.answers(session), store.done(session))
    with closing(sqlite3.connect(killed.store / "study.sqlite3")) as db:
        assert db.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert db.execute("PRAGMA foreign_key_check").fetchall() == []
    code_of = {session.id: session.code for session in contents.sessions}
    assert sorted(code_of.values()) == sorted(killed.codes), "one session each"
    rows = Counter(session.row for session in contents.sessions)
    assert max(rows.values()) - min(rows[row] for row in range(4)) <= 1, "orders are taken evenly"
    # What was confirmed is there as it was confirmed, once. What is there unconfirmed is at most
    # the last of each kill.
    told = {kind: Counter(tuple(line[1:]) for line in killed.told if line[0] == kind) for kind in PHASES}
    there = Counter((code_of[one.session], one.key, one.revision, one.value) for one in contents.answers)
    assert not told["answer"] - there
    assert {*there.values(), *told["answer"].values()} == {1}
    assert (there - told["answer"]).total() <= killed.tally.total()
    shown = {(code_of[one.session], one.key, one.presentation, one.complete) for one in contents.showings}
    assert told["shown"].keys() <= shown
    assert not told["event"] - Counter((code_of[event.session], event.kind, event.key) for event in contents.events)
    given = [event for event in contents.events if event.kind == "answer"]
    journal = Counter((code_of[one.session], one.key, one.data["revision"], one.data["value"]) for one in given)
    assert journal == there


def check_session(killed: Killed, contents: Contents, session: Session, counting: list[Answer], done: set[str]) -> None:
    """It is complete, each question has one answer that counts, each trial was seen to its end, and
    the answers are those of a session that nobody killed: going on changes nobody's mind.
    """
    design, model = load_design(str(killed.folder / "tiny.toml")), load_model(killed.folder / "people.toml")
    steps = steps_of(design, session.order, session.part)
    assert session.status == COMPLETE and {step.key for step in steps} <= done
    assert sorted(one.key for one in counting) == sorted(step.key for step in steps if isinstance(step, Ask))
    whole = {one.id: one for one in contents.showings if one.session == session.id and one.complete}
    assert {step.key for step in steps if isinstance(step, Show)} <= {showing.key for showing in whole.values()}
    for showing in whole.values():
        assert showing.actual["pictures"], "nobody knows what was shown"
        assert len(load_trace(killed.store / "traces" / showing.trace).track.time_ns) > 1
    usual = answers_of(model, design, session.part, design.seed, person_of(session.code), session.order)
    for answer in (one for one in counting if one.trial):
        assert whole[answer.showing].key == f"trial/{answer.trial}"
        if answer.scale == "grade":
            assert np.array_equal(usual.ratings["grade"][answer.trial - 1], answer.value or np.nan, equal_nan=True)


@pytest.mark.slow(20)
def test_killing_the_program_loses_nothing(tmp_path, capsys):
    killed = Killed(tmp_path, SEED, KILLS)
    killed.run()
    check(killed)
    answers = sum(line[0] == "answer" for line in killed.told)
    with capsys.disabled():
        told = ", ".join(f"{count} {phase}" for phase, count in sorted(killed.tally.items()))
        sessions = f"{len(killed.codes)} sessions, {answers} confirmed answers"
        print(f"\n{sum(killed.tally.values())} kills, seed {SEED} ({told}): {sessions}, all there once")
