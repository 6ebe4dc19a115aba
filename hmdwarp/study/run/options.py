"""What a session is asked to be."""

from __future__ import annotations

import shlex
from pathlib import Path

import attrs

from ...errors import InputError
from ...run.live.options import AUTO_SOURCE, DESKTOP, OFFSCREEN, OPENXR, SOURCES
from ..desk import KINDS as DESKS
from ..store import PERSON, PILOT, SIMULATED


@attrs.frozen(kw_only=True)
class RunSession:
    """study: a file, or the name of one that came with the program. participant: a code, or "new". part: of the plan, None where it has but
    one. resume: go on with an interrupted session. new_session: a further one of somebody known. pilot: kept apart from people.
    simulate: a response model that answers in place of somebody, None for nobody. source, trace: as live.LiveOptions. store: where the data
    lie, None for the study's own folder. desk: of DESKS.
    Errors: InputError for what cannot be meant.
    """

    study: str
    participant: str
    part: str | None = None
    resume: bool = False
    new_session: bool = False
    pilot: bool = False
    simulate: str | None = None
    source: str = AUTO_SOURCE
    trace: str = ""
    store: Path | None = attrs.field(default=None, converter=attrs.converters.optional(Path))
    desk: str = "auto"

    def __attrs_post_init__(self) -> None:
        if self.source not in SOURCES:
            raise InputError(f"--source {self.source}: wanted {', '.join(SOURCES)}")
        if self.desk not in DESKS:
            raise InputError(f"--desk {self.desk}: wanted {', '.join(DESKS)}")
        if self.resume and self.new_session:
            raise InputError("--resume goes on with a session, --new-session begins another: leave one of the two out")
        if self.resume and self.participant.lower() == "new":
            raise InputError(
                "--participant new draws a code for somebody new: --resume needs the code of who was interrupted"
            )
        if self.trace and self.source in (AUTO_SOURCE, OPENXR):
            raise InputError(
                f"--trace {self.trace}: a headset has a head of its own; take --source {DESKTOP} or {OFFSCREEN}, to rehearse"
            )
        if self.source == OFFSCREEN and not self.trace:
            raise InputError("--source offscreen: nobody's head leads it; name a recorded one by --trace, such as walk")
        if self.source == OFFSCREEN and self.origin == PERSON:
            raise InputError(
                "--source offscreen: nobody sees what is rated; that is a rehearsal: give --pilot or --simulate too"
            )

    @property
    def origin(self) -> str:
        """Of the ratings, as the store has it. A simulated pilot is a pilot: what counts is that it is kept apart."""
        if self.pilot:
            return PILOT
        return PERSON if self.simulate is None else SIMULATED

    def command(self, participant: str, part: str, several: bool) -> str:
        """What goes on with the session, to be typed."""
        words = ["hmdwarp", "study", "run", self.study, "--participant", participant, "--resume"]
        words += ["--part", part] if several else []
        words += ["--pilot"] if self.pilot else []
        for name in ("simulate", "source", "trace", "store", "desk"):
            value = getattr(self, name)
            if value != attrs.fields_dict(RunSession)[name].default:
                words += [f"--{name}", str(value)]
        return shlex.join(words)
