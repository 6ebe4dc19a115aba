"""What is told when a sitting is over, however it ended: what there is, where, and what comes next."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from contextlib import suppress

from ...errors import HmdwarpError
from ...run.live.recorder import Recorder
from ..design import Design
from ..store import INTERRUPTED, PERSON, Session, Store
from .options import RunSession


class Afterwards:
    """session: None as long as there is none. recording: of the trial under way. quiet: an error tells it all. told: as run_session has
    it."""

    def __init__(
        self,
        options: RunSession,
        design: Design,
        store: Store,
        say: Callable[[str], None],
        told: Callable[[Session], None],
    ) -> None:
        self._options, self._design, self._store, self._say, self._told = options, design, store, say, told
        self.session: Session | None = None
        self.recording: Callable[[], Recorder | None] = lambda: None
        self.quiet = False

    @property
    def go_on(self) -> str:
        """How to go on with it."""
        assert self.session is not None
        return f"go on with: {self._options.command(self.session.code, self.session.part, len(self._design.parts) > 1)}"

    def tell(self) -> None:
        """Once everything else is closed."""
        if self.session is None or self.quiet:
            return
        for line in self.lines():
            self._say(line)
        self._told(self.session)

    def lines(self) -> list[str]:
        """What happened to whom, what is stored, and what is next."""
        session = self.session
        assert session is not None
        beside = "" if session.origin == PERSON else f" ({session.origin})"
        why = f": {session.why}" if session.why else ""
        lines = [
            f"participant {session.code}{beside}, session {session.number}, part {session.part}: {session.status}{why}"
        ]
        with suppress(HmdwarpError):  # a disk that is full may not even be read
            answers = self._store.answers(session)
            rated = sum(one.phase == "trial" and one.value is not None for one in answers)
            lines.append(
                f"stored in {self._store.folder}: {_count(len(answers), 'answer')}, {rated} of them about trials"
            )
        lines.append(self.go_on if session.status == INTERRUPTED else self._next())
        return lines

    def _next(self) -> str:
        words = ["hmdwarp", "study", "export", self._options.study, "--out", "DIR"]
        words += ["--store", str(self._options.store)] if self._options.store is not None else []
        words += [f"--{self._options.origin}"] if self._options.origin != PERSON else []
        return f"next: another participant, or {shlex.join(words)}"

    def explained(self, error: HmdwarpError) -> HmdwarpError:
        """The same error, with how to go on: it is the one line that will be read."""
        self.quiet = True
        return (
            type(error)(f"{error}; what was answered before is stored, {self.go_on}")
            if self.session is not None
            else error
        )

    def last_words(self) -> str:
        """For the watchdog, which ends the program. The store needs nothing: all of it is on the disk."""
        recorder = self.recording()
        saved = recorder.save() if recorder is not None else ""
        return (
            "; ".join(filter(None, (saved, "what was answered is stored", self.go_on)))
            if self.session is not None
            else ""
        )


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number or 'no'} {what}s"
