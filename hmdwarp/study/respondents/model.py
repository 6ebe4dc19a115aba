"""How simulated participants answer: a few numbers, and the formulas that make answers of uniform draws.

Nothing here draws: whoever calls brings the draws, one at a time for a session, whole tables of them for a thousand studies, and both get
the same answers.
"""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from ...errors import InputError
from ..design import Part
from ..scales import Scale

Floats = NDArray[np.float64]
TINY = (
    2.0**-54
)  # half of the least step of a double drawn from [0, 1): the normal of a draw of exactly 0 is -8.3, not minus infinity


@attrs.frozen
class RatingModel:
    """What makes a rating on one scale, in the scale's own unit; in its direction, whichever that is.

    means: of the latent rating, by condition; tables of them by the names of parts, where parts differ. people_sd: of a person's own
    level. condition_sd: of how a person's opinion of a condition differs from that of others, beyond the level. noise_sd: from one showing
    to the next. drift: per trial after the first. carry_over: of the mean of the condition before, less that of this one, so much is added;
    below 0 where people judge by contrast. missing: share of trials that the participant "cannot say" anything about.
    """

    means: Mapping[str, object] = attrs.field(factory=dict, hash=False)
    people_sd: float = 0.0
    condition_sd: float = 0.0
    noise_sd: float = 0.0
    drift: float = 0.0
    carry_over: float = 0.0
    missing: float = 0.0

    def means_of(self, part: Part, where: str) -> Floats:
        """(conditions) of a part. where: what an error names. Errors: InputError for a condition without one."""
        own = self.means.get(part.name)
        table = own if isinstance(own, Mapping) else self.means
        lacking = [one.name for one in part.conditions if not isinstance(table.get(one.name), float)]
        if lacking:
            raise InputError(
                f"{where}: no mean for {', '.join(lacking)} of part '{part.name}': wanted one for each condition"
            )
        return np.array([table[one.name] for one in part.conditions])

    def latent(
        self, mean: ArrayLike, before: ArrayLike, place: ArrayLike, level: ArrayLike, taste: ArrayLike, noise: ArrayLike
    ) -> Floats:
        """What a rating would be without steps and ends.

        mean: of the condition. before: of the one shown before it, that of the condition itself for the first. place: of the trial, from 0.
        level, taste, noise: uniform draws of the person, of the person and the condition, and of the trial. All broadcast.
        """
        mean = np.asarray(mean, float)
        spread = self.people_sd * normal(level) + self.condition_sd * normal(taste) + self.noise_sd * normal(noise)
        return mean + spread + self.drift * np.asarray(place) + self.carry_over * (np.asarray(before) - mean)


@attrs.frozen
class SicknessModel:
    """How sick somebody is, as a share of the scale from its best (0) to its worst (1).

    start: before the first trial. per_trial: how much worse each trial makes the median person. people_sd: of the logarithm of how much
    more easily than that a person gets sick. noise_sd: of an answer.
    """

    start: float = 0.0
    per_trial: float = 0.0
    people_sd: float = 0.0
    noise_sd: float = 0.0

    def state(self, trial: ArrayLike, person: ArrayLike) -> Floats:
        """After that many trials; person: a uniform draw. Not cut at 1."""
        return self.start + self.per_trial * np.asarray(trial) * np.exp(self.people_sd * normal(person))

    def latent(self, trial: ArrayLike, person: ArrayLike, noise: ArrayLike) -> Floats:
        """What is felt when asked; noise: a uniform draw."""
        return self.state(trial, person) + self.noise_sd * normal(noise)


@attrs.frozen
class Model:
    """path: of its file. ratings: by the name of the scale. dropout: the probability that somebody stops after a trial and its questions;
    pause, again: that somebody asks for a pause in a trial, or for its last question once more. median_s, spread_s: of the time to an
    answer, log-normal; the latter is the standard deviation of its logarithm.
    """

    path: str
    title: str = ""
    ratings: Mapping[str, RatingModel] = attrs.field(factory=dict, hash=False)
    sickness: SicknessModel = SicknessModel()
    dropout: float = 0.0
    pause: float = 0.0
    again: float = 0.0
    median_s: float = 2.0
    spread_s: float = 0.5

    def rating(self, scale: Scale) -> RatingModel:
        """The one for that scale. Errors: InputError where there is none."""
        if scale.name not in self.ratings:
            known = ", ".join(self.ratings) or "none"
            raise InputError(
                f"{self.path}: no [rating.{scale.name}], which the study asks for after each trial; there is {known}"
            )
        return self.ratings[scale.name]

    def seconds(self, draw: float) -> float:
        """The time to an answer, for a uniform draw."""
        return float(self.median_s * np.exp(self.spread_s * normal(draw)))


def normal(uniform: ArrayLike) -> Floats:
    """Standard normal draws of uniform ones in [0, 1)."""
    return ndtri(np.maximum(uniform, TINY))


def on_scale(latent: ArrayLike, scale: Scale) -> Floats:
    """The nearest answer that the scale has: its steps, its ends."""
    steps = np.rint((np.asarray(latent, float) - scale.least) / scale.step)
    return np.clip(np.round(scale.least + steps * scale.step, 9), scale.least, scale.most)


def of_share(share: ArrayLike, scale: Scale) -> Floats:
    """The nearest answer to a share of the scale, from 0, its best, to 1, its worst."""
    span = scale.most - scale.least
    return on_scale(
        scale.least + span * np.asarray(share) if scale.low_is_good else scale.most - span * np.asarray(share), scale
    )
