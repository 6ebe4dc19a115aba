"""Numbers as papers print them."""

from __future__ import annotations

import math
import re
from decimal import ROUND_HALF_UP, Decimal

from .. import errors

ALPHA = 0.05
# Words that other packages take from here too.
counted, listed = errors.counted, errors.listed


def p_text(p: float | None) -> str:
    """Return p as ".226", ".0098" or "3e-7".

    Three digits after the point, four below .01, one digit and the power of ten below .0001.
    """
    if p is None or math.isnan(p):
        return "–"
    if p < 1e-4:
        digit, _, power = f"{p:.0e}".partition("e")
        return f"{digit}e{int(power)}"
    # Exact p are dyadic fractions that often end in 5: .3125 is printed as .313, not to the even
    # digit.
    text = str(Decimal(p).quantize(Decimal("0.001" if p >= 0.01 else "0.0001"), ROUND_HALF_UP))
    return text.removeprefix("0") if p < 0.9995 else text


def p_is(p: float) -> str:
    """Return p as "p = .0098"."""
    return f"p = {p_text(p)}"


def signed(value: float | None, digits: int = 2) -> str:
    """Return "+1.30", "-0.56" or "0.00"; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:+.{digits}f}"
    return text[1:] if float(text) == 0 else text


def interval(low: float | None, high: float | None, digits: int = 2) -> str:
    """Return "-0.16 .. +0.75"; a dash if an end is None."""
    return "–" if low is None or high is None else f"{signed(low, digits)} .. {signed(high, digits)}"


def plain(value: float | None, digits: int = 2) -> str:
    """Return "2.62", and "0.00" for what rounds to it from below; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text


def pair_text(baseline: str, condition: str) -> str:
    """Return "forward over none, 200 ms"; a positive difference is a gain over the baseline.

    The common end of the two names is written once.
    """
    head, comma, tail = condition.rpartition(", ")
    return f"{head if comma and baseline.endswith(f', {tail}') else condition} over {baseline}"


def name_pieces(text: str) -> list[str]:
    """Split a long name where it may break: after the colon, comma or blank between its parts."""
    return re.split(r"(?<=[:, ])(?=\S)", text)
