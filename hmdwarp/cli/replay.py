"""hmdwarp replay: a recorded head trace through the whole pipeline."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from . import _options as o


def replay(
    trace: Annotated[
        str, typer.Argument(help="A head trace file, or the name of a recording that comes along, like look-around.")
    ],
    scene: o.Scene = "room",
    latency: o.Latency = 200.0,
    warp: o.ChosenWarp = "forward",
    budget: o.Budget = None,
    bench: o.Bench = None,
    fill: o.ChosenFill = None,
    effects: o.Effects = "auto",
    mirrors: o.Mirrors = "geometry",
    lens: o.Lens = None,
    headset: o.Headset = "rift-dk1",
    size: o.Size = None,
    rate: o.Rate = None,
    start: Annotated[float, typer.Option("--start", help="Seconds into the trace to show first.")] = 0.0,
    seconds: Annotated[
        float | None, typer.Option("--seconds", help="Seconds to show; by default all.", show_default=False)
    ] = None,
    guard: o.ChosenGuard = "1",
    wide: o.Wide = False,
    fused: o.Fused = False,
    scanout: o.Scanout = 0.0,
    follow_scanout: o.FollowScanout = True,
    jitter: o.Jitter = "",
    delay_trace: o.DelayTrace = None,
    loss: o.Loss = "",
    bandwidth: o.Bandwidth = "",
    link_seed: o.LinkSeed = 0,
    codec: o.Codec = "none",
    crf: o.Crf = None,
    bitrate: o.Bitrate = None,
    predict: o.Predict = "none",
    horizon: o.Horizon = 100.0,
    out: Annotated[
        Path, typer.Option("--out", help="Folder for summary.json, frames.csv, images/ and report.html.")
    ] = Path("out/replay"),
    against: Annotated[str, typer.Option("--against", help="The warp to compare with; '' for none.")] = "none",
    metrics_every: Annotated[int, typer.Option("--metrics-every", help="Measure every n-th refresh.")] = 10,
    workers: Annotated[
        int | None,
        typer.Option(
            help="Measuring processes; 0 measures in the loop. Default: one per core, at most 8.", show_default=False
        ),
    ] = None,
    images: Annotated[int, typer.Option("--images", help="About how many refreshes to keep as pictures.")] = 6,
    video: Annotated[
        bool, typer.Option("--video", help="Also write replay.mp4: both panels, as the display gets them.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
    trace_format: o.TraceFormat = None,
    quat_order: o.QuatOrder = None,
    up: o.Up = None,
    scale: o.Scale = None,
    trace_rate: o.TraceRate = None,
    segment: o.Segment = None,
) -> None:
    """Replay a head trace with late frames, warp each to the newest pose, and measure it against no latency at all."""
    from ..link import LinkOptions
    from ..link.codec import Coding
    from ..pipeline.options import RunOptions, fill_for, parse_guard, parse_size
    from ..poses.options import TraceOptions

    options = RunOptions(
        trace=trace,
        scene=scene,
        latency_ms=latency,
        warp=warp,
        fill=fill_for(warp, fill, fused, wide),
        effects=effects,
        mirrors=mirrors,
        network=LinkOptions.parse(
            jitter=jitter, delay_trace=delay_trace, loss=loss, bandwidth=bandwidth, seed=link_seed
        ),
        coding=Coding(codec, crf, bitrate),
        budget_ms=budget,
        bench=bench,
        lens=o.lens_for(lens, headset),
        headset=headset,
        size=None if size is None else parse_size(size),
        rate_hz=rate,
        start_s=start,
        seconds=seconds,
        guard=parse_guard(guard),
        fused=fused,
        scanout_ms=scanout,
        follow_scanout=follow_scanout,
        predict=predict,
        horizon_ms=horizon,
        against=against,
        metrics_every=metrics_every,
        workers=workers,
        images=images,
        video=video,
        trace_options=TraceOptions(trace_format, quat_order, up, scale, trace_rate, segment),
        out=out,
        command=shlex.join(["hmdwarp", *sys.argv[1:]]),
    )
    _run(options, quiet)


def _run(options, quiet: bool) -> None:
    from ..report import summary_table, transit_lines
    from ..run.replay import replay as run
    from ._show import console, steps

    with steps("refreshes", quiet=quiet) as (progress, screen):
        result = run(options, progress, *([] if quiet else [screen.print]))
    if quiet:
        return
    console().print(summary_table(result.summary, result.against))
    for line in transit_lines(result.summary):
        typer.echo(line)
    for note in result.summary["notes"]:
        typer.echo(f"note: {note}")
    typer.echo(f"report: {result.report}")
