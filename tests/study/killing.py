"""Sessions of the real program that are killed again and again, until so many kills are done.

And what must be true of the store then.

A kill is SIGKILL: no handler runs, what the program had not given to the kernel is gone. What the
kernel has not given to the disk stays, so this is no test of a power cut; that every commit is
followed by an fsync is asked of SQLite (synchronous=FULL), and tests/study/store looks at that.
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
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import attrs
import numpy as np

from hmdwarp.errors import InputError
from hmdwarp.poses import load_trace
from hmdwarp.study.design import Ask, Show, load_design, steps_of
from hmdwarp.study.respondents import Population, load_model, person_of
from hmdwarp.study.store import COMPLETE, Contents, Session, Store

from . import tiny

PHASES = {"answer": "after an answer", "showing": "while showing", "shown": "after a trial", "event": "after an event"}
COLD = 0.2  # share of lives that begin with the start of Python
SHORTLY_S = (1e-5, 0.02)  # after a line of the witness: at once, in the middle of the next commit, or between two


@attrs.frozen
class Life:
    """One run of the program.

    told: lines of the witness. status: as waitpid has it, negative for a signal. seconds: how long
    it was.
    """

    told: list[list]
    status: int
    seconds: float
    said: str

    @property
    def is_killed(self) -> bool:
        return self.status == -signal.SIGKILL

    @property
    def phase(self) -> str:
        """What it was about when it ended."""
        if not self.told:
            return "starting"
        return PHASES[self.told[-1][0]]


class Cold:
    """A program started as anybody starts it: 0.7 s of 1.3 go into imports.

    told, said: pipes that it writes to.
    """

    def __init__(self, arguments: list[str], told: int, said: int) -> None:
        command = [sys.executable, "-m", "tests.study.witness", str(told), *arguments]
        self._process = subprocess.Popen(
            command, pass_fds=[told], stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT, cwd=tiny.ROOT
        )

    def kill(self) -> None:
        self._process.kill()

    def wait(self) -> int:
        return self._process.wait(tiny.PATIENCE_S)


class Nursery:
    """Programs forked from one that has everything imported.

    A context manager; calling it starts one, one at a time.
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
        self._pid = int(self._lines.readline())
        return self

    def kill(self) -> None:
        with suppress(ProcessLookupError):  # it has come to its end by itself
            os.kill(self._pid, signal.SIGKILL)

    def wait(self) -> int:
        return int(self._lines.readline())


def live(
    start: type[Cold] | Nursery, arguments: list[str], *, after_s: float | None = None, after_line: int | None = None
) -> Life:
    """Run the program and kill it: after so long.

    Or after so many lines of its witness, and `after_s` more. None for both lets it live.
    """
    (told, told_by), (said, said_by) = os.pipe(), os.pipe()
    lines: list[list] = []
    started = time.monotonic()
    process = start(arguments, told_by, said_by)
    os.close(told_by)
    os.close(said_by)
    timer = threading.Timer(after_s, process.kill) if after_s is not None and after_line is None else None
    if timer is not None:
        timer.start()
    with os.fdopen(told) as pipe:  # its end is the end of the program
        for line in pipe:
            lines.append(json.loads(line))
            if len(lines) == after_line:
                time.sleep(after_s or 0.0)
                process.kill()
    if timer is not None:
        timer.cancel()
        timer.join()
    with os.fdopen(said) as pipe:
        return Life(lines, process.wait(), time.monotonic() - started, pipe.read())


@attrs.define
class Killed:
    """Sessions of one study until `kills` of its runs were killed and the last session is complete.

    told: by all witnesses. tally: what the program was about when it was killed. codes: whose
    sessions.
    """

    folder: Path
    seed: int
    kills: int
    told: list[list] = attrs.field(factory=list)
    tally: Counter = attrs.field(factory=Counter)
    codes: list[str] = attrs.field(factory=list)

    def run(self) -> None:
        """All of it."""
        study, model = tiny.write(self.folder)
        chance = random.Random(self.seed)
        with Nursery() as nursery:
            first = tiny.session(study, model, "first", "--store", str(self.folder / "first"))
            live(nursery, first)
            # How long and how talkative a life is.
            usual = {start: live(start, [*first, "--new-session"]) for start in (nursery, Cold)}
            assert all(run.status == 0 for run in usual.values()), usual
            while not self.is_enough:
                self.codes.append(f"person-{len(self.codes) + 1}")
                self._session(tiny.session(study, model, self.codes[-1], "--store", str(self.store)), chance, usual)

    @property
    def is_enough(self) -> bool:
        """Whether so many were killed, most of them in a session: a slow machine starts slowly."""
        count = sum(self.tally.values())
        return count >= self.kills and self.tally["starting"] < count / 2

    @property
    def store(self) -> Path:
        """Where the data are."""
        return self.folder / "data"

    def _session(self, arguments: list[str], chance: random.Random, usual: dict[Callable, Life]) -> None:
        """One participant's, killed until it is over or there were kills enough."""
        while (status := self.status()) != COMPLETE:  # it may be killed after its end, during the last plate
            start = chance.choices(list(usual), (1 - COLD, COLD))[0]
            one = live(start, [*arguments, *(["--resume"] if status else [])], **self._moment(chance, usual[start]))
            self.told += one.told
            if one.is_killed:
                self.tally[one.phase] += 1
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
        """Of the session, as somebody else who reads the store sees it.

        "" where there is none to go on with.
        """
        try:
            store = Store(self.store)
        except InputError:  # there is none yet, or one that was not made to its end
            return ""
        with store:
            return next((session.status for session in store.contents().sessions if session.code == self.codes[-1]), "")


def faults(killed: Killed) -> list[str]:
    """What is wrong with the store, in words; nothing, if nothing was lost."""
    with Store(killed.store) as store:
        contents = store.contents()
    out = [*_of_the_file(killed.store), *_of_the_told(killed, contents)]
    for session in contents.sessions:
        out += [
            f"{session.code}: {fault}"
            for fault in (*_of_session(killed, contents, session), *_of_answers(killed, contents, session))
        ]
    if sorted(session.code for session in contents.sessions) != sorted(killed.codes):
        out.append(f"sessions of {[session.code for session in contents.sessions]}, and {killed.codes} had one each")
    return [*out, *_of_orders(contents)]


def _of_the_file(store: Path) -> list[str]:
    with sqlite3.connect(store / "study.sqlite3") as db:
        found = db.execute("PRAGMA integrity_check").fetchone()[0]
        astray = db.execute("PRAGMA foreign_key_check").fetchall()
    db.close()
    return [f"integrity_check: {found}, {astray}"] if found != "ok" or astray else []


def _of_the_told(killed: Killed, contents: Contents) -> list[str]:
    """Everything that was confirmed is there as it was confirmed, once.

    And what is there unconfirmed is at most the last of each kill.
    """
    code_of = {session.id: session.code for session in contents.sessions}
    there = Counter((code_of[answer.session], answer.key, answer.revision, answer.value) for answer in contents.answers)
    confirmed = Counter(tuple(line[1:]) for line in killed.told if line[0] == "answer")
    out = [f"confirmed and missing: {lost}" for lost in confirmed - there]
    out += [f"there {count} times: {one}" for one, count in there.items() if count > 1]
    out += [f"confirmed {count} times: {one}" for one, count in confirmed.items() if count > 1]
    unconfirmed = there - confirmed
    if unconfirmed.total() > (kills := sum(killed.tally.values())):
        out.append(f"{unconfirmed.total()} answers that nobody was told of, by {kills} kills")
    shown = {
        (code_of[showing.session], showing.key, showing.presentation, showing.complete) for showing in contents.showings
    }
    out += [
        f"shown and missing: {line[1:]}" for line in killed.told if line[0] == "shown" and tuple(line[1:]) not in shown
    ]
    events = Counter((code_of[event.session], event.kind, event.key) for event in contents.events)
    told = Counter(tuple(line[1:]) for line in killed.told if line[0] == "event")
    written = Counter(
        (event.session, event.key, event.data["revision"], event.data["value"])
        for event in contents.events
        if event.kind == "answer"
    )
    kept = Counter((answer.session, answer.key, answer.revision, answer.value) for answer in contents.answers)
    out += [f"an answer and its line in the journal are not one: {one}" for one in (written - kept) + (kept - written)]
    return out + [f"journal lines missing: {lost}" for lost in told - events]


def _of_session(killed: Killed, contents: Contents, session: Session) -> list[str]:
    """It is complete, each question has one answer that counts, each trial was seen to its end."""
    design = load_design(str(killed.folder / "tiny.toml"))
    steps = steps_of(design, session.order, session.part)
    asked = sorted(step.key for step in steps if isinstance(step, Ask))
    with Store(killed.store) as store:
        counting, done = store.answers(session), store.done(session)
    out = [] if session.status == COMPLETE else [f"is {session.status}"]
    if sorted(step.key for step in counting) != asked:
        out.append(f"answers to {sorted(step.key for step in counting)}, and {asked} were asked")
    out += [f"{step.key} is not done" for step in steps if step.key not in done]
    showings = [showing for showing in contents.showings if showing.session == session.id]
    whole = {showing.id: showing for showing in showings if showing.complete}
    for step in steps:
        if isinstance(step, Show) and not any(showing.key == step.key for showing in whole.values()):
            out.append(f"{step.key} was never seen to its end")
    for showing in whole.values():
        if len(load_trace(killed.store / "traces" / showing.trace).track.time_ns) < 2:
            out.append(f"{showing.trace} has no motion")
        if not showing.actual.get("pictures"):
            out.append(f"{showing.key}: complete, and nobody knows what was shown")
    for answer in (step for step in counting if step.trial):
        about = whole.get(answer.showing)
        if about is None or about.key != f"trial/{answer.trial}":
            out.append(f"{answer.key} is about {about}")
    return out


def _of_answers(killed: Killed, contents: Contents, session: Session) -> list[str]:
    """They are those of a session that nobody killed: going on changes nobody's mind."""
    design, model = load_design(str(killed.folder / "tiny.toml")), load_model(killed.folder / "people.toml")
    usual = Population(model, design, session.part).of([person_of(session.code)], design.seed, orders=[session.order])
    out = []
    for answer in contents.answers:
        if answer.session == session.id and answer.scale == "grade":
            value = usual.answers["grade"][0, answer.trial - 1]
            meant = None if np.isnan(value) else value
            if answer.value != meant:
                out.append(f"{answer.key}: {answer.value}, where {meant} was meant")
    return out


def _of_orders(contents: Contents) -> list[str]:
    """Nobody's order was given twice by a session that was killed while it began."""
    rows = Counter(session.row for session in contents.sessions)
    counts = [rows[row] for row in range(4)]
    return [] if max(counts) - min(counts) <= 1 else [f"orders taken {counts} times"]
