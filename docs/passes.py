"""Tables of docs/results-*.md on effects, fills and the link. Each row is one replay."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Any

Summary = dict[str, Any]
Run = Callable[..., Summary]  # (trace, *options) -> summary.json

LATENCIES = ("200", "400", "600", "800")
COMMON = shlex.split("--guard 1.5 --lens none")
SHORT = [*COMMON, *shlex.split("--rate 30 --start 1 --seconds 1.2 --metrics-every 9")]
SMALL = [
    *COMMON,
    *shlex.split("--size 240x300 --rate 20 --start 1 --seconds 0.8 --metrics-every 4"),
]  # slow
LONG = [
    *COMMON,
    *shlex.split("--rate 20 --start 2 --seconds 6 --metrics-every 15"),
]  # long enough for the head to return
FILLS = (
    "none",
    "interpolate",
    "interpolate_full",
    "stretch+pyramid",
    "pyramid",
    "wide+pyramid",
    "memory+pyramid",
    "model",
    "interpolate+composite",
    "relight",
    "memory+relight",
    "interpolate+memory+pyramid",
)
SLOW_FILLS = ("interpolate", "pyramid", "model", "relight")  # after `mesh`, which takes a quarter of a second an eye
FILL_FIGURES = (
    "PSNR in former holes",
    "FLIP in former holes",
    "PSNR dB",
    "FLIP",
    "flicker",
    "fill ms an eye",
    "left empty %",
)
LINK_FIGURES = (
    "Mbit/s",
    "coded PSNR",
    "encode ms",
    "decode ms",
    "frames shown / lost / late",
    "response ms",
    "PSNR dB",
    "FLIP",
)
NETWORKS = (
    ("constant", ()),
    ("uniform jitter of 30 ms", ("--jitter", "uniform:30")),
    ("10 % lost in bursts of three", ("--loss", "p=0.037,r=0.33", "--link-seed", "1")),
    ("60 Mbit/s", ("--bandwidth", "60")),
)
CODECS = ("none", "h264", "hevc")


def _line(*cells: object) -> str:
    return "| " + " | ".join(map(str, cells)) + " |"


def _head(*cells: str) -> list[str]:
    return [_line(*cells), "|" + " --- |" * len(cells)]


def _quality(summary: Summary, name: str) -> float:
    return summary["quality"][name]["mean"]


def effects_table(run: Run, scenes: list[tuple[str, list[str]]]) -> str:
    """Return the error of each scene with and without each pass, and what the pass costs.

    scenes: (name, names of the effects it calls for). Without a pass the server draws the content
    into the picture.
    """
    rows = _head("scene", "ms late", "left out", "PSNR dB", "FLIP", "flicker", "effects ms an eye", "MB a frame")
    for scene, effects in scenes:
        for latency in LATENCIES:
            for left_out in ("", *effects, *(("all",) if len(effects) > 1 else ())):
                option = {"": "auto", "all": "none"}.get(left_out, f"no-{left_out}")
                choices = f"--scene {scene} --latency {latency} --effects {option} --warp iterative --fill pyramid"
                summary = run("walk", *SMALL, *shlex.split(choices))
                name = f"`{left_out}`" if left_out else "nothing"
                rows.append(_line(f"`{scene}`", latency, name, *_effect_figures(summary)))
    return "\n".join(rows)


def _effect_figures(summary: Summary) -> list[str]:
    quality = [f"{_quality(summary, 'psnr_db'):.2f}", *(f"{_quality(summary, key):.3f}" for key in ("flip", "flicker"))]
    ms, size = summary["time_ms"]["effects"]["median"], summary["link"]["frame_bytes"] / 1e6
    return [*quality, f"{ms:.1f}", f"{size:.1f}"]


def fills_table(run: Run) -> str:
    """Return every fill at 400 ms, after `forward`; SLOW_FILLS after `mesh` too."""
    rows = _head("recording", "warp", "fill", *FILL_FIGURES)
    for trace in ("look-around", "walk"):
        for warp, fills in (("forward", FILLS), ("mesh", SLOW_FILLS)):
            for fill in fills:
                summary = run(trace, *LONG, "--latency", "400", "--warp", warp, "--fill", fill)
                rows.append(_line(trace, f"`{warp}`", f"`{fill}`", *_fill_figures(summary)))
    return "\n".join(rows)


def memory_table(run: Run) -> str:
    """Return the memory fill on a head that comes back, without and with a guard band."""
    rows = _head("guard", "fill", *FILL_FIGURES)
    for guard in ("1", "1.5"):
        for fill in ("pyramid", "memory+pyramid"):
            summary = run("look-around", *LONG, "--latency", "400", "--fill", fill, "--guard", guard)
            rows.append(_line(guard, f"`{fill}`", *_fill_figures(summary)))
    return "\n".join(rows)


def _fill_figures(summary: Summary) -> list[str]:
    holes, filled = summary["regions"]["holes"], summary["filled"]
    empty = filled["empty"] if len(filled) > 1 else holes["share"]
    return [
        f"{holes['psnr_db']:.2f}",
        f"{holes['flip']:.3f}",
        f"{_quality(summary, 'psnr_db'):.2f}",
        f"{_quality(summary, 'flip'):.3f}",
        f"{_quality(summary, 'flicker'):.3f}",
        f"{summary['time_ms']['fill']['median']:.1f}",
        f"{100 * empty:.2f}",
    ]


def link_table(run: Run) -> str:
    """Return networks and codecs: what became of the frames, the response time, and the picture."""
    rows = _head("network", "codec", *LINK_FIGURES)
    for network, options in NETWORKS:
        for codec in CODECS if not options else ("h264",):
            summary = run("look-around", *SHORT, "--latency", "200", "--fill", "pyramid", "--codec", codec, *options)
            rows.append(_line(network, codec, *_link_figures(summary)))
    return "\n".join(rows)


def _link_figures(summary: Summary) -> list[str]:
    link, frames = summary["link"], summary["link"]["frames"]
    lost = frames["lost"] + frames["undecodable"] + frames["dropped"]
    late = frames["late"] + frames["superseded"]
    return [
        f"{link['mbit_s']:.1f}",
        *(_number(link.get(name)) for name in ("coded_psnr_db", "encode_ms", "decode_ms")),
        f"{frames['shown']} / {lost} / {late}",
        f"{link['response_ms']['median_ms']:.0f}",
        f"{_quality(summary, 'psnr_db'):.2f}",
        f"{_quality(summary, 'flip'):.3f}",
    ]


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.1f}"
