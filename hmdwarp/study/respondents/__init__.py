"""Respondents of a session: none, or a simulated participant who sends people's commands."""

from __future__ import annotations

import hashlib
import math
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, Self

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from ...display import Command
from ...errors import InputError, unknown_name
from ...options import Table, fields_in, parsed, read_by, text_of
from ..design import PAIR, Ask, Design, Order, Part, Pause, Read, Show, Step, allot, pair_of, rows_for, trials_of
from ..scales import FIRST, NEITHER, PREFERENCE, QUESTIONNAIRE, SECOND, WORDS, Scale
from ..statistics import JOD_SPREAD
from ..store import COMPLETE, SICK, STOPPED

_64 = (1 << 64) - 1


def person_of(code: str) -> int:
    """Return the number of the simulated person with that code, the same on every machine."""
    return int.from_bytes(hashlib.sha256(code.encode()).digest()[:8], "big")


def table_of(seed: int, study: int, part: str, person: int, count: int) -> Floats:
    """Return `count` uniform draws in [0, 1) of a person in a part of a study.

    A longer table begins with the shorter one.
    """
    return _uniform(seed, study, part, person, 0, count)


def draw_for(seed: int, part: str, person: int, thing: str, count: int = 1) -> Floats:
    """Return uniform draws for one named thing of a session, independent of the person's table."""
    return _uniform(seed, 0, part, person, 1 + zlib.crc32(thing.encode()), count)


def _uniform(seed: int, study: int, part: str, person: int, thing: int, count: int) -> Floats:
    counter = np.array([0, thing, zlib.crc32(part.encode()), person & _64], np.uint64)
    key = np.array([seed & _64, study & _64], np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=counter)).random(count)


Floats = NDArray[np.float64]
# Half the least step of a double from [0, 1): a draw of exactly 0 gives the normal -8.3, not -inf.
TINY = 2.0**-54
PREFERENCE_JOD = 5.0  # from the best of a scale to its worst, where the question is for a preference


def _within(least: float, most: float, default: Any = 0.0, at: str = "", *, above: bool = False) -> Any:
    return read_by(Table.within, least, most, default=default, at=at, above=above)


@attrs.frozen
class RatingModel:
    """Model of the ratings on one scale, in the unit and the direction of that scale.

    Of a preference it is that of what is felt of each of the two, where more is better; in JOD if
    noise_sd is JOD_SPREAD / sqrt 2. Levels, drift and carry-over do not count in it.
    """

    # Latent rating by condition, or a table of them by part, where the parts differ.
    means: Mapping[str, object] = attrs.field(factory=dict, hash=False)
    people_sd: float = _within(0, math.inf)  # of a person's own level
    condition_sd: float = _within(0, math.inf)  # of a person's opinion of a condition, beyond that level
    noise_sd: float = _within(0, math.inf)  # from one showing to the next
    drift: float = read_by(Table.number, default=0.0)  # per trial after the first
    # Share of (mean of the condition before - mean of this one) that is added; negative: contrast.
    carry_over: float = _within(-1, 1)
    missing: float = _within(0, 1)  # share of trials answered with "cannot say"
    threshold: float = _within(
        0, math.inf
    )  # of a preference: a smaller difference is called none, where that is allowed
    # Latent ratings of conditions that `means` leaves out, and of hidden references among them;
    # None: an error.
    mean: float | None = None
    reference: float | None = None

    def means_of(self, part: Part, where: str) -> Floats:
        """Return the (conditions) means of a part.

        where: the place in the file, for the error. Errors: InputError for a condition without one.
        """
        own = self.means.get(part.name)
        table = own if isinstance(own, Mapping) else self.means
        found = {
            condition.name: table.get(condition.name, self.reference if condition.reference else self.mean)
            for condition in part.conditions
        }
        lacking = [name for name, mean in found.items() if not isinstance(mean, float)]
        if lacking:
            raise InputError(
                f"{where}: no mean for {', '.join(lacking)} of part '{part.name}': expected one for each condition"
            )
        return np.array(list(found.values()))

    def latent(
        self, mean: ArrayLike, before: ArrayLike, place: ArrayLike, level: ArrayLike, taste: ArrayLike, noise: ArrayLike
    ) -> Floats:
        """Compute the rating before steps and ends of the scale apply. All arguments broadcast.

        mean: of the condition. before: mean of the condition shown before, or of the same one in
        the first trial. place: of the trial, from 0. level, taste, noise: uniform draws of the
        person, of the person and the condition, and of the trial.
        """
        spread = self.people_sd * normal(level) + self.condition_sd * normal(taste) + self.noise_sd * normal(noise)
        mean = np.asarray(mean, float)
        moved = self.drift * np.asarray(place) + self.carry_over * (np.asarray(before) - mean)
        return np.asarray(mean + moved + spread)


@attrs.frozen(kw_only=True)
class OtherRatings:
    """Ratings on scales and of conditions that a model does not name.

    All but `missing` are shares of the scale, from its best (0) to its worst (1).
    """

    mean: float = _within(0, 1, attrs.NOTHING)  # of a condition
    reference: float = _within(0, 1, attrs.NOTHING)  # of a hidden reference
    people_sd: float = _within(0, math.inf)  # the rest as in RatingModel
    condition_sd: float = _within(0, math.inf)
    noise_sd: float = _within(0, math.inf)
    drift: float = read_by(Table.number, default=0.0)
    missing: float = _within(0, 1)

    def on(self, scale: Scale) -> RatingModel:
        """Return the model in the unit and the direction of a scale."""
        if scale.kind == PREFERENCE:  # in JOD, of which the noise defines the unit
            return RatingModel(
                condition_sd=PREFERENCE_JOD * self.condition_sd,
                noise_sd=JOD_SPREAD / np.sqrt(2),
                missing=self.missing,
                threshold=PREFERENCE_JOD * self.condition_sd,
                mean=-PREFERENCE_JOD * self.mean,
                reference=-PREFERENCE_JOD * self.reference,
            )
        width = scale.most - scale.least
        best, way = (scale.least, width) if scale.low_is_good else (scale.most, -width)
        return RatingModel(
            people_sd=width * self.people_sd,
            condition_sd=width * self.condition_sd,
            noise_sd=width * self.noise_sd,
            drift=way * self.drift,
            missing=self.missing,
            mean=best + way * self.mean,
            reference=best + way * self.reference,
        )


@attrs.frozen
class SicknessModel:
    """Model of sickness, as a share of the scale from its best (0) to its worst (1)."""

    start: float = _within(0, 1)  # before the first trial
    per_trial: float = _within(0, 1)  # increase per trial of the median person
    people_sd: float = _within(0, math.inf)  # of the logarithm of a person's susceptibility
    noise_sd: float = _within(0, math.inf)  # of an answer

    def state(self, trial: ArrayLike, person: ArrayLike) -> Floats:
        """Compute the sickness after that many trials, not cut at 1. person: a uniform draw."""
        return self.start + self.per_trial * np.asarray(trial) * np.exp(self.people_sd * normal(person))

    def latent(self, trial: ArrayLike, person: ArrayLike, noise: ArrayLike) -> Floats:
        """Compute the sickness felt at a question. noise: a uniform draw."""
        return self.state(trial, person) + self.noise_sd * normal(noise)


@attrs.frozen
class Model:
    """Response model of a study's participants."""

    path: str  # its file, or "model NAME" of a shipped one, for messages
    title: str = read_by(Table.text, default="", required=True)
    ratings: Mapping[str, RatingModel] = attrs.field(factory=dict, hash=False)  # by scale name
    others: OtherRatings | None = None  # of what `ratings` leaves out; None: an error
    sickness: SicknessModel = SicknessModel()
    dropout: float = _within(0, 1, at="sessions.dropout")  # of leaving after a trial and its questions
    pause: float = _within(0, 1, at="sessions.pause")  # probability of a pause in a trial
    again: float = _within(0, 1, at="sessions.again")  # of repeating the last question of a trial
    # Time to an answer, log-normal: its median, and the standard deviation of its logarithm.
    median_s: float = _within(0, 3600, 2.0, "answers.median_s", above=True)
    spread_s: float = _within(0, 5, 0.5, "answers.spread_s")
    # Time in a trial that the participant ends, log-normal too.
    look_median_s: float = _within(0, 3600, 20.0, "looks.median_s", above=True)
    look_spread_s: float = _within(0, 5, 0.5, "looks.spread_s")

    def rating(self, scale: Scale) -> RatingModel:
        """Return the model of that scale. Errors: InputError where there is none."""
        own, other = self.ratings.get(scale.name), None if self.others is None else self.others.on(scale)
        if own is None and other is None:
            known = ", ".join(self.ratings) or "none"
            raise InputError(
                f"{self.path}: no [rating.{scale.name}], which the study asks for after each trial; there is {known}: "
                "add it, or use the model quick, which answers every scale (docs/response-models.md)"
            )
        if own is None or other is None:
            return own or other  # type: ignore[return-value]  # one of them is there
        return attrs.evolve(own, mean=other.mean, reference=other.reference)

    def seconds(self, draw: float) -> float:
        """Return the time to an answer for a uniform draw."""
        return float(self.median_s * np.exp(self.spread_s * normal(draw)))

    def look_seconds(self, draw: float) -> float:
        """Return the time in a trial that the participant ends, for a uniform draw."""
        return float(self.look_median_s * np.exp(self.look_spread_s * normal(draw)))


def normal(uniform: ArrayLike) -> Floats:
    """Turn uniform draws in [0, 1) into standard normal ones."""
    return np.asarray(ndtri(np.maximum(uniform, TINY)))


def on_scale(latent: ArrayLike, scale: Scale) -> Floats:
    """Round to the nearest answer of the scale, within its ends."""
    steps = np.rint((np.asarray(latent, float) - scale.least) / scale.step)
    return np.clip(np.round(scale.least + steps * scale.step, 9), scale.least, scale.most)


def of_share(share: ArrayLike, scale: Scale) -> Floats:
    """Return the answer nearest to a share of the scale, from its best (0) to its worst (1)."""
    way = (scale.most - scale.least) * np.asarray(share)
    return on_scale(scale.least + way if scale.low_is_good else scale.most - way, scale)


SCHEMA = 1
_FOLDER = Path(__file__).resolve().parent
_EXAMPLE = "the model of docs/response-models.md"


def model_names() -> list[str]:
    """Return the names of the shipped models, sorted; each has the name of its study."""
    return sorted(path.stem for path in _FOLDER.glob("*.toml"))


def load_model(name_or_path: str | Path) -> Model:
    """Load a shipped model by the name of its study, or any .toml file by path.

    Errors: InputError naming the file, the line and the value.
    """
    name = str(name_or_path)
    if not name.endswith(".toml") and name not in model_names():
        raise unknown_name("model", name, [*model_names(), "FILE.toml"])
    if not name.endswith(".toml"):
        return model_from_text((_FOLDER / f"{name}.toml").read_text(encoding="utf-8"), f"model {name}")
    return model_from_text(text_of(Path(name), f"a .toml file, or one of {', '.join(model_names())}"), name)


def model_from_text(text: str, path: str) -> Model:
    """Make the model from a text. path: for messages. Errors: as load_model."""
    return parsed(text, path, lambda data: _model(data, path), _EXAMPLE)


def _model(data: Table, path: str) -> Model:
    if data.raw("schema") != SCHEMA:
        raise data.fault("schema", f"is {data.raw('schema')!r}: expected {SCHEMA}, which this version of hmdwarp reads")
    ratings, sickness = data.table("rating"), data.table("sickness") if "sickness" in data else Table({})
    scales = {name: ratings.table(name) for name in ratings.keys()}  # noqa: SIM118  (a Table is no dict)
    return Model(
        path=path,
        ratings={
            name: RatingModel(_means(of.table("means")), **fields_in(of, RatingModel)) for name, of in scales.items()
        },
        others=OtherRatings(**fields_in(data.table("others"), OtherRatings)) if "others" in data else None,
        sickness=SicknessModel(**fields_in(sickness, SicknessModel)),
        **fields_in(data, Model),
    )


def _means(table: Table, *, parts: bool = True) -> dict[str, object]:
    """Read means by condition. parts: whether there may be a table for each part of the study."""
    out: dict[str, object] = {}
    for key in table.keys():  # noqa: SIM118  (a Table is no dict)
        inner = parts and isinstance(table.raw(key), dict)
        out[key] = _means(table.table(key), parts=False) if inner else table.number(key)
    return out


Ints = NDArray[np.intp]


@attrs.frozen(eq=False)
class Cohort:
    """Answers of n people with T trials each; NaN where there is no answer."""

    part: Part
    order: Ints  # (n, T) numbers of the part's conditions in the order shown, of a pair the second
    first: Ints  # (n, T) the first of a pair; as order where one condition is shown
    trials: Ints  # (n) trials shown and rated before the end
    why: tuple[str, ...]  # (n) status of the session
    answers: dict[str, Floats]  # (n, T) by scale, rounded to the scale
    sickness: Floats  # (n, T + 1) answers after the practice and after each trial
    susceptible: Floats  # (n) uniform draws of how easily each gets sick


class Population:
    """All that many simulated studies of one part have in common.

    Errors: InputError where the model lacks a scale or a condition of the study.
    """

    def __init__(self, model: Model, design: Design, part: str) -> None:
        self.model, self.design, self.part = model, design, design.part(part)
        self._rows = rows_for(design, part)
        self._names = {condition.name: number for number, condition in enumerate(self.part.conditions)}
        self._trials = trials_of(design, part)
        self._orders = np.array([self._flat(row) for row in self._rows])
        self._ratings = {scale.name: model.rating(scale) for scale in design.scales if scale.kind != QUESTIONNAIRE}
        self._means = {
            name: rating.means_of(self.part, f"{model.path}: [rating.{name}.means]")
            for name, rating in self._ratings.items()
        }

    def of(self, persons: Sequence[int], seed: int, study: int = 0, orders: Sequence[Order] | None = None) -> Cohort:
        """Simulate one study of these people, in the sequence they come.

        orders: of each person; None allots them as the store does.
        """
        drawn = _Draws.of(self, persons, seed, study)
        trials, why, sickness = self._ends(drawn)
        shown = (
            self._orders[self._allotted(why)] if orders is None else np.array([self._flat(order) for order in orders])
        )
        first, order = np.moveaxis(shown, -1, 0)
        over = np.arange(order.shape[1]) >= trials[:, None]
        answers = {}
        for number, scale in enumerate(self.design.scales):
            if scale.name not in self._means:
                continue
            is_choice = scale.kind == PREFERENCE
            felt = self._preferred(drawn, number, first, order) if is_choice else self._felt(drawn, number, order)
            none = over | (drawn.missing[:, number] < self._ratings[scale.name].missing)
            answered = self._choice(felt, scale) if is_choice else on_scale(felt, scale)
            answers[scale.name] = np.where(none, np.nan, answered)
        return Cohort(self.part, order, first, trials, why, answers, sickness, drawn.susceptible)

    def _flat(self, order: Order) -> list[tuple[int, int]]:
        """Return the numbers of the conditions, trial by trial, over all repeats.

        Of both of a pair, and of a single condition twice.
        """
        pairs = (pair_of(name) if self.design.shows == PAIR else (name, name) for names in order for name in names)
        return [(self._names[first], self._names[second]) for first, second in pairs]

    def _felt(self, drawn: _Draws, number: int, order: Ints) -> Floats:
        scale = self.design.scales[number]
        means = self._means[scale.name][order]
        taste = np.take_along_axis(drawn.taste[:, number], order, axis=1)
        place = np.arange(order.shape[1])
        return self._ratings[scale.name].latent(
            means, _before(means), place, drawn.level[:, number, None], taste, drawn.noise[:, number]
        )

    def _preferred(self, drawn: _Draws, number: int, first: Ints, second: Ints) -> Floats:
        """Compute by how much each second condition is felt to be better than the first, in JOD."""
        name = self.design.scales[number].name
        rating, means = self._ratings[name], self._means[name]

        def at(order: Ints) -> Floats:
            taste = np.take_along_axis(drawn.taste[:, number], order, axis=1)
            return means[order] + rating.condition_sd * normal(taste)

        return np.asarray(at(second) - at(first) + np.sqrt(2) * rating.noise_sd * normal(drawn.noise[:, number]))

    def _choice(self, felt: Floats, scale: Scale) -> Floats:
        """Return the answers to a preference: neither below the threshold, where allowed."""
        chosen = np.where(felt > 0, SECOND, FIRST)
        threshold = self._ratings[scale.name].threshold
        return np.where(np.abs(felt) < threshold, NEITHER, chosen) if scale.allows_ties else chosen

    def _ends(self, drawn: _Draws) -> tuple[Ints, tuple[str, ...], Floats]:
        """Return (trials, why, sickness) as in Cohort."""
        count = self._trials
        sickness, sick_after = _sickness(self.model, self.design, drawn.sickness, drawn.susceptible)
        leaves = drawn.dropout < self.model.dropout
        left_after = np.where(leaves.any(axis=1), leaves.argmax(axis=1) + 1, count)
        trials = np.minimum(np.minimum(sick_after, left_after), count)
        why = tuple(
            SICK if s <= t else STOPPED if t < count else COMPLETE for s, t in zip(sick_after, trials, strict=True)
        )
        later = np.arange(count + 1) > trials[:, None]
        return trials, why, np.where(later, np.nan, sickness)

    def _allotted(self, why: Sequence[str]) -> list[int]:
        """Allot rows; an incomplete session leaves its order to the next."""
        filled, rows = [0] * len(self._rows), []
        for status in why:
            rows.append(allot(filled, self.design.seed))
            filled[rows[-1]] += status == COMPLETE
        return rows


def _before(means: Floats) -> Floats:
    """Return the mean of the condition before each trial, and its own for the first one."""
    return np.concatenate([means[:, :1], means[:, :-1]], axis=1)


@attrs.frozen(eq=False)
class _Draws:
    """Uniform draws of n people; the length of a person's table depends on the plan alone."""

    susceptible: Floats  # (n)
    level: Floats  # (n, scales)
    taste: Floats  # (n, scales, conditions)
    sickness: Floats  # (n, T + 1)
    dropout: Floats  # (n, T)
    noise: Floats  # (n, scales, T)
    missing: Floats  # (n, scales, T)

    @classmethod
    def of(cls, population: Population, persons: Sequence[int], seed: int, study: int) -> Self:
        """Draw for these people."""
        design, part = population.design, population.part
        s, c = len(design.scales), len(part.conditions)
        t = trials_of(design, part.name)
        # In the order of the fields: the table is cut in this order, and that decides every answer.
        shapes: list[tuple[int, ...]] = [(), (s,), (s, c), (t + 1,), (t,), (s, t), (s, t)]
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
        table = np.stack([table_of(seed, study, part.name, person, int(ends[-1])) for person in persons])
        cuts = np.split(table, ends[:-1], axis=1)
        return cls(*(cut.reshape(len(table), *shape) for cut, shape in zip(cuts, shapes, strict=True)))


def _sickness(model: Model, design: Design, noise: Floats, susceptible: Floats) -> tuple[Floats, Ints]:
    """Return (n, T + 1) answers and (n) the trial after which the stop rule ends the session.

    Answers are NaN where the plan does not ask; the trial lies beyond T where no rule applies.
    noise: (n, T + 1) and susceptible: (n) uniform draws.
    """
    rule, trial = design.sickness, np.arange(noise.shape[1])
    never = noise.shape[1]
    if rule is None:
        return np.full(noise.shape, np.nan), np.full(len(noise), never)
    asked = np.where(trial == 0, design.practice is not None, trial % rule.every == 0)
    felt = model.sickness.latent(trial, susceptible.reshape(-1, 1), noise)
    answers = np.where(asked, of_share(felt, rule.scale), np.nan)
    over = asked & _stops(answers, asked, rule.scale, rule.stop_at, rule.rise)
    return answers, np.where(over.any(axis=1), over.argmax(axis=1), never)


def _stops(
    answers: Floats, asked: NDArray[np.bool_], scale: Scale, stop_at: float | None, rise: float | None
) -> NDArray[np.bool_]:
    """Return (n, T + 1) whether the session ends after each answer."""
    bad = answers - scale.least if scale.low_is_good else scale.most - answers
    over = np.zeros(answers.shape, bool)
    if not asked.any():
        return over
    if stop_at is not None:
        over |= bad >= scale.badness(stop_at)
    if rise is not None:
        over |= bad - bad[:, [int(asked.argmax())]] >= rise
    return over


class Respondent(Protocol):
    """Source of commands besides the participant's own input."""

    def commands(self, step: Step, shown: Show | None, elapsed_s: float) -> Sequence[Command]:
        """Return what the respondent does at this refresh, in the words of LineConsole.commands.

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
            return self._pause(step, elapsed_s) or (
                Command("continue") if step.until_done and elapsed_s >= self._lasts_s(step) else None
            )
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
