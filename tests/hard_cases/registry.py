"""The hard cases.

Each one function, whose docstring says what it is, why it is hard and what must come out.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import attrs
from worlds import every_choice

from hmdwarp.client.warps import warps

# The 64-bit path of forward wants what few drivers have.
CHOICES = [spec for spec in every_choice() if spec != "forward:path=atomic64"]
PARTS = ("What", "Why", "Wants")


@attrs.frozen
class HardCase:
    """name; what, why, wants: sentences for the table; run: the test; warps.

    The names it is run for, () if it needs none.
    """

    name: str
    what: str
    why: str
    wants: str
    run: Callable[..., None]
    warps: tuple[str, ...]


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
        CASES.append(HardCase(run.__name__, parts["What"], parts["Why"], parts["Wants"], run, names))
        return run

    return register


def markdown() -> str:
    """The table for docs/hard-cases.md."""
    lines = ["| case | what | why it is hard | what must come out | warps |", "| --- | --- | --- | --- | --- |"]
    everywhere = {warp.name for warp in warps if warp.kind != "draw"}
    for case in CASES:
        run_for = {spec.partition(":")[0] for spec in case.warps}
        missing = sorted(everywhere - run_for)
        applied = (
            "-" if not case.warps else "all" if not missing else f"all but {', '.join(f'`{name}`' for name in missing)}"
        )
        few = ", ".join(f"`{name}`" for name in sorted(run_for))
        applied = few if run_for and len(run_for) < len(missing) else applied
        lines.append(f"| {case.name.replace('_', ' ')} | {case.what} | {case.why} | {case.wants} | {applied} |")
    return "\n".join(lines)
