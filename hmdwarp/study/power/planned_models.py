"""Response models with a planned effect, of ratings and of paired comparisons."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import attrs
import numpy as np

from ...errors import InputError
from ..design import Comparison, Design, Part, rows_for
from ..respondents import Cohort, Floats, Model, Population, RatingModel, load_model, model_names
from ..scales import FIRST, NEITHER, PREFERENCE, RATING, Scale
from ..statistics import JOD_SPREAD, MOST_PAIRS


def planned_model(design: Design, scale: Scale, effect: float, sd: float) -> Model:
    """Return a model of an effect and a spread, in the scale's unit.

    effect: the true difference of every planned comparison. sd: of one person's difference between
    two showings. Half of that variance is opinion, which repeats do not average out, and half is
    chance; people's levels spread as much as their ratings of one condition. There are no dropouts
    and no missing answers. Conditions lie around the middle of the scale.
    Errors: InputError where comparisons contradict each other.
    """
    each = sd / 2  # of opinion and of chance: a difference has the variance 2 (each^2 + each^2) = sd^2
    rating = RatingModel(people_sd=sd / math.sqrt(2), condition_sd=each, noise_sd=each)
    model = Model(path="--effect", title=f"an effect of {effect:g}, sd {sd:g}", ratings={scale.name: rating})
    return with_effect(model, design, scale, effect)


def with_effect(model: Model, design: Design, scale: Scale, effect: float) -> Model:
    """Replace the means, so that every planned comparison differs by the effect."""
    rating = model.rating(scale)
    middle = (scale.least + scale.most) / 2
    means = means_of_parts(design, -effect if scale.low_is_good else effect, middle)
    return attrs.evolve(model, ratings={**model.ratings, scale.name: attrs.evolve(rating, means=means)})


def means_of_parts(design: Design, difference: float, middle: float = 0.0) -> Mapping[str, Mapping[str, float]]:
    """Return means, by part, of which every planned comparison's differ: `better` less baseline.

    Errors: InputError where comparisons contradict each other.
    """
    return {part.name: _means(part, comparisons_of(design, part), difference, middle) for part in design.parts}


def planned_comparisons(design: Design) -> tuple[Comparison, ...]:
    """Return all planned comparisons, each once.

    Errors: InputError where there is none.
    """
    comparisons = tuple(dict.fromkeys(comparison for family in design.families for comparison in family.comparisons))
    if not comparisons:
        raise InputError(f"{design.path}: no [[family]] plans a comparison: power needs one")
    return comparisons


def comparisons_of(design: Design, part: Part) -> list[Comparison]:
    """Return the planned comparisons of a part, each once."""
    return [
        comparison
        for comparison in dict.fromkeys(c for family in design.families for c in family.comparisons)
        if comparison.part == part.name
    ]


def _means(part: Part, comparisons: list[Comparison], difference: float, middle: float) -> Mapping[str, float]:
    """Return the means of least spread around the middle."""
    names = [condition.name for condition in part.conditions]
    if not comparisons:
        return dict.fromkeys(names, middle)
    differences = np.zeros((len(comparisons), len(names)))
    for row, comparison in zip(differences, comparisons, strict=True):
        row[names.index(comparison.baseline)], row[names.index(comparison.better)] = -1, 1
    target = np.full(len(comparisons), difference)
    offsets = np.linalg.lstsq(differences, target, rcond=None)[0]
    if not np.allclose(differences @ offsets, target):
        why = f"its comparisons form a cycle, so they cannot all differ by {abs(difference):g}"
        raise InputError(f"part '{part.name}': {why}: set the means in a file (--model)")
    return {name: middle + float(offset) for name, offset in zip(names, offsets, strict=True)}


UNIT = "JOD"
MOST_COUNTS = 9  # numbers of people from a range: so many columns fit a terminal
TIE_JOD = 0.5  # a smaller difference is called none: 26 % of answers where there is none at all
# Of a person's own taste, where it is not set: half of the variance of a judgement, as of ratings.
TASTE_JOD = JOD_SPREAD / math.sqrt(2)


def pairs_model(design: Design, scale: Scale, effect: float, sd: float | None = None) -> Model:
    """Return a model of an effect and a spread, in JOD.

    effect: the true difference of every planned comparison: 1 JOD is preferred in 75 % of choices,
    over all people. sd: how much people differ in it, which repeats do not average out; the rest of
    that spread is chance; None for TASTE_JOD. There are no dropouts and no missing answers.
    Errors: InputError for more spread than 1 JOD leaves room for, and where comparisons contradict
    each other.
    """
    sd = TASTE_JOD if sd is None else sd
    if not sd <= JOD_SPREAD:
        why = f"expected {JOD_SPREAD:.2f} at most, as 1 JOD is preferred in 75 % of the choices of all people"
        raise InputError(f"--sd {sd:g}: {why}")
    noise = math.sqrt((JOD_SPREAD**2 - sd**2) / 2)
    rating = RatingModel(condition_sd=sd / math.sqrt(2), noise_sd=noise, threshold=TIE_JOD)
    model = Model(path="--effect", title=f"an effect of {effect:g} JOD, sd {sd:.2f}", ratings={scale.name: rating})
    return pairs_with_effect(model, design, scale, effect)


def pairs_with_effect(model: Model, design: Design, scale: Scale, effect: float) -> Model:
    """Replace the means, so that every planned comparison differs by the effect."""
    means: Mapping[str, object] = means_of_parts(design, effect)
    return attrs.evolve(model, ratings={**model.ratings, scale.name: attrs.evolve(model.rating(scale), means=means)})


def expected_jod(population: Population, scale: Scale, comparison: Comparison) -> float:
    """Return by how many JOD `better` is better than the baseline, over all people."""
    rating = population.model.rating(scale)
    means = dict(
        zip((condition.name for condition in population.part.conditions), population.means(scale.name), strict=True)
    )
    difference = float(means[comparison.better] - means[comparison.baseline])
    spread = math.sqrt(2 * (rating.condition_sd**2 + rating.noise_sd**2))
    if not spread:
        return math.copysign(math.inf, difference) if difference else 0.0
    return difference * JOD_SPREAD / spread


def choice_differences(
    cohort: Cohort, scale: Scale, comparison: Comparison, *, latent: bool = False, people: slice = slice(None)
) -> Floats:
    """Return each person's choices of `better` over the baseline, less those the other way round.

    Of those who answered such a pair, as `study analyse` tests them. latent: the sum of what is
    felt instead.
    """
    names = [condition.name for condition in cohort.part.conditions]
    better, baseline = names.index(comparison.better), names.index(comparison.baseline)
    first, second = cohort.first[people], cohort.order[people]
    if latent:
        to_second = cohort.latent[scale.name][people]
    else:
        answers = cohort.answers[scale.name][people]
        choice = np.where(answers == NEITHER, 0.0, np.where(answers == FIRST, -1.0, 1.0))
        to_second = np.where(np.isnan(answers), np.nan, choice)
    sign = np.where((first == baseline) & (second == better), 1.0, 0.0)
    sign[(first == better) & (second == baseline)] = -1.0
    answered = ((sign != 0) & ~np.isnan(to_second)).any(axis=1)
    return np.asarray(np.nansum(sign * to_second, axis=1)[answered])


def model_for(
    design: Design, scale: Scale, effect: float | None = None, sd: float | None = None, name: str | None = None
) -> Model:
    """Return the response model of a scale that the options of `study power` describe.

    name: of a model; by default that of the study, if there is one and no sd.
    Errors: InputError for too few or conflicting options.
    """
    if effect is not None and not math.isfinite(effect):
        raise InputError(f"--effect {effect:g}: expected a number, in units of '{scale.name}'")
    if sd is not None and not 0 < sd < math.inf:
        raise InputError(f"--sd {sd:g}: expected a number above 0, in units of '{scale.name}'")
    if name is not None and sd is not None:
        raise InputError("--sd and --model both set how much people differ: leave one out")
    if name is None and sd is None and design.name in model_names():
        name = design.name
    is_pairs = scale.kind == PREFERENCE
    if name is not None:
        found = load_model(name)
        if scale.name not in found.ratings:
            has = ", ".join(found.ratings) or "none"
            raise InputError(
                f"{found.path}: no [rating.{scale.name}], which the study asks for after each trial: add it, or plan "
                f"another scale of the study by --scale ({has} in the model)"
            )
        if effect is None:
            return found
        return (pairs_with_effect if is_pairs else with_effect)(found, design, scale, effect)
    if is_pairs:
        if effect is None:
            raise InputError("no response model: expected --effect (in JOD), or --model FILE.toml")
        return pairs_model(design, scale, effect, sd)
    if effect is None or sd is None:
        wanted = "--sd (of one person's difference between two showings)" if effect is not None else "--effect and --sd"
        raise InputError(f"no response model: expected {wanted}, or --model FILE.toml")
    return planned_model(design, scale, effect, sd)


def scales_for(design: Design, name: str | None = None) -> tuple[Scale, ...]:
    """Return the scales after each trial that have a power, or the one of that name.

    Errors: InputError for another name, and where no comparison is planned.
    """
    planned_comparisons(design)  # raises where there is nothing to plan for
    known = {scale.name: scale for scale in design.scales if scale.kind in (RATING, PREFERENCE)}
    if name is not None and name not in known:
        raise InputError(f"--scale {name}: {design.path} has {', '.join(known)} after each trial")
    return tuple(known.values()) if name is None else (known[name],)


def numbers_of_people(text: str, design: Design) -> tuple[int, ...]:
    """Return the numbers of people of a list, "10,12", or those of "6..40" that balance the orders.

    Errors: InputError.
    """
    many = MOST_PAIRS  # a person gives one pair at most
    wanted = f"expected numbers of people, from 1 to {many}"
    if re.fullmatch(r"\d+(,\d+)*", text):
        counts = sorted({int(number) for number in text.split(",")})
    elif found := re.fullmatch(r"(\d+)\.\.(\d+)", text):
        least, most = int(found[1]), int(found[2])
        if least > most:
            raise InputError(f"--n {text}: runs backwards: expected the smaller number first, {most}..{least}")
        if most > many:
            raise InputError(f"--n {text}: {wanted}")
        step = math.lcm(*(len(rows_for(design, part.name)) for part in design.parts))
        counts = [count for count in range(step, most + 1, step) if count >= least]
        counts = counts[:: max(1, math.ceil(len(counts) / MOST_COUNTS))]
        if len(counts) < 2:
            counts = sorted({*range(least, most + 1, max(1, (most - least) // 8)), *counts})
    else:
        raise InputError(f"--n {text}: expected a range like 6..40, or a list like 10,12,15")
    if not counts or counts[0] < 1 or counts[-1] > many:
        raise InputError(f"--n {text}: {wanted}")
    return tuple(counts)
