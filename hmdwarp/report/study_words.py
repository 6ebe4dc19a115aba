"""Numbers as papers print them."""

from __future__ import annotations

import math
from decimal import ROUND_HALF_UP, Decimal

ALPHA = 0.05


def p_text(p: float | None) -> str:
    """As ".226", ".0098", "3e-7": three digits after the point, four below .01, one digit and the power of ten below .0001."""
    if p is None or math.isnan(p):
        return "–"
    if p < 1e-4:
        digit, _, power = f"{p:.0e}".partition("e")
        return f"{digit}e{int(power)}"
    # Exact p are dyadic fractions that often end in 5: .3125 is printed as .313, not to the even digit.
    text = str(Decimal(p).quantize(Decimal("0.001" if p >= 0.01 else "0.0001"), ROUND_HALF_UP))
    return text.removeprefix("0") if p < 0.9995 else text


def p_is(p: float) -> str:
    """As "p = .0098"."""
    return f"p = {p_text(p)}"


def signed(value: float | None, digits: int = 2) -> str:
    """As "+1.30", "-0.56", "0.00"; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:+.{digits}f}"
    return text[1:] if float(text) == 0 else text


def interval(low: float | None, high: float | None, digits: int = 2) -> str:
    """As "-0.16 .. +0.75"; a dash where there is none."""
    return "–" if low is None or high is None else f"{signed(low, digits)} .. {signed(high, digits)}"


def plain(value: float | None, digits: int = 2) -> str:
    """As "2.62"; a dash for None."""
    return "–" if value is None or math.isnan(value) else f"{value:.{digits}f}"


def counted(number: int, word: str) -> str:
    """As "1 person", "3 ratings"."""
    return f"{number} {word if number == 1 else {'person': 'people'}.get(word, word + 's')}"


def listed(names: list[str], word: str = "and") -> str:
    """As "a, b and c"."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}" if names else "nobody"


def pair_text(a: str, b: str) -> str:
    """As "none → forward, 200 ms": two conditions, with what both names end in said once."""
    head, comma, tail = a.rpartition(", ")
    return f"{head} → {b}" if comma and b.endswith(f", {tail}") else f"{a} → {b}"
