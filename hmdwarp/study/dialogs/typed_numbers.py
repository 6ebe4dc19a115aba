"""Numbers typed digit by digit, and the values of a scale."""

from __future__ import annotations

import functools
from decimal import Decimal

from ..scales import Scale, number_text

CLOSE = 1e-6  # of a step: typed numbers are decimal, values of a scale are multiples of its step


def value_of(scale: Scale, number: float) -> float | None:
    """Return the scale's own value for a number, None if the number is not on the scale."""
    steps = (number - scale.least) / scale.step
    last = round((scale.most - scale.least) / scale.step)
    # The first test also refuses NaN.
    if not -CLOSE <= steps <= last + CLOSE or abs(steps - round(steps)) > CLOSE:
        return None
    return round(scale.least + round(steps) * scale.step, 9)


def middle(scale: Scale, *, upper: bool) -> float:
    """Return the middle value; of an even number of values the upper or lower of the two there."""
    values = scale.values()
    return values[len(values) // 2 if upper else (len(values) - 1) // 2]


def moved(scale: Scale, value: float, steps: int) -> float:
    """Return the value that many steps on, within the scale."""
    last = round((scale.most - scale.least) / scale.step)
    number = round((value - scale.least) / scale.step) + steps
    return round(scale.least + min(max(number, 0), last) * scale.step, 9)


def typed_on(scale: Scale, typed: str, character: str) -> str:
    """Return the text after one more character: "0" to "9", "." or ",".

    A digit that leads to no value starts a new number, as people expect who change their mind.
    After the point, or where no value starts so, it changes nothing: 6.25 on a scale up to 6 must
    not become 5.
    """
    character = "." if character == "," else character
    starts = _starts(scale.least, scale.most, scale.step)
    anew = () if "." in typed else (character,)
    return next((text for text in (typed + character, *anew) if text in starts), typed)


def number_of(scale: Scale, typed: str) -> float | None:
    """Return the typed value, None while it is no value of the scale."""
    try:
        return value_of(scale, float(typed))
    except ValueError:
        return None


@functools.lru_cache(16)
def _starts(least: float, most: float, step: float) -> frozenset[str]:
    """Return all beginnings of all values: "3", "3.", "3.5", "3.50"."""
    digits = max(0, *(-int(Decimal(number_text(number)).as_tuple().exponent) for number in (least, step)))
    texts = (f"{least + k * step:.{digits}f}" for k in range(round((most - least) / step) + 1))
    return frozenset(text[:n] for text in texts for n in range(1, len(text) + 1))
