"""Response models with a planned effect, by which every comparison of the study differs."""

from __future__ import annotations

import math
from collections.abc import Mapping

import attrs
import numpy as np

from ...errors import InputError
from ..design import ADAPTIVE, Comparison, Design, Part
from ..respondents import Model, RatingModel
from ..scales import Scale


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

    Errors: InputError where there is none, and where answers choose what is compared.
    """
    comparisons = tuple(dict.fromkeys(one for family in design.families for one in family.comparisons))
    if not comparisons:
        raise InputError(f"{design.path}: no [[family]] plans a comparison: power needs one")
    if design.order == ADAPTIVE:
        raise InputError(
            f'{design.path}: order = "{ADAPTIVE}" lets answers choose the pairs, so their number is not planned: '
            "expected a plan without it; a session then has more trials"
        )
    return comparisons


def comparisons_of(design: Design, part: Part) -> list[Comparison]:
    """Return the planned comparisons of a part, each once."""
    return [
        one
        for one in dict.fromkeys(c for family in design.families for c in family.comparisons)
        if one.part == part.name
    ]


def _means(part: Part, comparisons: list[Comparison], difference: float, middle: float) -> Mapping[str, float]:
    """Return the means of least spread around the middle."""
    names = [one.name for one in part.conditions]
    if not comparisons:
        return dict.fromkeys(names, middle)
    differences = np.zeros((len(comparisons), len(names)))
    for row, one in zip(differences, comparisons, strict=True):
        row[names.index(one.baseline)], row[names.index(one.better)] = -1, 1
    target = np.full(len(comparisons), difference)
    offsets = np.linalg.lstsq(differences, target, rcond=None)[0]
    if not np.allclose(differences @ offsets, target):
        why = f"its comparisons form a cycle, so they cannot all differ by {abs(difference):g}"
        raise InputError(f"part '{part.name}': {why}: set the means in a file (--model)")
    return {name: middle + float(offset) for name, offset in zip(names, offsets, strict=True)}
