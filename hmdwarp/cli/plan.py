"""hmdwarp plan: the passes that would run, each with its reason, and those left out with theirs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from . import _options as o

if TYPE_CHECKING:
    from ..client.plan import Step


def plan(
    scene: o.Scene = "room",
    latency: o.Latency = 200.0,
    warp: o.Warp = "forward",
    fill: o.Fill = "interpolate",
    lens: o.Lens = None,
    headset: o.Headset = "rift-dk1",
    size: o.Size = None,
    rate: o.Rate = None,
    guard: o.Guard = 1.0,
) -> None:
    """Print the passes that would run for these choices, in order and with reasons, and what the frames weigh. Starts nothing."""
    from ..headsets import load_headset
    from ..options import RunOptions, parse_size
    from ..rig import build_plan_for, cube_bytes, frames_held, guarded_size
    from ..scenes import load_scene
    from ._show import in_columns

    chosen = load_headset(headset)
    wanted_size = None if size is None else parse_size(size)
    options = RunOptions("", scene, latency, warp, fill, o.lens_for(lens, headset), headset, size=wanted_size, rate_hz=rate, guard=guard)
    built = build_plan_for(options, chosen, load_scene(scene))
    shown_size = options.size or chosen.eye_size_px
    late_size = guarded_size(guard, chosen, shown_size)
    typer.echo("Passes, in order:")
    in_columns(((step.name, _told(step)) for step in built.steps), indent=2)
    typer.echo("Left out; nothing is compiled or allocated for them:")
    in_columns(built.left_out, indent=2)
    rate_hz = rate or chosen.refresh_hz
    frame_bytes = 2 * (late_size[0] * late_size[1] * built.bytes_per_pixel() + cube_bytes(chosen, shown_size, built.needs))
    in_columns(
        [
            ("A frame", f"2 eyes x {late_size[0]}x{late_size[1]} px of {', '.join(built.layers)}: {frame_bytes / 1e6:.1f} MB uncompressed"),
            ("The link", f"holds at most {frames_held(options, rate_hz, built.needs)} of them at {latency:g} ms and {rate_hz:g} Hz"),
        ]
    )


def _told(step: Step) -> str:
    reads = f"reads {', '.join(step.reads)}; " if step.reads else ""
    return f"{step.reason}\n{reads}writes {', '.join(step.writes)}"
