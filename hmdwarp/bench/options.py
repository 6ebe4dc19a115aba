"""Options of a bench, checked before anything is started."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from ..options import Declared, Number, Option, force_field, group, names_in, option, out_field, same_as
from ..pipeline.options import parse_size
from ..poses.options import TraceOptions
from ..run.options import RunOptions

Size = tuple[int, int]

_REPEAT = "For several, repeat it, or put commas between."
_RUN = attrs.fields(RunOptions)


def _several(what: str, key: Callable[[Any], Any] = lambda value: value) -> Callable[[Iterable[Any]], tuple[Any, ...]]:
    """Return a converter to a tuple without repetitions; a text alone is one value.

    Errors: InputError where nothing is left.
    """

    def convert(values: Iterable[Any]) -> tuple[Any, ...]:
        found = tuple({key(value): value for value in ((values,) if isinstance(values, str) else values)}.values())
        if not found:
            raise InputError(f"a bench without any {what}: expected at least one")
        return found

    return convert


def _unique(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((names,) if isinstance(names, str) else names))


def _size(value: Any) -> Size:
    sides = tuple(value)
    if len(sides) != 2 or not all(isinstance(side, int) and side >= 1 for side in sides):
        raise InputError(f"size {value!r}: expected (width, height) in pixels of one eye")
    return sides


def _split(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _names(texts: list[str]) -> list[str]:
    """Return every text that has settings (these hold commas), or its parts between commas."""
    return [name for text in texts for name in ([text] if ":" in text else _split(text))]


def _listed(texts: list[str]) -> list[str]:
    """Return every text, or its parts between commas unless it names a file."""
    return [part for text in texts for part in ([text] if Path(text).exists() else _split(text))]


def _milliseconds(text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise InputError(f"latency '{text}': expected milliseconds, like 200") from error


_RECORDING = Option("As an argument; repeat it for several.", list, name="recording", metavar="TRACE")


@attrs.frozen
class BenchOptions(Declared):
    """Options of a bench: it runs all combinations of warps, fills, latencies, scenes and so on.

    Errors: InputError for a number that makes no sense, and for an empty list.
    """

    recordings: tuple[str, ...] = option(
        ("look-around", "walk"),
        "Traces, as for replay; by default look-around and walk.",
        name="traces",
        kind=list,
        default=None,
        metavar="[TRACE]...",
        positional=True,
        beside=(_RECORDING,),
        convert=_several("recording"),
    )
    scenes: tuple[str, ...] = option(
        ("room",),
        f"Scenes: {names_in('scenes/library')}, files; by default room. {_REPEAT}",
        name="scene",
        kind=list,
        default=None,
        metavar="NAME|FILE",
        parse=_listed,
        convert=_several("scene"),
    )
    latencies_ms: tuple[float, ...] = option(
        (_RUN.latency_ms.default,),
        f"From drawing a frame to showing it; by default {_RUN.latency_ms.default:g}. {_REPEAT}",
        name="latency",
        kind=list,
        default=None,
        unit="ms",
        metavar="MS",
        parse=lambda texts: [_milliseconds(text) for text in _listed(texts)],
        convert=_several("latency"),
        valid=Number(),
    )
    # Names, with settings where they matter (`mesh:cut=slope`); empty for all and their variants.
    warps: tuple[str, ...] = option(
        (),
        f"Warps: {names_in('client/warps')}; by default all. For several, repeat it; settings follow a colon, "
        "as in mesh:cut=slope.",
        name="warp",
        kind=list,
        default=None,
        metavar="NAME",
        parse=_names,
        convert=_unique,
    )
    fills: tuple[str, ...] = option(
        ("none", "interpolate"),
        f"Fills: {names_in('client/fills')}; by default none and interpolate. {_REPEAT}",
        name="fill",
        kind=list,
        default=None,
        metavar="NAME",
        parse=_names,
        convert=_several("fill"),
    )
    effects: str = same_as(_RUN.effects)
    sizes: tuple[Size, ...] = option(
        ((1280, 800),),
        f"Pixels of one eye; by default 1280x800. {_REPEAT}",
        name="size",
        kind=list,
        default=None,
        metavar="WxH",
        parse=lambda texts: [parse_size(text) for text in _listed(texts)],
        convert=_several("size", _size),
    )
    lens: str = option("none", "Lens correction, timed too; figures are of the picture before it.")
    headset: str = same_as(_RUN.headset)
    rate_hz: float | None = same_as(_RUN.rate_hz)
    start_s: float = same_as(_RUN.start_s)
    seconds: float | None = same_as(_RUN.seconds)
    guard: float = option(
        1.5, "Draw this many times the field of view (in tangents) on the server.", valid=Number(least=1.0)
    )
    # Six instants spread over a recording and both eyes by turns: FLIP and SSIM of a 1280x800
    # picture take 0.6 s, and fifteen warps with two fills on two recordings make sixty pictures an
    # instant. Two rounds for both eyes at each make 24 times per combination.
    instants: int = option(6, "Refreshes measured in each case, evenly spread.", valid=Number(least=1))
    rounds: int = option(2, "Timed runs at each instant, after one to warm up.", valid=Number(least=1))
    # Chooses the most accurate combination within it.
    budget_ms: float | None = option(
        None,
        "Milliseconds for one eye: name the most accurate combination within them.",
        kind=float,
        unit="ms",
        valid=Number(above=True),
    )
    grid: bool = option(True, "Sweep head displacements in the first scene.", off="--no-grid")
    fused: bool = option(True, "Compare warps that look through the lens themselves.", off="--no-fused")
    workers: int | None = same_as(_RUN.workers)
    trace_options: TraceOptions = group(TraceOptions)
    out: Path = out_field(Path("out/bench"), "Folder for bench.csv, bench.json and bench.html.")
    force: bool = force_field()
    command: str = ""

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that something was said about. Errors: InputError."""
        recordings = [*(said.get("traces") or ()), *(said.get("recording") or ())]
        return super().values_of({**said, "traces": recordings or None})
