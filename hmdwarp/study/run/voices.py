"""Who may ask for something while a session goes on, and what of it holds in every step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import attrs

from ...display import Command
from ..design import Show, Step
from ..desk import Desk
from ..respondents import Respondent

PARTICIPANT, EXPERIMENTER, RESPONDENT = "participant", "experimenter", "simulated"

# What ends a step before its time, by the command that asks for it.
PAUSE, AGAIN, STOP = "pause", "again", "stop"
INTENTS = {"menu": PAUSE, "pause": PAUSE, "again": AGAIN, "stop": STOP}
BREAK, REMARK = "break", "remark"  # what waits until the trial is over, and what changes nothing


@attrs.frozen
class Voices:
    """The participant's hands, which the display knows; the experimenter's desk; a respondent, in rehearsals."""

    desk: Desk
    respondent: Respondent

    def heard(
        self, commands: Sequence[Command], step: Step, shown: Show | None, asked_s: float
    ) -> Iterator[tuple[str, Command]]:
        """Everything since the last time, with who it came from. commands: the display's."""
        yield from ((PARTICIPANT, one) for one in commands)
        yield from ((EXPERIMENTER, one) for one in self.desk.commands())
        yield from ((RESPONDENT, one) for one in self.respondent.commands(step, shown, asked_s))
