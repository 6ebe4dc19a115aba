"""Settings of warps and fills that have limits."""

from __future__ import annotations

import math
from typing import Any

import attrs


def limited(default: float, least: float = 0.0, most: float = math.inf, of: str = "", *, above: bool = False) -> Any:
    """Return a setting from `least` on, or above it, to `most`; of: its unit, or what it counts."""
    if above:
        wanted = f"more than {least:g}" + (f" and at most {most:g}" if most < math.inf else "")
    else:
        wanted = f"{least:g} to {most:g}" if most < math.inf else f"{least:g} or more"
    wanted += f" {of}" if of else ""

    def check(_: object, field: attrs.Attribute[float], value: float) -> None:
        if not (math.isfinite(value) and (least < value if above else least <= value) and value <= most):
            raise ValueError(f"{field.name} is {value:g}: expected {wanted}")

    return attrs.field(default=default, validator=check)


def share_of(default: float) -> Any:
    """Return a setting that is more than 0 and at most 1."""
    return limited(default, 0, 1, above=True)
