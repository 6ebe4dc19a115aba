"""Numbers typed digit by digit, and which numbers a scale has."""

from __future__ import annotations

import functools
from decimal import Decimal

from ..scales import Scale

CLOSE = 1e-6  # of a step: what is typed is decimal, what a scale has are multiples of its step


def on_scale(scale: Scale, number: float) -> float | None:
    """The scale's own value that this is, None if it is none."""
    steps = (number - scale.least) / scale.step
    last = round((scale.most - scale.least) / scale.step)
    if (
        not -CLOSE <= steps <= last + CLOSE or abs(steps - round(steps)) > CLOSE
    ):  # what is not a number is within no bounds
        return None
    return round(scale.least + round(steps) * scale.step, 9)


def nearest(scale: Scale, number: float) -> float:
    """The scale's value next to it."""
    last = round((scale.most - scale.least) / scale.step)
    return round(scale.least + min(max(round((number - scale.least) / scale.step), 0), last) * scale.step, 9)


def middle(scale: Scale, *, upper: bool) -> float:
    """In the middle; of an even number of values the upper or the lower one of the two there."""
    values = scale.values()
    return values[len(values) // 2 if upper else (len(values) - 1) // 2]


def moved(scale: Scale, value: float, steps: int) -> float:
    """So many steps on, within the scale."""
    return nearest(scale, value + steps * scale.step)


def written(number: float) -> str:
    """As people write it, without zeros at its end."""
    return f"{number:.9f}".rstrip("0").rstrip(".")


def range_in_words(scale: Scale) -> str:
    """ "1 to 6 in steps of 0.25"."""
    steps = f" in steps of {written(scale.step)}" if scale.step != 1 else ""
    return f"{written(scale.least)} to {written(scale.most)}{steps}"


def typed_on(scale: Scale, typed: str, character: str) -> str:
    """What stands there after one character more: "0" to "9", "." or ",".

    A digit that leads nowhere begins anew, as one who changes their mind means it; after the point, or where nothing begins so, it changes
    nothing: 6.25 on a scale up to 6 must not become 5.
    """
    character = "." if character == "," else character
    begins = _beginnings(scale.least, scale.most, scale.step)
    anew = () if "." in typed else (character,)
    return next((text for text in (typed + character, *anew) if text in begins), typed)


def number_of(scale: Scale, typed: str) -> float | None:
    """The value that is typed, None while it is none of the scale's."""
    try:
        return on_scale(scale, float(typed))
    except ValueError:
        return None


@functools.lru_cache(16)
def _beginnings(least: float, most: float, step: float) -> frozenset[str]:
    """Of all values, written with as many digits after the point as the scale needs ("3", "3.", "3.5", "3.50")."""
    digits = max(0, *(-int(Decimal(written(number)).as_tuple().exponent) for number in (least, step)))
    texts = (f"{least + k * step:.{digits}f}" for k in range(round((most - least) / step) + 1))
    return frozenset(text[:n] for text in texts for n in range(1, len(text) + 1))
