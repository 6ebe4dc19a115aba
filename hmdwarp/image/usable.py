"""Warps, fills and effects for which a caller's own frames are enough, and warp "auto"."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from ..client import Compensator, EyeResult, PassInputs
from ..client.carry import PictureOf
from ..client.effects import effects as every_effect
from ..client.fills import fills
from ..client.plan import OTHERS, SHOWN, SHOWN_DEPTH, Plan, build_plan
from ..client.warps import warps
from ..errors import InputError, PlanError, in_brief
from ..frames.layers import PICTURE, readable
from ..gpu import Gpu
from ..gpu.textures import Canvas, Owner
from ..options import AUTO
from ..pipeline.governor import AdaptiveCompensator, Change, Governor
from ..pipeline.levels import QualityLevel, best_within, check_budget, front, levels_from, read_rows
from .picture_textures import KNOWN

# What a caller can pass: pictures with depth, and some layers.
AVAILABLE = (*PICTURE, OTHERS, *map(readable, KNOWN))


def usable_warps() -> list[str]:
    """Return the names of warps that need no more than one picture with depth."""
    return [entry.name for entry in warps if set(entry.reads) <= set(PICTURE)]


def usable_fills() -> list[str]:
    """Return the names of fills that need no more than one picture with depth."""
    return [entry.name for entry in fills if set(entry.reads) <= {*PICTURE, SHOWN, SHOWN_DEPTH}]


def usable_effects() -> list[str]:
    """Return the names of effects that need no more than pictures with depth."""
    return [effect.name for effect in every_effect if set(effect.made_by.reads) <= {*PICTURE, OTHERS}]


def plan_of(
    warp: str, fill: str, effects: str = "none", *, available: tuple[str, ...] = AVAILABLE, depth: bool = False
) -> Plan:
    """Return the plan for a caller's own frames; available: what those are.

    Errors: InputError for what is no name, and for warp "auto"; PlanError for passes that read
    more; UnknownNameError.
    """
    for kind, name, usable in (
        ("warp", warp, usable_warps),
        ("fill", fill, usable_fills),
        ("effects", effects, usable_effects),
    ):
        if not isinstance(name, str):
            raise InputError(f"{kind} is {in_brief(name)}: expected a name: {', '.join(usable())}")
    if not isinstance(depth, bool | np.bool_):
        raise InputError(f"depth is {in_brief(depth)}: expected True or False; the picture's own is depth_m")
    if warp == AUTO:
        raise InputError(
            f"warp 'auto' is for a hmdwarp.Warper or warp_image with budget_ms; name one: {', '.join(usable_warps())}"
        )
    named, taker = every_effect.selected(effects, ()), "the caller" if depth else ""
    asks: dict[str, Any] = {"brings": available, "named": named, "forced": named, "takes_depth": taker}
    try:
        return build_plan(named, warp, fill, "none", client_geometry=False, **asks)
    except PlanError as error:
        able = f"warps {', '.join(usable_warps())}; fills {', '.join(usable_fills())}"
        able += f"; effects {', '.join(usable_effects())}" if named else ""
        raise PlanError(f"{error}; a single picture has none. Usable are {able}") from error


# Printed by `hmdwarp bench look-around walk --scene room,spheres --latency 100,400
# --warp none,rotation,forward,iterative,mesh --warp mesh:grid=64 --fill none,pyramid,memory+pyramid
# --size 320x200 --samples 4 --instants 2 --rounds 1`, on llvmpipe, less the slowest one.
# The times are measured anew by each Warper.
LEVELS = (
    QualityLevel("none", "none", 1.33, 0.3120),
    QualityLevel("rotation", "none", 1.75, 0.2132),
    QualityLevel("mesh:grid=64", "none", 5.32, 0.1260),
    QualityLevel("iterative:frames=1,resample=bilinear", "pyramid", 23.4, 0.0982),
    QualityLevel("iterative:frames=1,resample=bilinear", "memory+pyramid", 43.6, 0.0827),
)
Size = tuple[int, int]
_ROUNDS = 3  # timed runs of each level on the first picture, after one that warms up
# What a call takes beside the passes that a level chooses.
_BESIDE = {"upload", "repair", "carry", "download", "wait", "host", "auto"}


def plans_of_levels(
    bench: Path | str | None, effects: str, depth: bool, budget_ms: float | None
) -> dict[QualityLevel, Plan]:
    """Return the levels, of a bench.json or LEVELS, that a caller's own frames are enough for.

    Errors: InputError for a budget that is no time, and where no level is left; as plan_of.
    """
    if budget_ms is None:
        raise InputError("warp 'auto' keeps to a budget: give budget_ms, for the warp and fill of a picture")
    check_budget(budget_ms, "budget_ms")
    found = {}
    for level in LEVELS if bench is None else levels_from(read_rows(Path(bench))):
        try:
            found[level] = plan_of(level.warp, level.fill, effects, depth=depth)
        except PlanError:
            continue
    if not found:
        raise InputError(f"{bench}: a single picture is enough for none of its levels; measure others")
    return found


class AutoCompensator(Owner):
    """Runs the level that the governor chooses; drop-in for a Compensator.

    All levels are timed on the first picture: then a budget that nothing fits is an InputError.
    """

    def __init__(
        self, gpu: Gpu, plans: Mapping[QualityLevel, Plan], rendered_size: Size, shown_size: Size, budget_ms: float
    ) -> None:
        self.budget_ms = budget_ms
        self._gpu = gpu
        sizes = rendered_size, shown_size
        self._made = {level: self.own(Compensator(gpu, plan, None, *sizes)) for level, plan in plans.items()}
        self._running: AdaptiveCompensator | None = None
        self._eyes: dict[int, float] = {}  # ms of each since the last refresh

    @property
    def plan(self) -> Plan:
        """The plan of the last picture, or of the first one as far as is known."""
        return self._running.plan if self._running else next(iter(self._made.values())).plan

    @property
    def changes(self) -> tuple[Change, ...]:
        """The switches so far."""
        return tuple(self._running.changes) if self._running else ()

    def run(self, inputs: PassInputs) -> EyeResult:
        """Run the level of the moment; see Compensator.run. Errors: InputError at first."""
        if self._running is None:
            took: dict[QualityLevel, list[float]] = {level: [] for level in self._made}  # ms here
            with self._gpu.timer.aside("auto"):
                for level in [level for level in took for _ in range(1 + _ROUNDS)]:
                    self._gpu.timer.lap()
                    self._made[level].run(inputs)
                    took[level].append(sum(ms for _, ms in self._gpu.timer.collect()))
            levels = front([level.scaled(median(ms[1:]) / level.total_ms) for level, ms in took.items()])
            best_within(levels, self.budget_ms, "budget_ms")
            made = {(level.warp, level.fill): one for level, one in self._made.items()}
            compensators = {level: made[level.warp, level.fill] for level in levels}
            self._running = AdaptiveCompensator(Governor(levels, self.budget_ms), compensators)
        elif inputs.eye in self._eyes:
            self._running.record_timings([[("", ms)] for ms in self._eyes.values()])
            self._eyes.clear()
        return self._running.run(inputs)

    def carry(self, inputs: PassInputs, picture_of: PictureOf, into: Canvas) -> None:
        """Warp further pictures as the last was; see Compensator.carry."""
        assert self._running is not None, "a picture comes first"
        self._running.carry(inputs, picture_of, into)

    def record(self, eye: int, time_ms: Mapping[str, float]) -> None:
        """Note the stage times of a picture. Eyes switch together: when one of them comes again."""
        self._eyes[eye] = sum(ms for stage, ms in time_ms.items() if stage not in _BESIDE)
