"""What a run is asked to do, checked before anything is started."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Literal, Self

import attrs

from ..errors import InputError
from ..link import LinkOptions
from ..link.codec import Coding
from ..poses.options import TraceOptions

AUTO = "auto"  # the warp that chooses among the others, and the guard band that fits the trace


def parse_size(text: str) -> tuple[int, int]:
    """'640x400' to (640, 400). Errors: InputError."""
    match = re.fullmatch(r"(\d{1,6})\s*[xX]\s*(\d{1,6})", text.strip())
    if not match or 0 in map(int, match.groups()):
        raise InputError(f"size '{text}': wanted WIDTHxHEIGHT in pixels of one eye, like 640x800")
    return int(match.group(1)), int(match.group(2))


def fill_for(warp: str, fill: str | None, fused: bool = False, wide: bool = False) -> str:
    """The fill asked for, or the usual one, which is none for a warp fused with the lens; with a wide view that one before it.

    Errors: InputError for one beside warp auto, which chooses its own.
    """
    if warp == AUTO and (fill is not None or wide):
        asked = "--wide" if fill is None else f"--fill {fill}"
        raise InputError(f"{asked}: warp auto chooses the fill too; leave one of the two out")
    usual = "none" if fused else "interpolate"
    asked = usual if fill is None else fill
    if not wide:
        return asked
    return "wide" if asked == "none" else f"wide+{asked}"


def _as_float(value: float) -> float:
    """Infinite for a whole number that is too large."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def number(name: str, unit: str = "", *, least: float = 0.0, above: bool = False, most: float = math.inf):
    """A validator for attrs: the value, or each of a tuple, is finite and within the limits, or None. Errors: InputError."""
    wanted = f"{'above' if above else 'of at least'} {least:g}{unit}" + (
        f" and at most {most:g}{unit}" if math.isfinite(most) else ""
    )

    def check(_: object, __: attrs.Attribute, value: float | tuple[float, ...] | None) -> None:
        for one in value if isinstance(value, tuple) else (value,):
            if one is None:
                continue
            found = _as_float(one)
            if not (math.isfinite(found) and found <= most and (found > least if above else found >= least)):
                raise InputError(f"{name} {found:g}{unit}: wanted a number {wanted}")

    return check


def _guard(instance: object, attribute: attrs.Attribute, value: float | str) -> None:
    if value != AUTO:
        number("guard", least=1.0)(instance, attribute, value)


def parse_guard(text: str) -> float | Literal["auto"]:
    """'auto' or a number. Errors: InputError."""
    if text.strip() == AUTO:
        return AUTO
    try:
        return float(text)
    except ValueError as error:
        raise InputError(f"guard '{text}': wanted a number of at least 1, or {AUTO}") from error


@attrs.frozen
class PipelineOptions:
    """What a picture goes through from the server to the eye: the same names and defaults as the command line's.

    network: what lies between, beside the latency. coding: whether frames are encoded and decoded on the way. effects: as
    client.effects.EffectRegistry.selected has it, "auto" for what the scene calls for, else what is forced or forbidden. mirrors:
    "geometry" or "screen", how the server draws plane mirrors (server.Server).
    latency_ms: from drawing to showing. size: (w, h) of one eye, None for the headset's. rate_hz: display refresh, None for the
    headset's. guard: how much larger in tangents the server draws; "auto" for what the trace calls for (border.settled, which replay
    does first). predict, horizon_ms: what pose the server is asked for.
    fused: warp and lens in one resample. scanout_ms: from the first row of the display to its last, 0 for a display that lights up at
    once. follow_scanout: whether warps that can give every row a view of its own do so; others show all as in the middle of the scan-out.
    budget_ms: per eye, for warp "auto" alone, which takes the most accurate warp and fill within it and keeps to it (`fill` does not
    count then). bench: the bench.json it knows them from, None to try all on the run's own frames first.
    Errors: InputError for a number that cannot be meant.
    """

    scene: str = "room"
    latency_ms: float = attrs.field(default=200.0, validator=number("latency", " ms"))
    warp: str = "forward"
    fill: str = "interpolate"
    network: LinkOptions = attrs.field(factory=LinkOptions)
    coding: Coding = attrs.field(factory=Coding)
    effects: str = "auto"
    mirrors: str = "geometry"
    lens: str = "radial"
    headset: str = "rift-dk1"
    size: tuple[int, int] | None = None
    rate_hz: float | None = attrs.field(default=None, validator=number("rate", " Hz", above=True, most=1000))
    guard: float | Literal["auto"] = attrs.field(default=1.0, validator=_guard)
    predict: str = "none"
    horizon_ms: float = attrs.field(default=100.0, validator=number("horizon", " ms"))
    fused: bool = False
    budget_ms: float | None = attrs.field(default=None, validator=number("budget", " ms", above=True))
    bench: Path | None = attrs.field(default=None, converter=attrs.converters.optional(Path))
    scanout_ms: float = attrs.field(default=0.0, validator=number("scanout", " ms", most=100))
    follow_scanout: bool = True

    def __attrs_post_init__(self) -> None:
        if self.warp == AUTO:
            self._check_auto()
        elif self.budget_ms is not None:
            raise InputError(
                f"budget {self.budget_ms:g} ms: only warp 'auto' keeps to a budget; warp '{self.warp}' takes what it takes"
            )
        elif self.bench is not None:
            raise InputError(
                f"bench {self.bench}: only warp 'auto' chooses from a benchmark; warp '{self.warp}' is chosen already"
            )

    def with_pair(self, warp: str, fill: str) -> Self:
        """The same with this warp and fill, instead of a choice of its own."""
        return attrs.evolve(self, warp=warp, fill=fill, budget_ms=None, bench=None)

    def _check_auto(self) -> None:
        if self.budget_ms is None:
            raise InputError(
                "warp 'auto' chooses what fits into a budget: say how many milliseconds there are for one eye (--budget MS)"
            )
        if self.fused:
            raise InputError(
                "fused with warp 'auto': its warps must have the picture between warp and lens, to be measured; leave one out"
            )


@attrs.frozen(kw_only=True)
class RunOptions(PipelineOptions):
    """A replay: which trace, and what is measured and kept of it.

    start_s, seconds: the shown part of the trace, None for all of it. as_recorded: the head is where the trace has it, at the instants of
    the trace's own clock, so that what moves in the scene is where it was then; else time begins at 0, and a trace that leaves the scene
    is moved into it. against: the warp compared with, "" for none. metrics_every:
    pictures are measured at every n-th refresh. workers: measuring processes, None for one per core.
    Errors: InputError for a number that cannot be meant.
    """

    trace: str
    start_s: float = attrs.field(default=0.0, validator=number("start", " s"))
    seconds: float | None = attrs.field(default=None, validator=number("seconds", " s", above=True))
    as_recorded: bool = False
    against: str = "none"
    metrics_every: int = attrs.field(default=10, validator=number("metrics-every", least=1))
    workers: int | None = attrs.field(default=None, validator=number("workers", most=256))
    images: int = attrs.field(default=6, validator=number("images"))
    video: bool = False
    trace_options: TraceOptions = attrs.field(factory=TraceOptions)
    out: Path = attrs.field(default=Path("out/replay"), converter=Path)
    command: str = ""
