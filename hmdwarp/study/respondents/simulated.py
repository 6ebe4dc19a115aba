"""A simulated participant in a session of the real program: answers through the same commands as hands and the experimenter's desk do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...display import Command
from ..design import Ask, Design, Order, Pause, Read, Show, Step
from ..store import STOPPED
from .cohort import Population
from .draws import draw_for, person_of
from .model import Model, of_share
from .read_model import load_model

__all__ = ["Simulated", "load_model", "person_of"]
PATIENCE_S = 0.5  # until what had no effect is tried once more, as people do


class Simulated:
    """person: a number of its own, person_of(code). order: the session's.

    The same person answers the same, whenever and however often a question is asked: every draw belongs to the person and the question,
    none to what was asked before. Answers are those of Population(..).of([person], seed, orders=[order]).
    Errors: InputError where the model lacks a scale or a condition of the study.
    """

    def __init__(self, model: Model, design: Design, part: str, seed: int, person: int, order: Order) -> None:
        self._model, self._part, self._seed, self._person = model, part, seed, person
        self._cohort = Population(model, design, part).of([person], seed, orders=[order])
        self._susceptible = self._cohort.susceptible[0]
        self._visit = _Visit()
        self._paused: set[str] = set()  # keys of trials, and below of questions: once is enough
        self._again: set[str] = set()
        self._wants_again = False

    def commands(self, step: Step, shown: Show | None, asked_s: float) -> Sequence[Command]:
        """As Respondent.commands. Each is given once in a visit of a step, and again where it had no effect."""
        if self._visit.begins(step.key, asked_s) and self._wants_again:
            self._wants_again = False
            return (Command("again"),)
        wanted = self._wanted(step, shown, asked_s)
        if wanted is None or not self._visit.due(wanted.control, asked_s):
            return ()
        if isinstance(step, Ask) and step.key not in self._again and self._draw("again", step.key) < self._model.again:
            self._again.add(step.key)
            self._wants_again = True
        return (wanted,)

    def _wanted(self, step: Step, shown: Show | None, asked_s: float) -> Command | None:
        if self._leaves(step, shown):
            return Command("stop")
        if isinstance(step, Show):
            return self._meanwhile(step, asked_s)
        if asked_s < self._model.seconds(self._draw("seconds", step.key)):
            return None
        if isinstance(step, Ask):
            value = self.answer(step, 0 if shown is None else shown.trial)
            return Command("skip") if value is None else Command("answer", value)
        return Command("agree" if isinstance(step, Read) else "continue")

    def answer(self, step: Ask, trial: int) -> float | None:
        """None for "cannot say". trial: the last one shown, for what is asked after all of them."""
        if step.phase == "trial" and step.scale.name in self._cohort.answers:
            return _known(self._cohort.answers[step.scale.name][0, step.trial - 1])
        if step.phase in ("practice", "trial"):
            return _known(self._cohort.sickness[0, step.trial])
        shown = 0 if step.phase == "before" else trial
        felt = self._model.sickness.latent(shown, self._susceptible, self._draw("answer", step.key))
        return float(of_share(felt, step.scale))

    def _meanwhile(self, step: Show, asked_s: float) -> Command | None:
        """While pictures are looked at. The menu that a pause opens is a Pause, which "continue" ends."""
        wants = step.key not in self._paused and self._draw("pause", step.key) < self._model.pause
        if wants and asked_s >= step.seconds * self._draw("pause at", step.key):
            self._paused.add(step.key)
            return Command("pause")
        return None

    def _leaves(self, step: Step, shown: Show | None) -> bool:
        """Whether now is when somebody has had enough: before the trial after the last one."""
        last = int(self._cohort.trials[0])
        if self._cohort.why[0] != STOPPED:
            return False
        return (isinstance(step, Show) and step.trial > last) or (
            isinstance(step, Pause) and shown is not None and shown.trial >= last
        )

    def _draw(self, what: str, key: str) -> float:
        return float(draw_for(self._seed, self._part, self._person, f"{what} {key}")[0])


class _Visit:
    """A step as long as it is on without a break; what was asked for in it, and when."""

    def __init__(self) -> None:
        self._key, self._last_s, self._asked = "", np.inf, {}

    def begins(self, key: str, asked_s: float) -> bool:
        """Whether this is another step, or the same one from its start."""
        new = key != self._key or asked_s < self._last_s
        if new:
            self._key, self._asked = key, {}
        self._last_s = asked_s
        return new

    def due(self, control: str, asked_s: float) -> bool:
        """Whether to ask for it now."""
        before = self._asked.get(control)
        if before is not None and asked_s - before < PATIENCE_S:
            return False
        self._asked[control] = asked_s
        return True


def _known(value: float) -> float | None:
    return None if np.isnan(value) else float(value)
