"""What a bench is asked to do, checked before anything is started."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from ..pipeline.options import number
from ..poses.options import TraceOptions

Size = tuple[int, int]

# Six instants spread over a recording and both eyes by turns: FLIP and SSIM of a 1280x800 picture
# take 0.6 s, and fifteen warps with two fills on two recordings make sixty pictures an instant. Two
# rounds for both eyes at each make 24 times per combination.
INSTANTS = 6
ROUNDS = 2


def _several(what: str, key: Callable[[Any], Any] = lambda value: value) -> Callable[[Iterable[Any]], tuple[Any, ...]]:
    """A converter to a tuple without repetitions; a text alone is one value. Errors: InputError where nothing is left."""

    def convert(values: Iterable[Any]) -> tuple[Any, ...]:
        found = tuple({key(value): value for value in ((values,) if isinstance(values, str) else values)}.values())
        if not found:
            raise InputError(f"a bench without any {what}: wanted one at least")
        return found

    return convert


def _names(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((names,) if isinstance(names, str) else names))


def _size(value: Any) -> Size:
    """Errors: InputError."""
    sides = tuple(value)
    if len(sides) != 2 or not all(isinstance(side, int) and side >= 1 for side in sides):
        raise InputError(f"size {value!r}: wanted (width, height) in pixels of one eye")
    return sides


@attrs.frozen
class BenchOptions:
    """Every combination of warps x fills x latencies x scenes x recordings x sizes is run.

    warps: names, with settings if wanted (`mesh:cut=slope`); empty for all and their variants.
    sizes: (w, h) of one eye.
    effects: as a run's, for every scene.
    trace_options: how every recording is read. start_s, seconds: the part of each recording, None
    for all of it. instants: how many refreshes of it are measured, evenly spread. rounds: how often
    each combination is timed at each, after a run to warm up. workers: measuring processes, None
    for one per core. grid, fused: whether the displacement grid and the warps that look through the
    lens themselves are measured too. budget_ms: a time per eye to choose the most accurate
    combination for.
    Errors: InputError for a number that cannot be meant, and for an empty list.
    """

    warps: tuple[str, ...] = attrs.field(default=(), converter=_names)
    fills: tuple[str, ...] = attrs.field(default=("none", "interpolate"), converter=_several("fill"))
    latencies_ms: tuple[float, ...] = attrs.field(
        default=(200.0,), converter=_several("latency"), validator=number("latency", " ms")
    )
    scenes: tuple[str, ...] = attrs.field(default=("room",), converter=_several("scene"))
    recordings: tuple[str, ...] = attrs.field(default=("look-around", "walk"), converter=_several("recording"))
    sizes: tuple[Size, ...] = attrs.field(default=((1280, 800),), converter=_several("size", _size))
    trace_options: TraceOptions = attrs.field(factory=TraceOptions)
    effects: str = "auto"
    lens: str = "none"
    headset: str = "rift-dk1"
    guard: float = attrs.field(default=1.5, validator=number("guard", least=1.0))
    rate_hz: float | None = attrs.field(default=None, validator=number("rate", " Hz", above=True, most=1000))
    start_s: float = attrs.field(default=0.0, validator=number("start", " s"))
    seconds: float | None = attrs.field(default=None, validator=number("seconds", " s", above=True))
    instants: int = attrs.field(default=INSTANTS, validator=number("instants", least=1))
    rounds: int = attrs.field(default=ROUNDS, validator=number("rounds", least=1))
    workers: int | None = attrs.field(default=None, validator=number("workers", most=256))
    fused: bool = True
    grid: bool = True
    budget_ms: float | None = attrs.field(default=None, validator=number("budget", " ms", above=True))
    out: Path = attrs.field(default=Path("out/bench"), converter=Path)
    command: str = ""
