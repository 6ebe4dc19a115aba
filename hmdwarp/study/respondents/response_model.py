"""Response models: how simulated people rate, feel and leave; and their random draws."""

from __future__ import annotations

import hashlib
import math
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from ...errors import InputError, unknown_name
from ...options import Table, parsed, text_of
from ..design import Part
from ..scales import PREFERENCE, Scale
from ..statistics import JOD_SPREAD

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
SHARE, SPREAD, SECONDS, LOG, CARRY = (0, 1), (0, math.inf), (0, 3600, True), (0, 5), (-1, 1)


def _number(limits: tuple[float, ...] = (), default: Any = 0.0, key: str = "") -> Any:
    """Declare a number of the file. limits: as Table.within takes them. key: table and key."""
    return attrs.field(default=default, metadata={"limits": limits, "key": key})


def _numbers(cls: type[attrs.AttrsInstance], tables: Mapping[str, Table]) -> dict[str, float]:
    """Read the numbers that a class declares. tables: by the first word of a key."""
    found: dict[str, float] = {}
    for field in attrs.fields(cls):
        if "limits" not in field.metadata:
            continue
        inside, _, key = field.metadata["key"].rpartition(".")
        table, key = tables[inside], key or field.name
        least, most, *above = field.metadata["limits"] or (0, 0)
        default = () if field.default is attrs.NOTHING else (field.default,)
        found[field.name] = (
            table.within(key, least, most, *default, above=bool(above))
            if field.metadata["limits"]
            else table.number(key, *default)
        )
    return found


@attrs.frozen
class RatingModel:
    """Model of the ratings on one scale, in the unit and the direction of that scale.

    Of a preference it is that of what is felt of each of the two, where more is better; in JOD if
    noise_sd is JOD_SPREAD / sqrt 2. Levels, drift and carry-over do not count in it.
    """

    # Latent rating by condition, or a table of them by part, where the parts differ.
    means: Mapping[str, object] = attrs.field(factory=dict, hash=False)
    people_sd: float = _number(SPREAD)  # of a person's own level
    condition_sd: float = _number(SPREAD)  # of a person's opinion of a condition, beyond that level
    noise_sd: float = _number(SPREAD)  # from one showing to the next
    drift: float = _number()  # per trial after the first
    # Share of (mean of the condition before - mean of this one) that is added; negative: contrast.
    carry_over: float = _number(CARRY)
    missing: float = _number(SHARE)  # share of trials answered with "cannot say"
    threshold: float = _number(SPREAD)  # of a preference: a smaller difference is called none, where that is allowed
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

    mean: float = _number(SHARE, attrs.NOTHING)  # of a condition
    reference: float = _number(SHARE, attrs.NOTHING)  # of a hidden reference
    people_sd: float = _number(SPREAD)  # the rest as in RatingModel
    condition_sd: float = _number(SPREAD)
    noise_sd: float = _number(SPREAD)
    drift: float = _number()
    missing: float = _number(SHARE)

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

    start: float = _number(SHARE)  # before the first trial
    per_trial: float = _number(SHARE)  # increase per trial of the median person
    people_sd: float = _number(SPREAD)  # of the logarithm of a person's susceptibility
    noise_sd: float = _number(SPREAD)  # of an answer

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
    title: str = ""
    ratings: Mapping[str, RatingModel] = attrs.field(factory=dict, hash=False)  # by scale name
    others: OtherRatings | None = None  # of what `ratings` leaves out; None: an error
    sickness: SicknessModel = SicknessModel()
    dropout: float = _number(SHARE, key="sessions.dropout")  # of leaving after a trial and its questions
    pause: float = _number(SHARE, key="sessions.pause")  # probability of a pause in a trial
    again: float = _number(SHARE, key="sessions.again")  # of repeating the last question of a trial
    # Time to an answer, log-normal: its median, and the standard deviation of its logarithm.
    median_s: float = _number(SECONDS, 2.0, "answers.median_s")
    spread_s: float = _number(LOG, 0.5, "answers.spread_s")
    # Time in a trial that the participant ends, log-normal too.
    look_median_s: float = _number(SECONDS, 20.0, "looks.median_s")
    look_spread_s: float = _number(LOG, 0.5, "looks.spread_s")

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
    ratings = data.table("rating")
    tables = {key: data.table(key) if key in data else Table({}) for key in ("sessions", "answers", "looks")}
    scales = {name: ratings.table(name) for name in ratings.keys()}  # noqa: SIM118  (a Table is no dict)
    return Model(
        path=path,
        title=data.text("title"),
        ratings={
            name: RatingModel(means=_means(of.table("means")), **_numbers(RatingModel, {"": of}))
            for name, of in scales.items()
        },
        others=OtherRatings(**_numbers(OtherRatings, {"": data.table("others")})) if "others" in data else None,
        sickness=SicknessModel(
            **_numbers(SicknessModel, {"": data.table("sickness") if "sickness" in data else Table({})})
        ),
        **_numbers(Model, tables),
    )


def _means(table: Table, *, parts: bool = True) -> dict[str, object]:
    """Read means by condition. parts: whether there may be a table for each part of the study."""
    out: dict[str, object] = {}
    for key in table.keys():  # noqa: SIM118  (a Table is no dict)
        inner = parts and isinstance(table.raw(key), dict)
        out[key] = _means(table.table(key), parts=False) if inner else table.number(key)
    return out
