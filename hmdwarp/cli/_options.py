"""Options that several commands share, with their help; the names offered come from the registries' files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_PACKAGE = Path(__file__).resolve().parent.parent


def names_in(folder: str, pattern: str = "*.py") -> str:
    """The entries of a registry for a help text, from file names alone, so that --help imports nothing."""
    return ", ".join(sorted(p.stem for p in (_PACKAGE / folder).glob(pattern) if not p.stem.startswith("_")))


Scene = Annotated[str, typer.Option("--scene", help=f"{names_in('scenes/library')}, or a .glb, .obj or .ply file.")]
Latency = Annotated[float, typer.Option("--latency", help="Milliseconds from drawing a frame to showing it.")]
Warp = Annotated[str, typer.Option("--warp", help=f"{names_in('client/warps')}.")]
ChosenWarp = Annotated[
    str, typer.Option("--warp", help=f"{names_in('client/warps')}; or auto, which chooses warp and fill.")
]
ChosenFill = Annotated[
    str | None,
    typer.Option(
        "--fill",
        help=f"{names_in('client/fills')}, or several with +. [default: interpolate; auto's own]",
        show_default=False,
    ),
]
Effects = Annotated[
    str,
    typer.Option(
        "--effects",
        help=f"auto (what the scene calls for), none, or of {names_in('client/effects')}: NAME forces, no-NAME forbids.",
    ),
]
Mirrors = Annotated[
    str, typer.Option("--mirrors", help="Plane mirrors by geometry, or from what is on the screen (misses stay empty).")
]
Budget = Annotated[
    float | None,
    typer.Option("--budget", help="Milliseconds for one eye that --warp auto keeps to.", show_default=False),
]
Bench = Annotated[
    Path | None,
    typer.Option(
        "--bench", help="bench.json to choose from; by default all are tried on this run first.", show_default=False
    ),
]
Fill = Annotated[str, typer.Option("--fill", help=f"{names_in('client/fills')}.")]
Lens = Annotated[
    str | None,
    typer.Option("--lens", help=f"{names_in('client/lens')}; by default the headset's own.", show_default=False),
]
Headset = Annotated[str, typer.Option("--headset", help=f"{names_in('headsets', '*.toml')}, or a .toml file.")]
Size = Annotated[
    str | None, typer.Option("--size", help="WxH pixels of one eye; by default the headset's.", show_default=False)
]
Rate = Annotated[
    float | None, typer.Option("--rate", help="Refreshes a second; by default the headset's.", show_default=False)
]
Guard = Annotated[
    float, typer.Option("--guard", help="How many times as large (in tangents) the server draws the field of view.")
]
ChosenGuard = Annotated[
    str,
    typer.Option(
        "--guard",
        help="How many times as large (in tangents) the server draws the field of view; auto: as the trace wants.",
    ),
]
Wide = Annotated[
    bool, typer.Option("--wide", help="A second, wide and coarse view with every frame: fill wide before the others.")
]
Fused = Annotated[bool, typer.Option("--fused", help="Warp and lens in one resample; for gather warps, without fill.")]
Scanout = Annotated[
    float, typer.Option("--scanout", help="Milliseconds the display takes from its first row to its last.")
]
FollowScanout = Annotated[
    bool,
    typer.Option(
        "--follow-scanout/--no-follow-scanout", help="Warp each row for its own instant, or all for the middle one."
    ),
]
Jitter = Annotated[
    str, typer.Option("--jitter", help="Delays around the latency: uniform:MS or normal:MS (standard deviation).")
]
DelayTrace = Annotated[
    Path | None, typer.Option("--delay-trace", help="CSV of delays in ms, instead of the latency.", show_default=False)
]
Loss = Annotated[
    str, typer.Option("--loss", help="Lost frames: a share, or bursts like p=0.02,r=0.3 (Gilbert-Elliott).")
]
Bandwidth = Annotated[
    str, typer.Option("--bandwidth", help="Mbit/s of the link; with ,queue=MS the longest wait before it.")
]
LinkSeed = Annotated[int, typer.Option("--link-seed", help="Of jitter and loss.")]
Codec = Annotated[
    str, typer.Option("--codec", help=f"{names_in('link/codec/codecs')}: what frames are encoded by and decoded from.")
]
Crf = Annotated[int | None, typer.Option("--crf", help="The codec's quality, 0 (best) to 51.", show_default=False)]
Bitrate = Annotated[
    float | None,
    typer.Option("--bitrate", help="Mbit/s of one eye's colour, instead of a quality.", show_default=False),
]
Predict = Annotated[
    str, typer.Option("--predict", help="Pose the server draws for: none (now's) or constant_velocity.")
]
Horizon = Annotated[float, typer.Option("--horizon", help="Milliseconds to predict ahead at most.")]
TraceFormat = Annotated[
    str | None, typer.Option("--format", help="Trace format, instead of finding out.", show_default=False)
]
QuatOrder = Annotated[
    str | None, typer.Option("--quat-order", help="xyzw or wxyz, where a file does not say.", show_default=False)
]
Up = Annotated[
    str | None, typer.Option("--up", help="Which axis of the file points up, like y or z.", show_default=False)
]
Scale = Annotated[
    float | None, typer.Option("--scale", help="Metres per unit of the file's positions.", show_default=False)
]
TraceRate = Annotated[
    float | None, typer.Option("--trace-rate", help="Samples per second, for files without time.", show_default=False)
]
Segment = Annotated[
    int | None,
    typer.Option("--segment", help="Which recording of a file that holds several, from 1.", show_default=False),
]


def lens_for(lens: str | None, headset: str) -> str:
    """The lens asked for, or the one the headset has."""
    if lens is not None:
        return lens
    from ..headsets import load_headset

    return "radial" if load_headset(headset).lens is not None else "none"
