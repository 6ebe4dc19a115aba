"""Closing words of a session, however it ended: what is stored, where, and what comes next."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from contextlib import suppress

from ...errors import HmdwarpError
from ...report import counted
from ...run import Recorder
from ..design import Design
from ..store import INTERRUPTED, PERSON, PILOT, Session, Store
from .session_options import SessionOptions


class ClosingWords:
    """Closing words of one run of the program."""

    def __init__(
        self,
        options: SessionOptions,
        design: Design,
        store: Store,
        say: Callable[[str], None],
        on_end: Callable[[Session], None],
    ) -> None:
        self._options, self._design, self._store, self._say, self._on_end = options, design, store, say, on_end
        self.session: Session | None = None  # None until there is one
        self.recording: Callable[[], Recorder | None] = lambda: None  # of the trial under way
        self.quiet = False  # whether an error says it all

    @property
    def how_to_resume(self) -> str:
        """Sentence with the command that resumes the session."""
        assert self.session is not None
        several = len(self._design.parts) > 1
        return f"resume with: {self._options.command(self.session.code, self.session.part, several)}"

    def say(self) -> None:
        """Say them, once everything else is closed."""
        if self.session is None or self.quiet:
            return
        for line in self._lines(self.session):
            self._say(line)
        self._on_end(self.session)

    def _lines(self, session: Session) -> list[str]:
        origin = "" if session.origin == PERSON else f" ({session.origin})"
        why = f": {session.why}" if session.why else ""
        lines = [
            f"participant {session.code}{origin}, session {session.number}, part {session.part}: {session.status}{why}"
        ]
        with suppress(HmdwarpError):  # a full disk may not even be readable
            answers = self._store.answers(session)
            rated = sum(answer.phase == "trial" and answer.value is not None for answer in answers)
            count = f"{counted(len(answers), 'answer')}, {rated} of them about trials" if answers else "no answers"
            lines.append(f"stored in {self._store.folder}: {count}")
            lines += self._still(session)
        lines.append(self.how_to_resume if session.status == INTERRUPTED else self._next())
        return lines

    def _still(self, session: Session) -> list[str]:
        """Say in how many trials the head hardly moved."""
        shown = self._store.contents(pilot=session.origin == PILOT).showings
        trials = {
            showing.key: showing
            for showing in shown
            if showing.session == session.id and showing.complete and showing.trial
        }
        still = sum(bool(showing.actual.get("head_still")) for showing in trials.values())
        of = f"{still} of {counted(len(trials), 'trial')}"
        return [f"the head hardly moved in {of}: almost a still picture was rated (head_still)"] if still else []

    def _next(self) -> str:
        words = ["hmdwarp", "study", "export", self._options.study, "--out", "DIR"]
        words += ["--store", str(self._options.store)] if self._options.store is not None else []
        words += [f"--{self._options.origin}"] if self._options.origin != PERSON else []
        return f"next: another participant, or {shlex.join(words)}"

    def explained(self, error: HmdwarpError) -> HmdwarpError:
        """Return the same error with how to resume: it is the only line that will be read."""
        self.quiet = True
        if self.session is None:
            return error
        return type(error)(f"{error}; what was answered before is stored, {self.how_to_resume}")

    def last_words(self) -> str:
        """Return the words for the watchdog, which ends the program; answers are on the disk."""
        recorder = self.recording()
        saved = recorder.save() if recorder is not None else ""
        if self.session is None:
            return ""
        return "; ".join(filter(None, (saved, "what was answered is stored", self.how_to_resume)))
