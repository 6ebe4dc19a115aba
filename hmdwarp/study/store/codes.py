"""What participants are called: a code that the experimenter types, and a random word for everything that leaves the machine."""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable

from ...errors import InputError

NEW = "new"
_CODE = re.compile(r"[A-Za-z0-9_-]{1,32}")
_CLEAR = "ABCDEFGHJKMNPQRTUVWXY34678"  # what is read and typed without doubt: no 0 and O, 1, I and L, 2 and Z, 5 and S, 9 and g
_SUB = "abcdefghijklmnopqrstuvwxyz0123456789"  # BIDS takes letters and digits alone


def check_code(code: str) -> None:
    """Errors: InputError for what is none."""
    if not _CODE.fullmatch(code):
        raise InputError(
            f"--participant {code!r}: a code of 1 to 32 letters a-z, digits, - and _ is wanted, as P07; it must not be a name, "
            "nor tell who it is ('new' draws one)"
        )


def draw_code(taken: Callable[[str], bool]) -> str:
    """One that nobody has: five signs, twelve million of them."""
    return _draw(_CLEAR, 5, taken)


def draw_sub(taken: Callable[[str], bool]) -> str:
    """Random, from nothing that is known of anybody: twelve signs."""
    return _draw(_SUB, 12, taken)


def _draw(signs: str, length: int, taken: Callable[[str], bool]) -> str:
    while True:
        word = "".join(secrets.choice(signs) for _ in range(length))
        if not taken(word):
            return word
