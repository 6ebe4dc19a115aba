"""Which conditions are compared: as planned, else as the conditions themselves suggest."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from ...errors import InputError
from ..design import Comparison, Family
from .ratings import Ratings

_MOST_PAIRS = 45  # of a part without a plan: ten conditions, each against each


def families_for(ratings: Ratings, asked: Sequence[str] = ()) -> tuple[tuple[Family, ...], str]:
    """The families, and a sentence on where they come from.

    asked: as typed, "A:B,C:D" or "PART/A:B", each text a family. Without them those of the plan; without a plan, in each part: at each
    latency no warp against each warp; else each condition against the hidden reference; else all pairs. Errors: InputError for names
    that nobody rated.
    """
    if asked:
        found = tuple(family for text in asked for family in _asked(text, ratings))
        return found, "Compared: what was asked for with --family."
    if ratings.families:
        return ratings.families, "Compared: what the study's file plans."
    found, why = [], []
    for part in ratings.parts():
        pairs, sentence = _natural(ratings, part)
        if pairs:
            found.append(
                Family(f"{part}: {sentence}" if part else sentence, tuple(Comparison(part, a, b) for a, b in pairs))
            )
            why.append(sentence)
    told = "; ".join(dict.fromkeys(why)) or "nothing, as there is one condition only"
    return tuple(found), f"Compared: {told}. No comparison was planned there; --family says another."


def _asked(text: str, ratings: Ratings) -> list[Family]:
    part, slash, rest = text.partition("/")
    parts = [part] if slash and part in ratings.parts() else list(ratings.parts())
    pairs = [
        tuple(name.strip() for name in pair.split(":"))
        for pair in (rest if slash and part in ratings.parts() else text).split(";")
    ]
    if any(len(pair) != 2 or not all(pair) for pair in pairs):
        raise InputError(
            f"--family '{text}': wanted pairs of conditions, like 'late-200:warped-200;late-400:warped-400'"
        )
    found = []
    for one in parts:
        known = ratings.conditions(one)
        here = [Comparison(one, a, b) for a, b in pairs if a in known and b in known]
        if here:
            found.append(Family(f"{one}: as asked" if one else "as asked", tuple(here)))
    named = {(c.a, c.b) for family in found for c in family.comparisons}
    for pair in pairs:
        if pair not in named:
            known = "; ".join(dict.fromkeys(name for one in parts for name in ratings.conditions(one)))
            raise InputError(
                f"--family '{text}': no part has both '{pair[0]}' and '{pair[1]}': the conditions are {known}"
            )
    return found


def _natural(ratings: Ratings, part: str) -> tuple[list[tuple[str, str]], str]:
    names = ratings.conditions(part)
    settings = {name: ratings.settings(part, name) for name in names}

    def rest(name: str) -> tuple:
        return tuple(sorted((key, str(value)) for key, value in settings[name].items() if key not in ("warp", "fill")))

    bare = [name for name in names if settings[name].get("warp") == "none" and "latency_ms" in settings[name]]
    pairs = [(a, b) for a in bare for b in names if settings[b].get("warp", "none") != "none" and rest(a) == rest(b)]
    if pairs:
        return pairs, "at each latency no warp against each warp"
    references = ratings.references(part)
    if references:
        return [
            (name, references[0]) for name in names if name not in references
        ], "each condition against the hidden reference"
    pairs = list(itertools.combinations(names, 2))
    if len(pairs) > _MOST_PAIRS:
        raise InputError(
            f"{len(names)} conditions and no plan: say with --family which of the {len(pairs)} pairs to compare"
        )
    return pairs, "each condition against each"
