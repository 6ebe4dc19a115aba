"""hmdwarp plan: the passes that would run, each with its reason, and those left out with theirs."""

from __future__ import annotations

import typer

from . import _options as o


def plan(
    scene: o.Scene = "room",
    latency: o.Latency = 200.0,
    warp: o.Warp = "forward",
    fill: o.Fill = "interpolate",
    lens: o.Lens = None,
    headset: o.Headset = "rift-dk1",
    size: o.Size = None,
    guard: o.Guard = 1.0,
) -> None:
    """Print the passes that would run for these choices, in order and with reasons, and what the frames weigh. Starts nothing."""
    from rich.console import Console

    from ..client.plan import build_plan
    from ..headsets import load_headset
    from ..options import RunOptions, parse_size
    from ..report.tables import plan_tables
    from ..scenes import load_scene

    chosen = load_headset(headset)
    options = RunOptions(
        "", scene, latency, warp, fill, o.lens_for(lens, headset), headset, None if size is None else parse_size(size), guard=guard
    )
    built = build_plan(load_scene(scene).effects, warp, fill, options.lens, client_geometry=True)
    shown_size = options.size or chosen.eye_size_px
    late_size = chosen.fov(0).guarded(guard, shown_size)[1]
    console = Console()
    for table in plan_tables(built.steps, built.left_out):
        console.print(table)
    frame_bytes = 2 * late_size[0] * late_size[1] * built.bytes_per_pixel()
    frames = int(latency * 1e-3 * chosen.refresh_hz) + 2
    typer.echo(f"A frame: 2 eyes x {late_size[0]}x{late_size[1]} px, {', '.join(built.layers)}: {frame_bytes / 1e6:.1f} MB uncompressed.")
    typer.echo(f"The link at {latency:g} ms and {chosen.refresh_hz:g} Hz holds at most {frames} frames.")
