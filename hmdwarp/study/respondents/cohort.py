"""Whole studies of simulated participants at once, without pictures: orders are allotted, people get sick, stop, and cannot say."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..design import Design, Order, Part, allot, rows_for
from ..scales import Scale
from ..store import COMPLETE, SICK, STOPPED
from .draws import table_of
from .model import Floats, Model, of_share, on_scale

Ints = NDArray[np.intp]


@attrs.frozen(eq=False)
class Cohort:
    """n people with T trials each. order: (n, T) numbers of the part's conditions, as each was shown them.

    trials: (n) how many were shown and rated before the end. why: (n) the session's status. answers, latent: by scale, (n, T), with and
    without the scale's steps and ends; NaN in both where there is no answer. sickness: (n, T + 1) answers, after the practice and after
    each trial; NaN where not asked. susceptible: (n) the uniform draws of how easily each gets sick.
    """

    part: Part
    order: Ints
    trials: Ints
    why: tuple[str, ...]
    answers: dict[str, Floats]
    latent: dict[str, Floats]
    sickness: Floats
    susceptible: Floats

    def per_condition(self, scale: str, *, latent: bool = False, people: slice = slice(None)) -> Floats:
        """(n, conditions) means of each person's answers over the repeats; NaN where there is none."""
        values, order = (self.latent if latent else self.answers)[scale][people], self.order[people]
        n, c = len(values), len(self.part.conditions)
        there = ~np.isnan(values)
        where = (np.arange(n)[:, None] * c + order)[there]
        counts = np.bincount(where, minlength=n * c)
        sums = np.bincount(where, weights=values[there], minlength=n * c)
        return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan).reshape(n, c)


class Population:
    """All that many studies of one part have in common. Errors: InputError where the model lacks a scale or a condition of the study."""

    def __init__(self, model: Model, design: Design, part: str) -> None:
        self.model, self.design, self.part = model, design, design.part(part)
        self._rows = rows_for(design, part)
        self._names = {one.name: number for number, one in enumerate(self.part.conditions)}
        self._orders = np.array([self._flat(row) for row in self._rows])
        self._means = {scale.name: means_of(model, self.part, scale) for scale in design.scales}

    @property
    def balanced(self) -> int:
        """So many people have each order once."""
        return len(self._rows)

    def of(self, persons: Sequence[int], seed: int, study: int = 0, orders: Sequence[Order] | None = None) -> Cohort:
        """One study of these people, in the sequence they come. orders: everybody's; None allots them as the store does."""
        drawn = _Drawn(self, persons, seed, study)
        trials, why, sickness = self._ends(drawn)
        order = self._orders[self._allotted(why)] if orders is None else np.array([self._flat(one) for one in orders])
        over = np.arange(order.shape[1]) >= trials[:, None]
        answers, latent = {}, {}
        for number, scale in enumerate(self.design.scales):
            felt = self._felt(drawn, number, order)
            none = over | (drawn.missing[:, number] < self.model.ratings[scale.name].missing)
            latent[scale.name] = np.where(none, np.nan, felt)
            answers[scale.name] = np.where(none, np.nan, on_scale(felt, scale))
        return Cohort(self.part, order, trials, why, answers, latent, sickness, drawn.susceptible)

    def _flat(self, order: Order) -> list[int]:
        """Numbers of conditions, trial by trial, of all repeats."""
        return [self._names[name] for repeat in order for name in repeat]

    def _felt(self, drawn: _Drawn, number: int, order: Ints) -> Floats:
        scale = self.design.scales[number]
        means = self._means[scale.name][order]
        before = np.concatenate([means[:, :1], means[:, :-1]], axis=1)
        taste = np.take_along_axis(drawn.taste[:, number], order, axis=1)
        place = np.arange(order.shape[1])
        return self.model.ratings[scale.name].latent(
            means, before, place, drawn.level[:, number, None], taste, drawn.noise[:, number]
        )

    def _ends(self, drawn: _Drawn) -> tuple[Ints, tuple[str, ...], Floats]:
        """(trials, why, sickness) as Cohort has them."""
        count = self._orders.shape[1]
        sickness, sick_after = sick(self.model, self.design, drawn.sickness, drawn.susceptible)
        leaves = drawn.dropout < self.model.dropout
        left_after = np.where(leaves.any(axis=1), leaves.argmax(axis=1) + 1, count)
        trials = np.minimum(np.minimum(sick_after, left_after), count)
        why = tuple(
            SICK if s <= t else STOPPED if t < count else COMPLETE for s, t in zip(sick_after, trials, strict=True)
        )
        later = np.arange(count + 1) > trials[:, None]
        return trials, why, np.where(later, np.nan, sickness)

    def _allotted(self, why: Sequence[str]) -> list[int]:
        """Whoever did not come to the end leaves the order to the next."""
        filled, rows = [0] * len(self._rows), []
        for status in why:
            rows.append(allot(filled, self.design.seed))
            filled[rows[-1]] += status == COMPLETE
        return rows


class _Drawn:
    """Everybody's uniform draws, cut into what they are for; the table's length depends on the plan alone."""

    def __init__(self, population: Population, persons: Sequence[int], seed: int, study: int) -> None:
        design, part = population.design, population.part
        s, c = len(design.scales), len(part.conditions)
        t = c * design.repeats
        shapes = {"susceptible": (), "level": (s,), "taste": (s, c), "sickness": (t + 1,), "dropout": (t,)}
        shapes |= {"noise": (s, t), "missing": (s, t)}
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes.values()])
        table = np.stack([table_of(seed, study, part.name, person, int(ends[-1])) for person in persons])
        parts = np.split(table, ends[:-1], axis=1)
        for (name, shape), cut in zip(shapes.items(), parts, strict=True):
            setattr(self, name, cut.reshape(len(table), *shape))


def sick(model: Model, design: Design, noise: Floats, susceptible: Floats) -> tuple[Floats, Ints]:
    """(n, T + 1) answers, NaN where the plan does not ask; (n) after which trial the stop rule ends it, beyond T where it does not.

    noise: (n, T + 1) and susceptible: (n) uniform draws.
    """
    rule, trial = design.sickness, np.arange(noise.shape[1])
    never = noise.shape[1]
    if rule is None:
        return np.full(noise.shape, np.nan), np.full(len(noise), never)
    asked = np.where(trial == 0, design.practice is not None, trial % rule.every == 0)
    felt = model.sickness.latent(trial, susceptible.reshape(-1, 1), noise)
    answers = np.where(asked, of_share(felt, rule.scale), np.nan)
    over = asked & ends_it(answers, asked, rule.scale, rule.stop_at, rule.rise)
    return answers, np.where(over.any(axis=1), over.argmax(axis=1), never)


def ends_it(
    answers: Floats, asked: NDArray[np.bool_], scale: Scale, stop_at: float | None, rise: float | None
) -> NDArray[np.bool_]:
    """(n, T + 1) whether each answer is one the session ends after."""
    bad = answers - scale.least if scale.low_is_good else scale.most - answers
    over = np.zeros(answers.shape, bool)
    if not asked.any():
        return over
    if stop_at is not None:
        over |= bad >= scale.badness(stop_at)
    if rise is not None:
        over |= bad - bad[:, [int(asked.argmax())]] >= rise
    return over


def means_of(model: Model, part: Part, scale: Scale) -> Floats:
    """(conditions) of the latent ratings. Errors: InputError where the model lacks one."""
    return model.rating(scale).means_of(part, f"{model.path}: [rating.{scale.name}.means]")
