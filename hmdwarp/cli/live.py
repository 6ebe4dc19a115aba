"""hmdwarp live: a headset, or a window on the desktop."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from . import _options as o

Source = Annotated[
    str, typer.Option("--source", help="openxr, desktop, offscreen (nobody looks), or auto: headset, else window.")
]
Trace = Annotated[
    str, typer.Option("--trace", help="A recorded head leads the window or the offscreen display.", show_default=False)
]
Record = Annotated[
    Path | None, typer.Option("--record", help="Write the head's trace to this file while running.", show_default=False)
]
Seconds = Annotated[
    float | None, typer.Option("--seconds", help="Stop after so long; by default never.", show_default=False)
]


def live(
    source: Source = "auto",
    trace: Trace = "",
    scene: o.Scene = "room",
    latency: o.Latency = 200.0,
    warp: o.ChosenWarp = "forward",
    budget: o.Budget = None,
    bench: o.Bench = None,
    fill: o.ChosenFill = None,
    effects: o.Effects = "auto",
    mirrors: o.Mirrors = "geometry",
    lens: Annotated[
        str, typer.Option("--lens", help=f"{o.names_in('client/lens')}; auto: the window's headset's own.")
    ] = "auto",
    headset: Annotated[
        str, typer.Option("--headset", help=f"The window stands for it: {o.names_in('headsets', '*.toml')}.")
    ] = "rift-dk1",
    size: Annotated[
        str | None, typer.Option("--size", help="WxH pixels of one eye; by default what the display likes.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option("--rate", help="Refreshes a second, where the display does not say.")
    ] = None,
    guard: o.ChosenGuard = "1",
    wide: o.Wide = False,
    fused: o.Fused = False,
    view: Annotated[str, typer.Option("--view", help="In the window: both eyes, or one flat view.")] = "both",
    full_screen: Annotated[bool, typer.Option("--full-screen", help="The window fills the screen.")] = False,
    vsync: Annotated[bool, typer.Option("--vsync/--no-vsync", help="Wait for the screen's refresh.")] = True,
    panel: Annotated[
        bool, typer.Option("--panel/--no-panel", help="Controls and plots (pip install 'hmdwarp[panel]').")
    ] = True,
    depth_layer: Annotated[
        bool, typer.Option("--depth-layer/--no-depth-layer", help="Hand the warped depth over to the runtime.")
    ] = True,
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
    seconds: Seconds = None,
    frames: Annotated[
        int | None, typer.Option("--frames", help="Stop after so many pictures.", show_default=False)
    ] = None,
    record: Record = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", help="Folder for frames.csv, summary.json and report.html; by default none.", show_default=False
        ),
    ] = None,
    images_every: Annotated[
        int, typer.Option("--images-every", help="With --out: keep every n-th picture as it was handed over.")
    ] = 0,
    reconnect: Annotated[
        float, typer.Option("--reconnect", help="Seconds to wait for a runtime that went away.")
    ] = 60.0,
    hang: Annotated[float, typer.Option("--hang", help="Seconds after which a silent runtime is given up.")] = 5.0,
    gc_between: Annotated[
        bool, typer.Option("--gc-between/--gc-anywhere", help="When Python may look for garbage.")
    ] = True,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Show late frames live, each warped to the newest pose: in the headset, or in a window (h shows its keys)."""
    from ..run.live.given import options_given

    options = options_given(
        source=source,
        trace=trace,
        scene=scene,
        latency=latency,
        warp=warp,
        budget=budget,
        bench=bench,
        fill=fill,
        effects=effects,
        mirrors=mirrors,
        lens=lens,
        headset=headset,
        size=size,
        rate=rate,
        guard=guard,
        wide=wide,
        fused=fused,
        view=view,
        full_screen=full_screen,
        vsync=vsync,
        panel=panel,
        depth_layer=depth_layer,
        jitter=jitter,
        delay_trace=delay_trace,
        loss=loss,
        bandwidth=bandwidth,
        link_seed=link_seed,
        codec=codec,
        crf=crf,
        bitrate=bitrate,
        predict=predict,
        horizon=horizon,
        seconds=seconds,
        frames=frames,
        record=record,
        out=out,
        images_every=images_every,
        reconnect=reconnect,
        hang=hang,
        gc_between=gc_between,
        command=shlex.join(["hmdwarp", *sys.argv[1:]]),
    )
    run(options, quiet)


def run(options, quiet: bool) -> None:
    """Run it and tell what came out."""
    from ..run.live.run import live as go

    result = go(options, (lambda text: None) if quiet else lambda text: typer.echo(text, err=True))
    if not quiet:
        for line in result.told():
            typer.echo(line)
