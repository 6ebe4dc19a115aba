"""Respondents of a session: none, or a simulated participant who sends people's commands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ...display import Command
from ..design import Ask, Design, Order, Pause, Read, Show, Step
from ..scales import QUESTIONNAIRE, WORDS
from ..store import STOPPED
from .cohort import Population
from .response_model import Model, draw_for, of_share


class Respondent(Protocol):
    """Source of commands besides the participant's own input."""

    def commands(self, step: Step, shown: Show | None, elapsed_s: float) -> Sequence[Command]:
        """Return what the respondent does at this refresh, in the words of Console.commands.

        shown: the step shown last. elapsed_s: time since this step began.
        """


class NoRespondent:
    """Respondent that never answers; the participant does."""

    def commands(self, step: Step, shown: Show | None, elapsed_s: float) -> Sequence[Command]:
        """Return nothing."""
        return ()


SAID = "simulated words"  # to questions that are answered in words
PATIENCE_S = 0.5  # until a command without effect is tried again, as people do


class Simulated:
    """Simulated participant: person_of(code) with the order of the session.

    The same person answers the same, whenever and however often a question is asked: every draw
    belongs to the person and the question, none to what was asked before. Answers are those of
    Population(..).of([person], seed, orders=[order]).

    Errors: InputError where the model lacks a scale or a condition of the study.
    """

    def __init__(self, model: Model, design: Design, part: str, seed: int, person: int, order: Order) -> None:
        self._model, self._part, self._seed, self._person = model, part, seed, person
        self._cohort = Population(model, design, part).of([person], seed, orders=[order])
        self._visit = _Visit()
        self._paused: set[str] = set()  # keys of trials with a pause: one is enough
        self._again: set[str] = set()  # keys of questions that were repeated: once is enough
        self._wants_again = False

    def commands(self, step: Step, shown: Show | None, elapsed_s: float) -> Sequence[Command]:
        """Return the commands of this refresh.

        Each is sent once in a visit of a step, and again where it had no effect.
        """
        if self._visit.begins(step.key, elapsed_s) and self._wants_again:
            self._wants_again = False
            return (Command("again"),)
        command = self._command(step, shown, elapsed_s)
        if command is None or not self._visit.due(command.control, elapsed_s):
            return ()
        if isinstance(step, Ask) and step.key not in self._again and self._draw("again", step.key) < self._model.again:
            self._again.add(step.key)
            self._wants_again = True
        return (command,)

    def _command(self, step: Step, shown: Show | None, elapsed_s: float) -> Command | None:
        if self._leaves(step, shown):
            return Command("stop")
        if isinstance(step, Show):
            return self._pause(step, elapsed_s) or self._done(step, elapsed_s) or self._select(step)
        if elapsed_s < self._model.seconds(self._draw("seconds", step.key)):
            return None
        if isinstance(step, Ask):
            if step.item.answer == WORDS:
                return Command("answer", SAID)
            value = self.answer(step, 0 if shown is None else shown.trial)
            return Command("skip") if value is None else Command("answer", value)
        return Command("agree" if isinstance(step, Read) else "continue")

    def answer(self, step: Ask, trial: int) -> float | None:
        """Return the answer, None for "cannot say".

        trial: the last one shown, for questions after all trials.
        """
        if step.phase == "trial" and step.scale.name in self._cohort.answers:
            return _known(self._cohort.answers[step.scale.name][0, step.trial - 1])
        about_trial = step.phase in ("practice", "trial")
        if about_trial and step.scale.kind != QUESTIONNAIRE:
            return _known(self._cohort.sickness[0, step.trial])
        if step.item.answer or about_trial:
            values = step.scale.of(step.item).values()
            return values[int(self._draw("answer", step.key) * len(values))]
        shown = 0 if step.phase == "before" else trial
        susceptible = self._cohort.susceptible[0]
        felt = self._model.sickness.latent(shown, susceptible, self._draw("answer", step.key))
        return float(of_share(felt, step.scale))

    def _pause(self, step: Show, elapsed_s: float) -> Command | None:
        """Pause some trials at a random moment; the menu that opens is a Pause."""
        wants = step.key not in self._paused and self._draw("pause", step.key) < self._model.pause
        if wants and elapsed_s >= self._lasts_s(step) * self._draw("pause at", step.key):
            self._paused.add(step.key)
            return Command("pause")
        return None

    def _done(self, step: Show, elapsed_s: float) -> Command | None:
        """End a trial that lasts until the participant is done."""
        return Command("continue") if step.until_done and elapsed_s >= self._lasts_s(step) else None

    @staticmethod
    def _select(step: Show) -> Command | None:
        """Select all the time: whether the head points at a target is not known here."""
        return Command("confirm") if step.task is not None else None

    def _lasts_s(self, step: Show) -> float:
        if not step.until_done:
            return step.seconds
        return min(step.seconds, self._model.look_seconds(self._draw("look", step.key)))

    def _leaves(self, step: Step, shown: Show | None) -> bool:
        """Return whether a drop-out leaves now: before the trial after the last one."""
        last = int(self._cohort.trials[0])
        if self._cohort.why[0] != STOPPED:
            return False
        return (isinstance(step, Show) and step.trial > last) or (
            isinstance(step, Pause) and shown is not None and shown.trial >= last
        )

    def _draw(self, what: str, key: str) -> float:
        return float(draw_for(self._seed, self._part, self._person, f"{what} {key}")[0])


class _Visit:
    """A step without interruption, with the commands sent in it and their times."""

    def __init__(self) -> None:
        self._key, self._last_s = "", np.inf
        self._sent: dict[str, float] = {}

    def begins(self, key: str, elapsed_s: float) -> bool:
        """Return whether this is another step, or the same one from its start."""
        new = key != self._key or elapsed_s < self._last_s
        if new:
            self._key, self._sent = key, {}
        self._last_s = elapsed_s
        return new

    def due(self, control: str, elapsed_s: float) -> bool:
        """Return whether to send the command now."""
        before = self._sent.get(control)
        if before is not None and elapsed_s - before < PATIENCE_S:
            return False
        self._sent[control] = elapsed_s
        return True


def _known(value: float) -> float | None:
    return None if np.isnan(value) else float(value)
