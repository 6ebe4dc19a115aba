"""The hard cases: each a function or a world, with why it is hard and what must come out."""

from __future__ import annotations

from collections.abc import Callable

import attrs
from worlds import every_choice

from hmdwarp.client import parse_warp
from hmdwarp.client.warp_kinds import HomographyWarp, PlaneWarp

from .setting import Setting

CHOICES = every_choice()
TWIN = "what the float64 twin says"


def knows_one_depth(name: str) -> bool:
    """Whether a warp moves the whole picture by one homography."""
    return issubclass(parse_warp(name).entry, HomographyWarp | PlaneWarp)


@attrs.frozen
class HardCase:
    name: str
    wants: str  # a sentence for the table
    run: Callable[..., None]
    warps: tuple[str, ...]  # the names it is run for


CASES: list[HardCase] = []


def hard_case(wants: str, applies: Callable[[str], bool] = lambda name: True):
    """File the decorated function(gpu, name) as a case for every warp, with each word of its
    settings, that `applies`. Its docstring says why it is hard.
    """

    def register(run: Callable[..., None]) -> Callable[..., None]:
        assert run.__doc__ and run.__name__ not in {case.name for case in CASES}, run.__name__
        CASES.append(HardCase(run.__name__, wants, run, tuple(filter(applies, CHOICES))))
        return run

    return register


def twin_case(name: str, *worlds: Callable[..., Setting], wants: str = TWIN) -> None:
    """File a case for every warp: of each world(gpu) what the twin says. A comment says why."""

    def run(gpu, warp: str) -> None:
        for world in worlds:
            list(world(gpu).pictures(warp))

    CASES.append(HardCase(name, wants, run, tuple(CHOICES)))


def markdown() -> str:
    """The list for docs/hard-cases.md."""
    names = {case.name.replace("_", " "): case.wants for case in CASES}
    others = ", ".join(name for name, wants in names.items() if wants == TWIN)
    return "\n".join([*(f"- {name}: {wants}" for name, wants in names.items() if wants != TWIN), f"- {others}: {TWIN}"])
