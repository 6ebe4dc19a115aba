"""Tables of docs/results.md about what comes after the warp and beside it: effects, fills, the link. Each row is one replay."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Summary = dict[str, Any]
Run = Callable[..., Summary]  # (trace, *options) -> summary.json

LATENCIES = ("200", "400", "800")
COMMON = ("--guard", "1.5", "--lens", "none")
SHORT = (*COMMON, "--rate", "30", "--start", "1", "--seconds", "1.2", "--metrics-every", "9")
SMALL = (
    *COMMON,
    "--size",
    "240x300",
    "--rate",
    "20",
    "--start",
    "1",
    "--seconds",
    "0.8",
    "--metrics-every",
    "4",
)  # mirrors are drawn slowly
LONG = (
    *COMMON,
    "--rate",
    "20",
    "--start",
    "2",
    "--seconds",
    "6",
    "--metrics-every",
    "15",
)  # the head comes back to what it saw
FILLS = (
    "none",
    "interpolate",
    "interpolate_full",
    "stretch+pyramid",
    "pyramid",
    "wide+pyramid",
    "memory+pyramid",
    "model",
    "relight",
    "memory+relight",
    "interpolate+memory+pyramid",
)
SLOW_FILLS = ("interpolate", "pyramid", "model", "relight")  # after `mesh`, which takes a quarter of a second an eye
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
    """For each scene and effect the error with its pass and without, at each latency, and what the pass costs.

    scenes: (name, names of the effects it calls for). Without a pass the server draws the content into the picture, as it always did.
    """
    rows = _head("scene", "ms late", "left out", "PSNR dB", "FLIP", "flicker", "effects ms an eye", "MB a frame")
    for scene, effects in scenes:
        for latency in LATENCIES:
            for left_out in ("", *effects, *(("all",) if len(effects) > 1 else ())):
                asked = {"": "auto", "all": "none"}.get(left_out, f"no-{left_out}")
                got = run(
                    "walk",
                    *SMALL,
                    "--scene",
                    scene,
                    "--latency",
                    latency,
                    "--effects",
                    asked,
                    "--warp",
                    "iterative",
                    "--fill",
                    "pyramid",
                )
                figures = (
                    f"{_quality(got, 'psnr_db'):.2f}",
                    f"{_quality(got, 'flip'):.3f}",
                    f"{_quality(got, 'flicker'):.3f}",
                )
                ms, size = got["time_ms"]["effects"]["median"], got["link"]["frame_bytes"] / 1e6
                rows.append(
                    _line(
                        f"`{scene}`",
                        latency,
                        left_out and f"`{left_out}`" or "nothing",
                        *figures,
                        f"{ms:.1f}",
                        f"{size:.1f}",
                    )
                )
    return "\n".join(rows)


def fills_table(run: Run) -> str:
    """Every fill at 400 ms, after `forward`; the complete ones after `mesh` too."""
    head = (
        "recording",
        "warp",
        "fill",
        "PSNR in former holes",
        "FLIP in former holes",
        "PSNR dB",
        "FLIP",
        "flicker",
        "fill ms an eye",
        "left empty %",
    )
    rows = _head(*head)
    for trace in ("look-around", "walk"):
        for warp, fills in (("forward", FILLS), ("mesh", SLOW_FILLS)):
            for fill in fills:
                got = run(trace, *LONG, "--latency", "400", "--warp", warp, "--fill", fill)
                rows.append(_line(trace, f"`{warp}`", f"`{fill}`", *_fill_figures(got)))
    return "\n".join(rows)


def memory_table(run: Run) -> str:
    """What a memory is worth to a head that comes back, without a guard band and with one."""
    rows = _head(
        "guard",
        "fill",
        "PSNR in former holes",
        "FLIP in former holes",
        "PSNR dB",
        "FLIP",
        "flicker",
        "fill ms an eye",
        "left empty %",
    )
    for guard in ("1", "1.5"):
        for fill in ("pyramid", "memory+pyramid"):
            got = run("look-around", *LONG, "--latency", "400", "--fill", fill, "--guard", guard)
            rows.append(_line(guard, f"`{fill}`", *_fill_figures(got)))
    return "\n".join(rows)


def _fill_figures(got: Summary) -> list[str]:
    holes, empty = (
        got["regions"]["holes"],
        got["filled"]["empty"] if len(got["filled"]) > 1 else got["regions"]["holes"]["share"],
    )
    figures = [
        f"{holes['psnr_db']:.2f}",
        f"{holes['flip']:.3f}",
        f"{_quality(got, 'psnr_db'):.2f}",
        f"{_quality(got, 'flip'):.3f}",
    ]
    return [
        *figures,
        f"{_quality(got, 'flicker'):.3f}",
        f"{got['time_ms']['fill']['median']:.1f}",
        f"{100 * empty:.2f}",
    ]


def link_table(run: Run) -> str:
    """Networks and codecs: what became of the frames, the response time, and what it does to the picture."""
    head = (
        "network",
        "codec",
        "Mbit/s",
        "coded PSNR",
        "encode ms",
        "decode ms",
        "frames shown / lost / late",
        "response ms",
        "PSNR dB",
        "FLIP",
    )
    rows = _head(*head)
    for network, options in NETWORKS:
        for codec in CODECS if not options else ("h264",):
            got = run("look-around", *SHORT, "--latency", "200", "--fill", "pyramid", "--codec", codec, *options)
            rows.append(_line(network, codec, *_link_figures(got)))
    return "\n".join(rows)


def _link_figures(got: Summary) -> list[str]:
    link, frames = got["link"], got["link"]["frames"]
    coded = [_number(link.get(name)) for name in ("coded_psnr_db", "encode_ms", "decode_ms")]
    fate = f"{frames['shown']} / {frames['lost'] + frames['undecodable'] + frames['dropped']} / {frames['rendered'] + frames['superseded']}"
    picture = (f"{_quality(got, 'psnr_db'):.2f}", f"{_quality(got, 'flip'):.3f}")
    return [f"{link['mbit_s']:.1f}", *coded, fate, f"{link['response_ms']['total_ms']:.0f}", *picture]


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.1f}"
