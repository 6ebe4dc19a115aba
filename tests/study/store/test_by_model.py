"""Whatever is done to a store, in whatever order, it holds what a dictionary would.

Checked by hypothesis, reopened at any time.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import attrs
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, consumes, initialize, invariant, precondition, rule

from hmdwarp.base import HmdwarpError, InputError
from hmdwarp.study.store import COMPLETE, INTERRUPTED, PERSON, PILOT, SICK, STOPPED, UNCONSENTED, Store

from .sessions import asks, begun, design, shows

CODES = [f"P{k}" for k in range(6)]


@attrs.define
class Told:
    """What a session was told."""

    code: str
    origin: str
    part: str
    row: int
    status: str = "running"
    consented: bool = False
    answers: dict = attrs.field(factory=dict)  # (key, revision) to value
    showings: dict = attrs.field(factory=dict)  # (key, presentation) to complete
    remarks: list = attrs.field(factory=list)


class StoreByModel(RuleBasedStateMachine):
    """Sessions of six people and pilots. The store is closed and opened, or its program dies, in
    between.
    """

    running = Bundle("running")

    @initialize()
    def make(self):
        self.folder = Path(tempfile.mkdtemp(prefix="store-"))
        self.store = Store(self.folder / "data", create=True)
        self.told: dict[int, Told] = {}
        self.newest = 0
        self.withdrawn: set[str] = set()

    def teardown(self):
        self.store.close()
        shutil.rmtree(self.folder)

    def of(self, code):
        return [session for session in self.told.values() if session.code == code]

    @rule(
        target=running,
        code=st.sampled_from(CODES),
        origin=st.sampled_from([PERSON, PERSON, PILOT]),
        part=st.sampled_from(["one", "two"]),
        again=st.booleans(),
    )
    def begin(self, code, origin, part, again):
        known = self.of(code)
        refused = code in self.withdrawn or bool(known) != again or any(session.origin != origin for session in known)
        if refused:
            with pytest.raises(InputError):
                self.store.would_begin(design(), part, code, origin, new_session=again)
        else:
            self.store.would_begin(design(), part, code, origin, new_session=again)
        try:
            session = begun(self.store, code, part, origin, new_session=again)
        except InputError:
            assert refused
            return None
        assert not refused and session.number == len(known) + 1 and session.id > self.newest
        self.newest = session.id  # no id comes twice, of those who withdrew neither
        held = [
            session.row
            for session in self.told.values()
            if (session.origin, session.part) == (origin, part) and session.status not in (STOPPED, SICK, UNCONSENTED)
        ]
        rows = {"one": 4, "two": 2}[part]
        assert held.count(session.row) == min(held.count(row) for row in range(rows)), "the least filled order"
        self.told[session.id] = Told(code, origin, part, session.row)
        return session

    def is_on(self, session):
        return session is not None and session.id in self.told and self.told[session.id].status == "running"

    @rule(session=running)
    def agree(self, session):
        if self.is_on(session):
            self.store.finish_step(session, "consent")
            self.told[session.id].consented = True

    @rule(
        session=running,
        number=st.integers(0, 8),
        value=st.one_of(st.none(), st.floats(allow_nan=False, allow_infinity=False)),
    )
    def answer(self, session, number, value):
        if self.is_on(session):
            ask = asks(session)[number % len(asks(session))]
            told = self.told[session.id].answers
            revision = 1 + sum(key == ask.key for key, _ in told)
            assert self.store.answer(session, ask, value, 1.0, "participant").revision == revision
            told[ask.key, revision] = value

    @rule(session=running, number=st.integers(0, 4), ends=st.sampled_from([None, False, True]), traced=st.booleans())
    def show(self, session, number, ends, traced):
        if self.is_on(session):
            step = shows(session)[number % len(shows(session))]
            told = self.told[session.id].showings
            presentation = 1 + sum(key == step.key for key, _ in told)
            showing = self.store.begin_showing(session, step, step.condition.settings, recorded=traced)
            if traced:
                with (self.store.traces / showing.trace).open("x") as file:  # never there before
                    file.write("time_ns\n")
            if ends is not None:
                self.store.end_showing(session, showing, {}, complete=ends)
            told[step.key, presentation] = bool(ends)

    @rule(session=running, text=st.text(max_size=20))
    def remark(self, session, text):
        if self.is_on(session):
            self.store.record(session, "remark", text=text)
            self.told[session.id].remarks.append(text)

    @rule(session=consumes(running), status=st.sampled_from([COMPLETE, STOPPED, SICK, INTERRUPTED]))
    def end(self, session, status):
        if self.is_on(session):
            told = self.told[session.id]
            told.status = UNCONSENTED if status == STOPPED and not told.consented else status
            assert self.store.end(session, status).status == told.status
            with pytest.raises(HmdwarpError, match="nothing more can be stored"):
                self.store.answer(session, asks(session)[0], 3, 1.0, "participant")

    @rule(target=running, code=st.sampled_from(CODES))
    def resume(self, code):
        parts = {session.part for session in self.of(code) if session.status == INTERRUPTED}
        try:
            would = self.store.would_resume(code)
            session = self.store.resume(code)
            assert would.id == session.id
        except InputError as error:
            assert len(parts) != 1 and ("several parts" in str(error)) == (len(parts) > 1)
            return None
        assert self.told[session.id].code == code and self.told[session.id].status == INTERRUPTED
        self.told[session.id].status = "running"
        return session

    @rule()
    def reopen(self):
        """As a program that died: nothing was ended. The next that writes finds what still runs
        interrupted.
        """
        self.store.close()
        self.store = Store(self.folder / "data", create=True)
        if self.store.name:
            self.store._take_lock()
        for session in self.told.values():
            session.status = INTERRUPTED if session.status == "running" else session.status

    @precondition(lambda self: self.store.name)
    @rule(code=st.sampled_from(CODES))
    def withdraw(self, code):
        try:
            held = self.store.holdings(code)
        except InputError:
            assert code in self.withdrawn or not self.of(code)
            return
        mine = self.of(code)
        assert (held.sessions, held.answers) == (len(mine), sum(len(session.answers) for session in mine))
        assert self.store.withdraw(code) == held
        self.withdrawn.add(code)
        self.told = {id_: one for id_, one in self.told.items() if one.code != code}

    @invariant()
    def is_as_told(self):
        if not self.store.name:
            assert not self.told
            return
        for pilot in (False, True):
            found = self.store.contents(pilot=pilot)
            told = {id_: one for id_, one in self.told.items() if (one.origin == PILOT) == pilot}
            assert {
                session.id: (session.code, session.origin, session.part, session.row, session.status, session.consented)
                for session in found.sessions
            } == {
                id_: (one.code, one.origin, one.part, one.row, one.status, one.consented) for id_, one in told.items()
            }
            answers = [((answer.session, answer.key, answer.revision), answer.value) for answer in found.answers]
            assert len(dict(answers)) == len(answers)
            assert dict(answers) == {
                (id_, *key): value for id_, one in told.items() for key, value in one.answers.items()
            }
            showings = {
                (showing.session, showing.key, showing.presentation): showing.complete for showing in found.showings
            }
            assert showings == {(id_, *key): value for id_, one in told.items() for key, value in one.showings.items()}
            for session in found.sessions:
                one = told[session.id]
                counting = {key: value for (key, _), value in sorted(one.answers.items(), key=lambda each: each[0][1])}
                assert {answer.key: answer.value for answer in self.store.answers(session)} == counting
                seen = {key for (key, _), complete in one.showings.items() if complete}
                assert self.store.done(session) == {*counting, *seen, *(["consent"] if one.consented else [])}
            remarks = [(event.session, event.data["text"]) for event in found.events if event.kind == "remark"]
            assert sorted(remarks) == sorted((id_, text) for id_, one in told.items() for text in one.remarks)
            assert found.withdrawn == len(self.withdrawn)


TestStoreByModel = StoreByModel.TestCase
TestStoreByModel.settings = settings(max_examples=40, stateful_step_count=30, suppress_health_check=list(HealthCheck))
