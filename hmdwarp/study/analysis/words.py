"""Numbers as papers print them."""

from __future__ import annotations

import math

ALPHA = 0.05


def p_text(p: float | None) -> str:
    """".226", ".0098", "< .0001"; three digits from .01 on, two below, as the level of .05 asks for."""
    if p is None or math.isnan(p):
        return "–"
    if p < 1e-4:
        return "< .0001"
    text = f"{p:.3f}" if p >= 0.01 else f"{p:.4f}"
    return text if p >= 0.9995 else text.removeprefix("0")


def p_is(p: float) -> str:
    """"p = .0098" or "p < .0001"."""
    text = p_text(p)
    return f"p {text}" if text.startswith("<") else f"p = {text}"


def signed(value: float | None, digits: int = 2) -> str:
    """"+1.30", "-0.56", "0.00"; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:+.{digits}f}"
    return text[1:] if float(text) == 0 else text


def plain(value: float | None, digits: int = 2) -> str:
    """"2.62"; a dash for None."""
    return "–" if value is None or math.isnan(value) else f"{value:.{digits}f}"


def counted(number: int, word: str) -> str:
    """"1 person", "3 ratings"."""
    return f"{number} {word if number == 1 else {'person': 'people'}.get(word, word + 's')}"


def listed(names: list[str], word: str = "and") -> str:
    """"a, b and c"."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}" if names else "nobody"
