"""Columns of other people's tables: which of them is what, by its name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from ...errors import InputError

# What is looked for, and the names it goes by; the first that is there is taken.
ROLES: Mapping[str, tuple[str, ...]] = {
    "participant": (
        "participant",
        "participant_id",
        "sub",
        "subject",
        "subject_id",
        "person",
        "observer",
        "user",
        "vp",
        "id",
    ),
    "rating": ("rating", "value", "score", "grade", "response", "answer", "vote", "mos"),
    "condition": ("condition", "cond", "treatment", "stimulus"),
    "part": ("part", "run", "group", "experiment"),
    "place": ("trial", "place", "position", "order", "trial_number"),
    "repeat": ("repeat", "repetition", "rep"),
    "session": ("session", "ses"),
    "previous": ("previous",),
    "scale": ("scale",),
    "item": ("item",),
    "reference": ("reference", "hidden_reference"),
    "origin": ("origin",),
    "status": ("status",),
    "low_is_good": ("low_is_good",),
    "latency_ms": ("latency_ms", "latency", "delay_ms", "delay"),
    "warp": ("warp", "method"),
    "fill": ("fill",),
    "scene": ("scene",),
}
SETTINGS = ("latency_ms", "warp", "fill", "scene")
_FALLBACK = ("test",)  # a number of the test: a condition where nothing else says which
MISSING = frozenset({"", "n/a", "na", "nan", "null", "none", ".", "-", "?", "missing"})


def roles_of(header: Sequence[str], named: Mapping[str, str], path: str) -> dict[str, int]:
    """Which column is what. named: by the user, role to column. Errors: InputError where one is not there or is needed and not found."""
    plain = [_plain(name) for name in header]
    found: dict[str, int] = {}
    for role, name in named.items():
        if role not in ROLES:
            raise InputError(f"--column {role}={name}: wanted one of {', '.join(ROLES)} before the '='")
        if _plain(name) not in plain:
            raise InputError(f"{path}:1: no column '{name}' (--column {role}={name}); there are {', '.join(header)}")
        found[role] = plain.index(_plain(name))
    for role, names in ROLES.items():
        if role not in found:
            place = next((plain.index(name) for name in names if name in plain), None)
            if place is not None and place not in found.values():
                found[role] = place
    for name in _FALLBACK:
        if name in plain and "condition" not in found and not set(SETTINGS[:2]) & set(found):
            found["condition"] = plain.index(name)
    _check(found, header, path)
    return found


def _plain(name: str) -> str:
    return re.sub(r"[\s\-]+", "_", name.strip().lower())


def _check(found: Mapping[str, int], header: Sequence[str], path: str) -> None:
    for role in ("participant", "rating"):
        if role not in found:
            known = ", ".join(ROLES[role])
            raise InputError(
                f"{path}:1: no column for the {role} among {', '.join(header)}: wanted one of {known}, or name it: --column {role}=NAME"
            )
    if "condition" not in found and not set(SETTINGS) & set(found):
        raise InputError(
            f"{path}:1: nothing says which condition was rated: wanted a column 'condition', or latency_ms, warp and fill; "
            "or name it: --column condition=NAME"
        )
