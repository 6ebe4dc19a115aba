"""Tables of docs/results-*.md on effects, fills and the link. Each row is one replay."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable
from typing import Any

from hmdwarp.client.warps import warps
from hmdwarp.link.codec import DEPTH_CODES

Summary = dict[str, Any]
Run = Callable[..., Summary]  # (trace, *options) -> summary.json

LATENCIES = ("200", "400", "600", "800")
COMMON = shlex.split("--guard 1.5 --lens none")
SHORT = [*COMMON, *shlex.split("--rate 30 --start 1 --seconds 1.2 --metrics-every 9")]
SMALL = [
    *COMMON,
    *shlex.split("--size 240x300 --rate 20 --start 1 --seconds 0.8 --metrics-every 4"),
]  # slow
# Long enough for frames 400 and 800 ms older than the one that is shown.
OLDER = [*COMMON, *shlex.split("--size 240x300 --rate 5 --start 2 --seconds 1.4 --metrics-every 2")]
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
DEPTH_FIGURES = ("Mbit/s", "colour Mbit/s", "of the colour", "encode ms", "decode ms", "PSNR dB", "FLIP")
NETWORKS = (
    ("constant", ()),
    ("uniform jitter of 30 ms", ("--jitter", "uniform:30")),
    ("10 % lost in bursts of three", ("--loss", "p=0.037,r=0.33", "--link-seed", "1")),
    ("60 Mbit/s", ("--bandwidth", "60")),
)
TRAFFIC = shlex.split("--size 320x400 --lens none --fill none --rate 60 --start 1 --seconds 0.5 --metrics-every 100")
SENT_BY_FILLS = ("wide",)
LAYERED_SCENES = ("gallery", "greenhouse", "cockpit", "workshop", "parade")
CODECS = ("none", "h264", "hevc")
DEPTHS = shlex.split("--guard 1.5 --size 320x400 --lens none --fill pyramid --rate 60 --start 1 --seconds 0.5")
DEPTH_CASES = (
    ("look-around", "room", "iterative"),
    ("walk", "room", "iterative"),
    ("walk", "room", "backward"),
)

# 400 ms in all, of which the client's link takes 100.
PROXIED = [
    *COMMON,
    *shlex.split("--predict none --size 320x400 --rate 20 --start 2 --seconds 6 --metrics-every 15"),
    *shlex.split("--codec h264"),
]
_DIRECT = "--warp iterative --fill memory+pyramid"
PROXIES = {
    "`none`": ("100", "--warp none --fill none"),
    "`rotation`": ("100", "--warp rotation --fill none"),
    "`iterative`, 300 ms": ("300", _DIRECT),
    "proxy, `none`": ("100", "--proxy --proxy-codec h264 --guard 1 --warp none --fill none"),
    "proxy, `rotation`": ("100", "--proxy --proxy-codec h264 --warp rotation --fill none"),
    "`none`, all the way": ("400", "--warp none --fill none"),
    "`rotation`, all the way": ("400", "--warp rotation --fill none"),
    "`iterative`, all the way": ("400", _DIRECT),
}
PROXY_FIGURES = (
    "PSNR dB",
    "FLIP",
    "empty %",
    "client: ms an eye",
    "decode ms",
    "Mbit/s",
    "proxy: ms an eye",
    "Mbit/s to the proxy",
)

# Chosen views beside what comes anyway (multi) and what edges uncover (layered).
CHOSEN = [
    *COMMON,
    *shlex.split("--predict cautious --fill memory+pyramid --size 160x200 --rate 20 --start 4 --seconds 1.5"),
    *shlex.split("--metrics-every 3 --codec h264 --send changes"),
]
VIEWS = {
    "`multi`": "multi",
    "`multi:views=2,frames=1,eye=own`": "multi:views=2,frames=1,eye=own",
    "`layered`": "layered",
}
VIEWS_FIGURES = ("holes %", "FLIP", "PSNR dB", "Mbit/s", "client: ms an eye", "server ms", "not sent")


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


def pictures_table(run: Run) -> str:
    """Return what mirrors gain by their data, and by pictures alone, and what `room` loses."""
    names = {"`none`": "none", "known mirrors": "auto", "`reflections_from_pictures`": "reflections_from_pictures"}
    rows = _head("recording", "scene", "ms late", "effects", "PSNR dB", "FLIP", "flicker", "times the warp's time")
    for trace in ("look-around", "walk"):
        for scene, latency in (*(("gallery", latency) for latency in ("200", "400", "800")), ("room", "400")):
            for name, effects in names.items():
                if scene == "room" and effects == "auto":
                    continue  # the same as none
                choices = f"--scene {scene} --latency {latency} --warp iterative --fill pyramid --effects {effects}"
                summary = run(trace, *OLDER, *shlex.split(choices))
                ms, warp = (summary["time_ms"][stage]["median"] for stage in ("effects", "warp"))
                figures = [*_effect_figures(summary)[:3], f"{ms / warp:.1f}"]
                rows.append(_line(trace, f"`{scene}`", latency, name, *figures))
    return "\n".join(rows)


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


def proxy_table(run: Run) -> str:
    """Return what the client sees over a proxy, beside a direct link of the parts of its latency.

    The sum: the squared errors of the same client on the second link and of the warp on the first.
    """
    rows = _head("recording", "what", "ms", *PROXY_FIGURES)
    for trace in ("look-around", "walk"):
        found = {}
        for name, (latency, options) in PROXIES.items():
            # The passes that the table is made with come first, and a later one wins.
            found[name] = run(trace, *PROXIED, "--latency", latency, *shlex.split(options))
            rows.append(_line(trace, name, _latency(found[name]), *_proxy_figures(found[name])))
        for client in ("none", "rotation"):
            parts = (found[f"`{client}`"], found["`iterative`, 300 ms"])
            both = -10 * math.log10(sum(10 ** (-_quality(part, "psnr_db") / 10) for part in parts))
            rows.append(_line(trace, f"sum: `{client}` at 100 ms, `iterative` at 300 ms", "", f"{both:.2f}", *[""] * 7))
    return "\n".join(rows)


def views_table(run: Run) -> str:
    """Return the pictures of chosen views beside those that come anyway and peeled ones."""
    rows = _head("recording", "ms", "warp", *VIEWS_FIGURES)
    for trace in ("look-around", "walk"):
        for latency in ("200", "400", "800"):
            for name, warp in VIEWS.items():
                summary = run(trace, *CHOSEN, "--latency", latency, "--warp", warp)
                rows.append(_line(trace, latency, name, *_views_figures(summary)))
    return "\n".join(rows)


def _views_figures(summary: Summary) -> list[str]:
    link = summary["link"]
    share = f"{100 * _quality(summary, 'hole_share'):.2f}"
    quality = [f"{_quality(summary, 'flip'):.3f}", f"{_quality(summary, 'psnr_db'):.2f}"]
    times = [f"{summary['time_ms']['total']['median']:.1f}", f"{link['response_ms']['render_ms']:.0f}"]
    return [share, *quality, f"{link['mbit_s']:.1f}", *times, str(link["frames"]["unchanged"])]


def _latency(summary: Summary) -> str:
    latency, proxy = summary["latency_ms"], summary["link"].get("proxy")
    return f"{latency:g}" if proxy is None else f"{proxy['latency_ms']:g} + {latency:g}"


def _proxy_figures(summary: Summary) -> list[str]:
    link, proxy = summary["link"], summary["link"].get("proxy")
    quality = [f"{_quality(summary, 'psnr_db'):.2f}", f"{_quality(summary, 'flip'):.3f}"]
    empty = f"{100 * summary['filled']['empty']:.2f}"
    client = [f"{summary['time_ms']['total']['median']:.1f}", _number(link["decode_ms"])]
    between = ["", ""] if proxy is None else [f"{proxy['time_ms']['total']['median']:.1f}", f"{proxy['mbit_s']:.1f}"]
    return [*quality, empty, *client, f"{link['mbit_s']:.1f}", *between]


def layers_table(run: Run) -> str:
    """Return what each warp and each kind of layer sends, uncompressed and through H.264.

    Warps that read the same of a frame send the same, and share a row.
    """
    asked = {f"`{warp.name}`": ("--scene", "room", "--warp", warp.name) for warp in warps}
    asked |= {f"fill `{fill}`": ("--scene", "room", "--warp", "rotation", "--fill", fill) for fill in SENT_BY_FILLS}
    asked |= {f"scene `{scene}`": ("--scene", scene, "--warp", "iterative") for scene in LAYERED_SCENES}
    rows: dict[tuple[str, ...], list[str]] = {}
    for name, options in asked.items():
        coded, plain = (run("look-around", *TRAFFIC, "--codec", codec, *options)["link"] for codec in ("h264", "none"))
        layers = ", ".join(f"{layer.replace('_', ' ')} {rate:.1f}" for layer, rate in coded["layers_mbit_s"].items())
        rows.setdefault((f"{plain['mbit_s']:.0f}", f"{coded['mbit_s']:.1f}", layers), []).append(name)
    lines = [_line(", ".join(names), *figures) for figures, names in rows.items()]
    return "\n".join([*_head("warp, fill or scene", "Mbit/s uncompressed", "h264", "of that"), *lines])


def depth_codes_table(run: Run) -> str:
    """Return what each code of depth weighs beside the colour, and the error after the warp."""
    rows = _head("recording, scene, warp", "depth", *DEPTH_FIGURES)
    for trace, scene, warp in DEPTH_CASES:
        for code in DEPTH_CODES:
            choices = f"--latency 200 --scene {scene} --warp {warp} --codec h264 --depth-code {code} --metrics-every 6"
            summary = run(trace, *DEPTHS, *shlex.split(choices))
            rows.append(_line(f"{trace}, `{scene}`, `{warp}`", f"`{code}`", *_depth_figures(summary)))
    return "\n".join(rows)


def _depth_figures(summary: Summary) -> list[str]:
    link = summary["link"]
    depth, colour = (link["layers_mbit_s"][name] for name in ("inverse_depth", "colour"))
    figures = [f"{depth:.1f}", f"{colour:.1f}", f"{depth / colour:.2f}", _number(link["encode_ms"])]
    return [
        *figures,
        _number(link["decode_ms"]),
        f"{_quality(summary, 'psnr_db'):.2f}",
        f"{_quality(summary, 'flip'):.4f}",
    ]


def server_rates_table(rows: list[Summary]) -> str:
    """Return FLIP of each warp at each rate of the server, from the rows of a bench."""
    rates = sorted({row["server_rate_hz"] for row in rows})
    flip = {(row["warp"], row["server_rate_hz"]): f"{_quality(row, 'flip'):.3f}" for row in rows}
    lines = _head("warp", *(f"{rate:g} Hz" for rate in rates))
    for warp in dict.fromkeys(row["warp"] for row in rows):
        lines.append(_line(f"`{warp}`", *(flip[warp, rate] for rate in rates)))
    return "\n".join(lines)


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
