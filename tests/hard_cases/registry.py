"""The hard cases: each one function, whose docstring says what it is, why it is hard and what must come out."""

from __future__ import annotations

import re
from collections.abc import Callable

import attrs

from hmdwarp.client.warps import warps

PARTS = ("What", "Why", "Wants")


@attrs.frozen
class HardCase:
    """name; what, why, wants: sentences for the table; run: the test; warps: the names it is run for, () if it needs none."""

    name: str
    what: str
    why: str
    wants: str
    run: Callable[..., None]
    warps: tuple[str, ...]


CASES: list[HardCase] = []


def hard_case(applies: Callable[[str], bool] | None = lambda name: True):
    """File the decorated function(gpu, name) as a case for every registered warp that `applies`; None: function() needs no warp.

    Errors: ValueError for a docstring without its three parts, and for a name that is taken.
    """

    def register(run: Callable[..., None]) -> Callable[..., None]:
        told = dict(re.findall(r"^\s*(\w+): (.+?)$", run.__doc__ or "", re.MULTILINE))
        if list(told) != list(PARTS) or run.__name__ in {case.name for case in CASES}:
            raise ValueError(f"hard case '{run.__name__}' must be the only one of that name and say {', '.join(PARTS)} in its docstring")
        names = () if applies is None else tuple(name for name in warps.names() if applies(name))
        CASES.append(HardCase(run.__name__, told["What"], told["Why"], told["Wants"], run, names))
        return run

    return register


def markdown() -> str:
    """The table for docs/hard-cases.md."""
    lines = ["| case | what | why it is hard | what must come out | warps |", "| --- | --- | --- | --- | --- |"]
    everywhere = set(warps.names())
    for case in CASES:
        missing = sorted(everywhere - set(case.warps))
        told = "-" if not case.warps else "all" if not missing else f"all but {', '.join(f'`{name}`' for name in missing)}"
        few = ", ".join(f"`{name}`" for name in case.warps)
        told = few if case.warps and len(case.warps) < len(missing) else told
        lines.append(f"| {case.name.replace('_', ' ')} | {case.what} | {case.why} | {case.wants} | {told} |")
    return "\n".join(lines)
