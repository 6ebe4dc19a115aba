"""Kinds of settings that several warps and fills share."""

from __future__ import annotations

import attrs


def share_of(default: float) -> float:
    """Return a setting that is more than 0 and at most 1."""
    return attrs.field(default=default, validator=_check_share)


def _check_share(_: object, field: attrs.Attribute, value: float) -> None:
    if not 0 < value <= 1:
        raise ValueError(f"{field.name} is {value:g}: expected more than 0 and at most 1")
