"""Does what the one who looks asks for, as far as it can be done, and says what cannot."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import attrs

from ...display import Command, Lost
from ...errors import InputError, MachineError
from .changes import changed, choices
from .host import Stage

READING_S = 4.0  # how long a refusal stays over the picture: a line or two


@attrs.define(eq=False)
class CommandHandler:
    """stage: what is changed. say: gets each refusal. refusal: the last one, as long as it is to be read, else ""."""

    stage: Stage
    say: Callable[[str], None]
    _refused: str = ""
    _until: float = 0.0

    def obey(self, commands: Sequence[Command]) -> bool:
        """Whether anything is different afterwards. A step to what cannot be goes on to the next that can."""
        before = self.stage.options
        for command in commands:
            self._obey(command)
        return self.stage.options is not before

    def _obey(self, command: Command) -> None:
        options = self.stage.options
        steps = len(choices().get(command.control, ())) if command.value is None else 0
        for _ in range(max(steps, 1)):
            try:
                options = changed(options, command)
                self.stage.change(options)
                return
            except Lost:
                raise
            except (InputError, MachineError) as error:  # the run goes on as it was
                self._refuse(str(error))

    def _refuse(self, why: str) -> None:
        self.say(why)
        self._refused, self._until = why, time.monotonic() + READING_S

    @property
    def refusal(self) -> str:
        """For over the picture."""
        if self._refused and time.monotonic() > self._until:
            self._refused = ""
        return self._refused
