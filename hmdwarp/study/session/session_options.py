"""Options of a session."""

from __future__ import annotations

import shlex
from pathlib import Path

import attrs

from ...base import Declared, InputError, as_path, one_of, option
from ...run import AUTO_SOURCE, DESKTOP, OFFSCREEN, OPENXR, SOURCES
from ..line_console import KINDS as CONSOLES
from ..line_console import LINES
from ..store import PERSON, PILOT, SIMULATED


@attrs.frozen(kw_only=True)
class SessionOptions(Declared):
    """A session. Errors: InputError for options that contradict each other."""

    study: str = option(
        attrs.NOTHING, "Study: a .toml file, or the name of a shipped one.", positional=True, names_files=True
    )
    participant: str = option(attrs.NOTHING, "Participant's code, never a name; new draws one.")
    part: str | None = option(None, "Part of the plan, where it has several.")
    resume: bool = option(False, "Continue an interrupted session at its first undone step.")
    new_session: bool = option(False, "Begin a further session of a known participant.")
    pilot: bool = option(False, "Rehearse: keep the session apart from people.")
    simulate: str | None = option(None, "Response model (.toml) that answers in place of a person.")
    source: str = option(
        AUTO_SOURCE, "openxr, desktop, offscreen (no display), or auto: headset, else window.", valid=one_of(*SOURCES)
    )
    trace: str = option("", "Recorded head that leads the window or the offscreen display.")
    store: Path | None = option(
        None,
        "Folder for the data; by default STUDY-data beside the file, STUDY-pilot-data, STUDY-simulated-data.",
        convert=attrs.converters.optional(as_path),
    )
    console: str = option(
        LINES,
        "Experimenter's console: lines, with a status line on a terminal, or none.",
        valid=one_of(*CONSOLES),
    )
    lsl: bool = option(False, "Send markers to the Lab Streaming Layer (pip install '.[lsl]').")

    def __attrs_post_init__(self) -> None:
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
        words += [f"--{name}" for name in ("pilot", "lsl") if getattr(self, name)]
        for name in ("simulate", "source", "trace", "store", "console"):
            value = getattr(self, name)
            if value != attrs.fields_dict(SessionOptions)[name].default:
                words += [f"--{name}", str(value)]
        return shlex.join(words)
