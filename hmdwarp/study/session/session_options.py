"""Options of a session."""

from __future__ import annotations

import shlex
from pathlib import Path

import attrs

from ...errors import InputError
from ...run.options import AUTO_SOURCE, DESKTOP, OFFSCREEN, OPENXR, SOURCES
from ..console import KINDS as CONSOLES
from ..store import PERSON, PILOT, SIMULATED


@attrs.frozen(kw_only=True)
class SessionOptions:
    """Options of `hmdwarp study run`. Errors: InputError for options that contradict each other."""

    study: str  # a file, or the name of a shipped study
    participant: str  # a code, or "new"
    part: str | None = None  # of the plan; None where it has but one
    resume: bool = False  # continue an interrupted session
    new_session: bool = False  # a further session of a known participant
    pilot: bool = False  # a rehearsal, kept apart from people
    simulate: str | None = None  # response model that answers in place of a person
    source: str = AUTO_SOURCE  # as in LiveOptions
    trace: str = ""  # as in LiveOptions
    # Folder of the data; None for the study's own.
    store: Path | None = attrs.field(default=None, converter=attrs.converters.optional(Path))
    console: str = "auto"  # one of console.KINDS

    def __attrs_post_init__(self) -> None:
        if self.source not in SOURCES:
            raise InputError(f"--source {self.source}: wanted {', '.join(SOURCES)}")
        if self.console not in CONSOLES:
            raise InputError(f"--console {self.console}: wanted {', '.join(CONSOLES)}")
        if self.resume and self.new_session:
            raise InputError("--resume continues a session, --new-session begins another: leave one of the two out")
        if self.resume and self.participant.lower() == "new":
            raise InputError(
                "--participant new draws a code for a new person: --resume needs the code of the interrupted one"
            )
        if self.trace and self.source in (AUTO_SOURCE, OPENXR):
            raise InputError(
                f"--trace {self.trace}: a headset has a head of its own; "
                f"to rehearse, use --source {DESKTOP} or {OFFSCREEN}"
            )
        if self.source == OFFSCREEN and not self.trace:
            raise InputError("--source offscreen: there is no head; name a recorded one by --trace, such as walk")
        if self.source == OFFSCREEN and self.origin == PERSON:
            raise InputError(
                "--source offscreen: no person sees what is rated; that is a rehearsal: give --pilot or --simulate too"
            )

    @property
    def origin(self) -> str:
        """Origin of the ratings in the store. A simulated pilot is a pilot: that keeps it apart."""
        if self.pilot:
            return PILOT
        return PERSON if self.simulate is None else SIMULATED

    def command(self, participant: str, part: str, several: bool) -> str:
        """Return the command that resumes the session. several: whether there are several parts."""
        words = ["hmdwarp", "study", "run", self.study, "--participant", participant, "--resume"]
        words += ["--part", part] if several else []
        words += ["--pilot"] if self.pilot else []
        for name in ("simulate", "source", "trace", "store", "console"):
            value = getattr(self, name)
            if value != attrs.fields_dict(SessionOptions)[name].default:
                words += [f"--{name}", str(value)]
        return shlex.join(words)
