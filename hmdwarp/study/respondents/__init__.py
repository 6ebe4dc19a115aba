"""Respondents of a session: none, or a simulated participant who sends people's commands."""

from __future__ import annotations

import hashlib
import math
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from ...base import InputError, Table, fields_in, parsed, read_by, text_of, unknown_name
from ...display import Command
from ..design import PAIR, Ask, Design, Order, Part, Pause, Read, Show, Step, pair_of, trials_of
from ..scales import FIRST, NEITHER, PREFERENCE, QUESTIONNAIRE, SECOND, WORDS, Scale
from ..statistics import JOD_SPREAD
from ..store import COMPLETE, SICK, STOPPED

_64 = (1 << 64) - 1


def person_of(code: str) -> int:
    """Return the number of the simulated person with that code, the same on every machine."""
    return int.from_bytes(hashlib.sha256(code.encode()).digest()[:8], "big")


def table_of(seed: int, part: str, person: int, count: int) -> Floats:
    """Return a person's first `count` uniform draws in [0, 1) in a part of a study."""
    return _uniform(seed, part, person, 0, count)


def draw_for(seed: int, part: str, person: int, thing: str) -> float:
    """Return a uniform draw for one named thing of a session, independent of the person's table."""
    return float(_uniform(seed, part, person, 1 + zlib.crc32(thing.encode()), 1)[0])


def _uniform(seed: int, part: str, person: int, thing: int, count: int) -> Floats:
    counter = np.array([0, thing, zlib.crc32(part.encode()), person & _64], np.uint64)
    key = np.array([seed & _64, 0], np.uint64)
    return np.random.Generator(np.random.Philox(key=key, counter=counter)).random(count)


Floats = NDArray[np.float64]
# Half the least step of a double from [0, 1): a draw of exactly 0 gives the normal -8.3, not -inf.
TINY = 2.0**-54
_PREFERENCE_JOD = 5.0  # from the best of a scale to its worst, where the question is for a preference


def _within(least: float, most: float, default: Any = 0.0, at: str = "", *, above: bool = False) -> Any:
    return read_by(Table.within, least, most, default=default, at=at, above=above)


@attrs.frozen
class RatingModel:
    """Model of the ratings on one scale, in the unit and the direction of that scale.

    Of a preference it is of what is felt of each of the two, more is better, in JOD if noise_sd is
    JOD_SPREAD / sqrt 2; levels, drift and carry-over do not count in it.
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
    # Of a preference: a smaller difference is called none, where that is allowed.
    threshold: float = _within(0, math.inf)
    # Latent ratings of conditions that `means` leaves out, and of hidden references among them;
    # None: an error.
    mean: float | None = None
    reference: float | None = None

    def means_of(self, part: Part, where: str) -> Floats:
        """Return the (conditions) means. where: in the file. Errors: InputError without one."""
        own = self.means.get(part.name)
        table, others = own if isinstance(own, Mapping) else self.means, {True: self.reference, False: self.mean}
        found = {one.name: table.get(one.name, others[one.reference]) for one in part.conditions}
        if lacking := [name for name, mean in found.items() if not isinstance(mean, float)]:
            wanted = f"of part '{part.name}': expected one for each condition"
            raise InputError(f"{where}: no mean for {', '.join(lacking)} {wanted}")
        return np.array(list(found.values()))


@attrs.frozen(kw_only=True)
class _OtherRatings:
    """Other ratings, but `missing` as shares of the scale, from its best (0) to its worst (1)."""

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
            best, way, noise_sd = 0.0, -_PREFERENCE_JOD, JOD_SPREAD / np.sqrt(2)
            of_kind: dict[str, Any] = {"threshold": _PREFERENCE_JOD * self.condition_sd}
        else:
            width = scale.most - scale.least
            best, way = (scale.least, width) if scale.low_is_good else (scale.most, -width)
            noise_sd = width * self.noise_sd
            of_kind = {"people_sd": width * self.people_sd, "drift": way * self.drift}
        return RatingModel(
            condition_sd=abs(way) * self.condition_sd,
            noise_sd=noise_sd,
            missing=self.missing,
            mean=best + way * self.mean,
            reference=best + way * self.reference,
            **of_kind,
        )


@attrs.frozen
class SicknessModel:
    """Model of sickness, as a share of the scale from its best (0) to its worst (1)."""

    start: float = _within(0, 1)  # before the first trial
    per_trial: float = _within(0, 1)  # increase per trial of the median person
    people_sd: float = _within(0, math.inf)  # of the logarithm of a person's susceptibility
    noise_sd: float = _within(0, math.inf)  # of an answer

    def latent(self, trial: ArrayLike, person: float, noise: ArrayLike) -> Floats:
        """Compute the sickness felt after that many trials, not cut at 1, of uniform draws."""
        grown = self.per_trial * np.asarray(trial) * np.exp(self.people_sd * normal(person))
        return np.asarray(self.start + grown + self.noise_sd * normal(noise))


@attrs.frozen
class Model:
    """Response model of a study's participants."""

    path: str  # its file, or "model NAME" of a shipped one, for messages
    title: str = read_by(Table.text, default="", required=True)
    ratings: Mapping[str, RatingModel] = attrs.field(factory=dict, hash=False)  # by scale name
    others: _OtherRatings | None = None  # of what `ratings` leaves out; None: an error
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
        own, other = self.ratings.get(scale.name), self.others and self.others.on(scale)
        if own and other:
            return attrs.evolve(own, mean=other.mean, reference=other.reference)
        if own or other:
            return own or other  # type: ignore[return-value]  # one of them is there
        known = ", ".join(self.ratings) or "none"
        raise InputError(
            f"{self.path}: no [rating.{scale.name}], which the study asks for after each trial; there is {known}: "
            "add it, or use the model quick, which answers every scale (docs/response-models.md)"
        )

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
    """Load a shipped model by its study's name, or a .toml file by path. Errors: InputError."""
    name = str(name_or_path)
    if not name.endswith(".toml") and name not in model_names():
        raise unknown_name("model", name, [*model_names(), "FILE.toml"])
    if not name.endswith(".toml"):
        return model_from_text((_FOLDER / f"{name}.toml").read_text(encoding="utf-8"), f"model {name}")
    return model_from_text(text_of(Path(name), f"a .toml file, or one of {', '.join(model_names())}"), name)


def model_from_text(text: str, path: str) -> Model:
    """Make the model from a text. path: for messages. Errors: as load_model."""

    def made(data: Table) -> Model:
        if (schema := data.raw("schema")) != SCHEMA:
            raise data.fault("schema", f"is {schema!r}: expected {SCHEMA}, which this version of hmdwarp reads")
        ratings, sickness = data.table("rating"), data.table("sickness") if "sickness" in data else Table({})
        scales = {name: ratings.table(name) for name in ratings.keys()}  # noqa: SIM118  (a Table is no dict)
        return Model(
            path=path,
            ratings={
                name: RatingModel(_means(of.table("means")), **fields_in(of, RatingModel))
                for name, of in scales.items()
            },
            others=_OtherRatings(**fields_in(data.table("others"), _OtherRatings)) if "others" in data else None,
            sickness=SicknessModel(**fields_in(sickness, SicknessModel)),
            **fields_in(data, Model),
        )

    return parsed(text, path, made, _EXAMPLE)


def _means(table: Table, *, parts: bool = True) -> dict[str, object]:
    """Read means by condition. parts: whether there may be a table for each part of the study."""
    out: dict[str, object] = {}
    for key in table.keys():  # noqa: SIM118  (a Table is no dict)
        inner = parts and isinstance(table.raw(key), dict)
        out[key] = _means(table.table(key), parts=False) if inner else table.number(key)
    return out


@attrs.frozen(eq=False)
class Answers:
    """Answers of one simulated person with T trials; NaN where there is no answer."""

    trials: int  # shown and rated before the end
    why: str  # status of the session
    ratings: Mapping[str, Floats]  # (T) by scale, rounded to the scale
    sickness: Floats  # (T + 1) answers after the practice and after each trial
    susceptible: float  # uniform draw of how easily the person gets sick


def ratings_for(model: Model, design: Design, part: Part) -> dict[str, tuple[RatingModel, Floats]]:
    """Return the model of each scale and its (conditions) means. Errors: InputError without one."""
    found = {}
    for scale in (one for one in design.scales if one.kind != QUESTIONNAIRE):
        rating = model.rating(scale)
        found[scale.name] = rating, rating.means_of(part, f"{model.path}: [rating.{scale.name}.means]")
    return found


def answers_of(model: Model, design: Design, part: str, seed: int, person: int, order: Order) -> Answers:
    """Return what a person answers in a session of that order. Errors: as ratings_for."""
    shown, t = design.part(part), trials_of(design, part)
    ratings, s, c = ratings_for(model, design, shown), len(design.scales), len(shown.conditions)
    numbers = {condition.name: number for number, condition in enumerate(shown.conditions)}
    pairs = [pair_of(name) if design.shows == PAIR else (name, name) for names in order for name in names]
    first, second = np.array([[numbers[name] for name in pair] for pair in pairs]).T
    # The person's draws are cut in this order, and that decides every answer.
    shapes: dict[str, tuple[int, ...]] = {
        **{"susceptible": (), "level": (s,), "taste": (s, c), "sickness": (t + 1,), "dropout": (t,)},
        **{"noise": (s, t), "missing": (s, t)},
    }
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])
    cuts = zip(shapes.items(), np.split(table_of(seed, part, person, int(ends[-1])), ends[:-1]), strict=True)
    draws = {name: cut.reshape(shape) for (name, shape), cut in cuts}
    susceptible = float(draws["susceptible"])
    sickness, sick_after = _sickness(model, design, draws["sickness"], susceptible)
    leaves = [*np.flatnonzero(draws["dropout"] < model.dropout) + 1, t]
    trials = min(sick_after, int(leaves[0]))
    sickness[trials + 1 :] = np.nan
    answers = {}
    for number, scale in ((k, one) for k, one in enumerate(design.scales) if one.name in ratings):
        rating, means = ratings[scale.name]
        noise, mean = rating.noise_sd * normal(draws["noise"][number]), means[second]
        felt = means + rating.condition_sd * normal(draws["taste"][number])  # of each condition
        if scale.kind == PREFERENCE:
            better = felt[second] - felt[first] + np.sqrt(2) * noise  # of the second, in JOD
            given = np.where(better > 0, SECOND, FIRST)
            if scale.allows_ties:
                given = np.where(np.abs(better) < rating.threshold, NEITHER, given)
        else:
            before = np.concatenate([mean[:1], mean[:-1]])  # before the first trial its own condition counts
            moved = rating.drift * np.arange(t) + rating.carry_over * (before - mean)
            level = rating.people_sd * normal(draws["level"][number])
            given = on_scale(felt[second] + moved + level + noise, scale)
        none = (np.arange(t) >= trials) | (draws["missing"][number] < rating.missing)
        answers[scale.name] = np.where(none, np.nan, given)
    why = SICK if sick_after <= trials else STOPPED if trials < t else COMPLETE
    return Answers(trials, why, answers, sickness, susceptible)


def _sickness(model: Model, design: Design, noise: Floats, susceptible: float) -> tuple[Floats, int]:
    """Return (T + 1) answers, NaN where the plan does not ask, and the trial of the stop rule.

    That lies beyond T where no rule applies. noise: (T + 1) uniform draws.
    """
    rule, trial = design.sickness, np.arange(len(noise))
    if rule is None:
        return np.full(len(noise), np.nan), len(noise)
    asked = np.where(trial == 0, design.practice is not None, trial % rule.every == 0)
    answers = np.where(asked, of_share(model.sickness.latent(trial, susceptible, noise), rule.scale), np.nan)
    bad = answers - rule.scale.least if rule.scale.low_is_good else rule.scale.most - answers
    over = np.zeros(len(noise), bool)
    if rule.stop_at is not None:
        over |= bad >= rule.scale.badness(rule.stop_at)
    if rule.rise is not None and asked.any():
        over |= bad - bad[asked.argmax()] >= rule.rise
    return answers, int([*np.flatnonzero(over & asked), len(noise)][0])


SAID = "simulated words"  # to questions that are answered in words
PATIENCE_S = 0.5  # until a command without effect is tried again, as people do


class Simulated:
    """Simulated participant: person_of(code) with the order of the session.

    Every draw belongs to the person and the question, none to what was asked before: the answers
    are those of answers_of, however often they are asked.
    Errors: InputError where the model lacks a scale or a condition of the study.
    """

    def __init__(self, model: Model, design: Design, part: str, seed: int, person: int, order: Order) -> None:
        self._model, self._part, self._seed, self._person = model, part, seed, person
        self._answers = answers_of(model, design, part, seed, person, order)
        # The visit of a step: its key, the last time in it, and when each command was sent.
        self._key, self._last_s, self._sent = "", math.inf, dict[str, float]()
        self._paused: set[str] = set()  # keys of trials with a pause: one is enough
        self._again: set[str] = set()  # keys of questions that were repeated: once is enough
        self._wants_again = False

    def commands(self, step: Step, shown: Show | None, elapsed_s: float) -> Sequence[Command]:
        """Return the commands of this refresh, in the words of LineConsole.commands.

        Each is sent once in a visit of a step, and again where it had no effect after PATIENCE_S.
        """
        begins = step.key != self._key or elapsed_s < self._last_s  # another step, or the same one from its start
        self._last_s = elapsed_s
        if begins:
            self._key, self._sent = step.key, {}
            if self._wants_again:
                self._wants_again = False
                return (Command("again"),)
        command = self._command(step, shown, elapsed_s)
        if command is None or elapsed_s - self._sent.get(command.control, -math.inf) < PATIENCE_S:
            return ()
        self._sent[command.control] = elapsed_s
        if isinstance(step, Ask) and step.key not in self._again and self._draw("again", step.key) < self._model.again:
            self._again.add(step.key)
            self._wants_again = True
        return (command,)

    def _command(self, step: Step, shown: Show | None, elapsed_s: float) -> Command | None:
        if self._leaves(step, shown):
            return Command("stop")
        if isinstance(step, Show):
            return self._in_trial(step, elapsed_s)
        if elapsed_s < self._model.seconds(self._draw("seconds", step.key)):
            return None
        if not isinstance(step, Ask):
            return Command("agree" if isinstance(step, Read) else "continue")
        if step.item.answer == WORDS:
            return Command("answer", SAID)
        value = self.answer(step, 0 if shown is None else shown.trial)
        return Command("skip") if value is None else Command("answer", value)

    def _in_trial(self, step: Show, elapsed_s: float) -> Command | None:
        """Pause some trials at a random moment, and end those that last until done."""
        lasts_s = step.seconds
        if step.until_done:
            lasts_s = min(lasts_s, self._model.look_seconds(self._draw("look", step.key)))
        wants = step.key not in self._paused and self._draw("pause", step.key) < self._model.pause
        if wants and elapsed_s >= lasts_s * self._draw("pause at", step.key):
            self._paused.add(step.key)
            return Command("pause")
        return Command("continue") if step.until_done and elapsed_s >= lasts_s else None

    def answer(self, step: Ask, trial: int) -> float | None:
        """Return the answer, None for "cannot say". trial: shown last, for later questions."""
        about_trial, answers = step.phase in ("practice", "trial"), self._answers
        rated = step.phase == "trial" and step.scale.name in answers.ratings
        if rated or (about_trial and step.scale.kind != QUESTIONNAIRE):
            value = answers.ratings[step.scale.name][step.trial - 1] if rated else answers.sickness[step.trial]
            return None if np.isnan(value) else float(value)
        draw = self._draw("answer", step.key)
        if step.item.answer or about_trial:
            values = step.scale.of(step.item).values()
            return values[int(draw * len(values))]
        shown = 0 if step.phase == "before" else trial
        return float(of_share(self._model.sickness.latent(shown, answers.susceptible, draw), step.scale))

    def _leaves(self, step: Step, shown: Show | None) -> bool:
        """Return whether a drop-out leaves now: before the trial after the last one."""
        last = self._answers.trials
        return self._answers.why == STOPPED and (
            (isinstance(step, Show) and step.trial > last)
            or (isinstance(step, Pause) and shown is not None and shown.trial >= last)
        )

    def _draw(self, what: str, key: str) -> float:
        return draw_for(self._seed, self._part, self._person, f"{what} {key}")
