"""Repairs, by name: each mends depth as cameras give it (holes, mixed edges), before a warp."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, NoSettings, Registry, in_brief, parse_choice

_MODULES = dict.fromkeys(("complete", "edges", "none"), "edges")
_COLUMNS = "needs settings=Settings source"
repairs: Registry[type[Repair]] = Registry("repair", __name__, columns=_COLUMNS, modules=_MODULES)


def parse_repairs(text: str) -> RepairChain:
    """Parse 'edges+complete', with 'name:key=value,..'. Errors: UnknownNameError, InputError."""
    if not isinstance(text, str):
        why = f"{', '.join(repairs.names())}, or several with +"
        raise InputError(f"repair is {in_brief(text)}: expected a name: {why}")
    chain = tuple(parse_choice(repairs, part.strip()) for part in text.split("+"))
    if len(chain) > 1 and not all(choice.entry.is_pass for choice in chain):
        raise InputError(f"repair '{text}': 'none' in a chain means nothing; leave it out")
    chain = tuple(choice for choice in chain if choice.entry.is_pass)
    return RepairChain(tuple(choice.entry(choice.settings) for choice in chain), "+".join(map(str, chain)) or "none")


Pixels = NDArray[np.float32]


# Confidence of any guess: half floats on the GPU tell it from none, and from measured depth.
LEAST_SURE, MOST_SURE = np.float32(2.0**-10), np.float32(1 - 2.0**-10)


@attrs.frozen(eq=False)
class MeasuredDepth:
    """Depth of one picture, and how sure it is; (h, w), the top row first."""

    inverse_depth: Pixels  # 1/m along -z; 0 is infinitely far, NaN is no depth
    confidence: Pixels  # 1 as measured, less where it is a guess, 0 where there is no depth


class Repair(ABC):
    """Make depth fit for warping, without memory; arguments are never changed."""

    name: ClassVar[str]
    summary: ClassVar[str]
    needs: ClassVar[str]  # What it runs on, in words.
    source: ClassVar[str]
    is_pass: ClassVar[bool] = True  # false for the repair that does nothing, which is left out
    Settings: ClassVar[type] = NoSettings  # An attrs class of the settings, each with a default.

    def __init__(self, settings: Any = None) -> None:
        self.settings = self.Settings() if settings is None else settings

    @abstractmethod
    def run(self, colour: Pixels, depth: MeasuredDepth) -> MeasuredDepth:
        """Return the repaired depth. colour: (h, w, 3) sRGB, 0 to 1, as depth has its rows."""


@attrs.frozen
class RepairChain:
    steps: tuple[Repair, ...] = ()
    text: str = "none"  # the shortest text that makes the same chain

    def run(self, colour: Pixels, inverse_depth: NDArray[Any]) -> MeasuredDepth:
        """Return the repaired depth of colour (h, w, 3) sRGB 0 to 1 and (h, w) 1/m or NaN."""
        inverse = np.asarray(inverse_depth, np.float32)
        depth = MeasuredDepth(inverse, (~np.isnan(inverse)).astype(np.float32))
        for step in self.steps:
            depth = step.run(colour, depth)
        known = (depth.inverse_depth >= 0) & (depth.confidence > 0)
        return MeasuredDepth(
            np.where(known, depth.inverse_depth, np.float32(np.nan)),
            np.where(known, np.clip(depth.confidence, LEAST_SURE, 1), np.float32(0)),
        )


def _check_limit(_: object, field: attrs.Attribute[float], value: float) -> None:
    if not 0 <= value < float("inf"):
        raise ValueError(f"{field.name} is {value:g}: expected 0 or more")


@attrs.frozen
class SurfaceSettings:
    """One surface: two inverse depths apart by at most tolerance * (the smaller one + floor)."""

    tolerance: float = attrs.field(default=0.15, validator=_check_limit)
    floor: float = attrs.field(default=0.05, validator=_check_limit)  # 1/m

    def nearest_beside(self, inverse: Pixels) -> Pixels:
        """Return the largest inverse depth that belongs to one surface with each of these."""
        return inverse + np.float32(self.tolerance) * (inverse + np.float32(self.floor))

    def apart(self, one: Pixels, other: Pixels) -> NDArray[np.bool_]:
        """Return where two known depths are of different surfaces; False where one is NaN."""
        return np.maximum(one, other) > self.nearest_beside(np.minimum(one, other))
