"""hmdwarp bench: what accuracy costs in time."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from . import _options as o

_REPEAT = "For several, repeat it, or put commas between."
_SETTINGS = "For several, repeat it; settings follow a colon, as in mesh:cut=slope."
_Texts = list[str] | None


def _several(name: str, metavar: str, what: str):
    return typer.Option(name, metavar=metavar, help=what, show_default=False)


def bench(
    traces: Annotated[
        _Texts, typer.Argument(metavar="[TRACE]...", help="As for replay; by default look-around and walk.")
    ] = None,
    recording: Annotated[_Texts, _several("--recording", "TRACE", "As an argument; repeat it for several.")] = None,
    scene: Annotated[
        _Texts, _several("--scene", "NAME|FILE", f"{o.names_in('scenes/library')}, files; default: room. {_REPEAT}")
    ] = None,
    latency: Annotated[
        _Texts, _several("--latency", "MS", f"From drawing a frame to showing it; default: 200. {_REPEAT}")
    ] = None,
    warp: Annotated[
        _Texts, _several("--warp", "NAME", f"{o.names_in('client/warps')}; default: all. {_SETTINGS}")
    ] = None,
    fill: Annotated[
        _Texts, _several("--fill", "NAME", f"{o.names_in('client/fills')}; default: none and interpolate. {_REPEAT}")
    ] = None,
    effects: o.Effects = "auto",
    size: Annotated[_Texts, _several("--size", "WxH", f"Pixels of one eye; default: 1280x800. {_REPEAT}")] = None,
    lens: Annotated[
        str, typer.Option("--lens", help="Times the lens too; figures are of the picture before it.")
    ] = "none",
    headset: o.Headset = "rift-dk1",
    rate: o.Rate = None,
    start: Annotated[float, typer.Option("--start", help="Seconds into each trace to begin at.")] = 0.0,
    seconds: Annotated[
        float | None, typer.Option("--seconds", help="Seconds of each trace; by default all.", show_default=False)
    ] = None,
    guard: o.Guard = 1.5,
    instants: Annotated[
        int | None, typer.Option("--instants", help="Refreshes measured in a case; by default 6.", show_default=False)
    ] = None,
    rounds: Annotated[
        int | None, typer.Option("--rounds", help="Timed runs at each of them; by default 2.", show_default=False)
    ] = None,
    budget: Annotated[
        float | None,
        typer.Option(
            "--budget", help="Milliseconds for one eye: says what is most accurate within them.", show_default=False
        ),
    ] = None,
    grid: Annotated[bool, typer.Option("--grid/--no-grid", help="Sweep head displacements in the first scene.")] = True,
    fused: Annotated[
        bool, typer.Option("--fused/--no-fused", help="Compare warps that look through the lens themselves.")
    ] = True,
    workers: Annotated[
        int | None,
        typer.Option(
            help="Measuring processes; 0 measures in the loop. Default: one per core, at most 8.", show_default=False
        ),
    ] = None,
    trace_format: o.TraceFormat = None,
    quat_order: o.QuatOrder = None,
    up: o.Up = None,
    scale: o.Scale = None,
    trace_rate: o.TraceRate = None,
    segment: o.Segment = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for bench.csv, bench.json and bench.html.")] = Path(
        "out/bench"
    ),
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Run every combination of warps, fills, latencies, scenes, traces and sizes on the same late frames: error against time."""
    from ..bench import BenchOptions
    from ..poses.options import TraceOptions

    asked = {
        "warps": _names(warp),
        "fills": _names(fill),
        "latencies_ms": None if latency is None else [_milliseconds(text) for text in _listed(latency)],
        "scenes": _listed(scene),
        "recordings": [*(traces or []), *(recording or [])] or None,
        "sizes": None if size is None else [_size(text) for text in _listed(size)],
        "instants": instants,
        "rounds": rounds,
    }
    options = BenchOptions(
        **{name: value for name, value in asked.items() if value is not None},
        trace_options=TraceOptions(trace_format, quat_order, up, scale, trace_rate, segment),
        effects=effects,
        lens=lens,
        headset=headset,
        guard=guard,
        rate_hz=rate,
        start_s=start,
        seconds=seconds,
        workers=workers,
        fused=fused,
        grid=grid,
        budget_ms=budget,
        out=out,
        command=shlex.join(["hmdwarp", *sys.argv[1:]]),
    )
    _run(options, quiet)


def _names(texts: _Texts) -> _Texts:
    """Every text that has settings, which have commas of their own, or its parts between commas."""
    return None if texts is None else [name for text in texts for name in ([text] if ":" in text else _split(text))]


def _split(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _listed(texts: _Texts) -> _Texts:
    """Every text, or its parts between commas where it is no file that has one in its name."""
    return (
        None
        if texts is None
        else [part for text in texts for part in ([text] if Path(text).exists() else _split(text))]
    )


def _milliseconds(text: str) -> float:
    from ..errors import InputError

    try:
        return float(text)
    except ValueError as error:
        raise InputError(f"latency '{text}': wanted milliseconds, like 200") from error


def _size(text: str) -> tuple[int, int]:
    from ..pipeline.options import parse_size

    return parse_size(text)


def _run(options, quiet: bool) -> None:
    from ..bench import bench as run
    from ..errors import InputError
    from ._show import steps

    with steps("instants", quiet=quiet) as (progress, _):
        result = run(options, progress)
    if not quiet:
        _tell(result)
    if result.refused:  # after the results are written and told: they are good, the budget was not
        raise InputError(result.refused)


def _tell(result) -> None:
    from ..bench.answer import answer
    from ..report.bench import bench_table
    from ._show import console, paragraph

    screen = console()
    screen.print(bench_table(result.data["rows"], width=screen.width))
    paragraph(f"Clock: {result.data['clocks']['note']}. Copying moves {result.data['copy_gb_s']:.1f} GB/s.")
    for note in dict.fromkeys(note for row in result.data["rows"] for note in row["notes"]):
        paragraph(f"note: {note}")
    for sentence in answer(result.data["choice"]) if result.data["choice"] else ():
        paragraph(sentence)
    typer.echo(f"report: {result.report}")
