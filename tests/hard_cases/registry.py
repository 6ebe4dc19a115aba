"""The hard cases. Each one function, whose docstring says what it is, why it is hard and what must
come out."""

from __future__ import annotations

import re
from collections.abc import Callable

import attrs
from worlds import every_choice

# The 64-bit path of forward wants what few drivers have.
CHOICES = [spec for spec in every_choice() if spec != "forward:path=atomic64"]
PARTS = ("What", "Why", "Wants")
TWIN = "what the float64 twin says"


@attrs.frozen
class HardCase:
    name: str
    wants: str  # a sentence for the table
    run: Callable[..., None]
    warps: tuple[str, ...]  # the names it is run for, () if it needs none


CASES: list[HardCase] = []


def hard_case(applies: Callable[[str], bool] | None = lambda name: True):
    """File the decorated function(gpu, name) as a case for every warp, with each word of its
    settings, that `applies`; None: function() needs no warp.

    Errors: ValueError for a docstring without its three parts, and for a name that is taken.
    """

    def register(run: Callable[..., None]) -> Callable[..., None]:
        found = re.findall(r"^\s*(\w+): (.+?)(?=^\s*\w+: |\Z)", run.__doc__ or "", re.MULTILINE | re.DOTALL)
        parts = {part: " ".join(text.split()) for part, text in found}
        if list(parts) != list(PARTS) or run.__name__ in {case.name for case in CASES}:
            raise ValueError(
                f"hard case '{run.__name__}' must be the only one of that name and say {', '.join(PARTS)} in its "
                "docstring"
            )
        names = () if applies is None else tuple(spec for spec in CHOICES if applies(spec))
        CASES.append(HardCase(run.__name__, parts["Wants"], run, names))
        return run

    return register


def markdown() -> str:
    """The list for docs/hard-cases.md."""
    names = {case.name.replace("_", " "): case.wants for case in CASES}
    others = ", ".join(name for name, wants in names.items() if wants == TWIN)
    return "\n".join([*(f"- {name}: {wants}" for name, wants in names.items() if wants != TWIN), f"- {others}: {TWIN}"])
