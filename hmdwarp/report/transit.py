"""The frames in transit and the holes each fill closed, as text for the page and the terminal."""

from __future__ import annotations

from collections.abc import Mapping

from .source_texts import drawing_text, eyes_text
from .tables import Summary

Pairs = list[tuple[str, str]]

_RESPONSE = {
    "render_ms": "{drawing}, {eyes}",
    "encode_ms": "encoding of the shown frames",
    "queue_ms": "waiting for earlier frames",
    "transfer_ms": "size over bandwidth",
    "round_trip_ms": "the network, both ways",
    "decode_ms": "decoding of the shown frames",
    "warp_ms": "warp to lens, {eyes}",
    "total_ms": "{kind} (mean: the sum of these)",
    "median_ms": "{kind} (median)",
    "p95_ms": "{kind} (95th percentile)",
}
# With --response fixed a frame is as old as the latency says, whatever the stages took here.
_WITH_STAGES = "the latency and this machine's stages on top"
_FRAMES = {
    "skipped": "not drawn (the server was busy)",
    "unchanged": "not drawn (nothing would have changed)",
    "drawn": "drawn",
    "sent": "sent",
    "never_shown": "drawn in vain (never shown)",
    "dropped": "dropped before a full queue",
    "lost": "lost on the network",
    "undecodable": "undecodable (depend on a lost frame)",
    "late": "too late (a newer one was shown)",
    "superseded": "superseded (a newer one came by the same refresh)",
    "shown": "shown",
    "under_way": "in transit at the end",
}
_CODING = (
    ("encode_ms", "encoding (median of all frames)", "ms"),
    ("decode_ms", "decoding (median of all frames)", "ms"),
    ("coded_psnr_db", "pictures after coding", "dB PSNR"),
)
_TROUBLE = ("skipped", "unchanged", "dropped", "lost", "late", "superseded", "undecodable")


def filled_rows(summary: Summary) -> Pairs:
    """Return (fill, share of all pixels) of each step of the chain, then the pixels left empty.

    The list is empty if the summary does not say.
    """
    filled: Mapping[str, float] = summary.get("filled") or {}
    return [
        ("left empty" if name == "empty" else f"fill {name}", f"{100 * share:.2f} %") for name, share in filled.items()
    ]


def model_rows(summary: Summary) -> Pairs:
    """Return (model, what it weighs) of each model that the client drew for itself.

    With what crossed for it, packed, where the summary says so.
    """
    rows = []
    for one in summary.get("client_models") or ():
        if "share" not in one:
            *_, kept = one  # how many things it holds comes last
            rows.append((f"client's {kept}", f"{one[kept]}, room of {one['geometry_bytes'] / 1e6:.1f} MB"))
        else:
            named = f"client's model, {100 * one['share']:g} % of the triangles, textures at {one['texture']:g}"
            weight = f"{one['triangles']} triangles {one['geometry_bytes'] / 1e6:.1f} MB, "
            rows.append((named, f"{weight}textures {one['texture_bytes'] / 1e6:.1f} MB"))
        if "start_up_bytes" in one:
            first = one["first_picture_bytes"]
            whole = "no whole picture" if first is None else f"{first / 1e6:.2f} MB before the first whole picture"
            rows.append(
                (
                    "of that crossed, packed",
                    f"{one['start_up_bytes'] / 1e6:.2f} MB at the start, {whole}, {one['arrived_bytes'] / 1e6:.2f} MB "
                    "in all",
                )
            )
    return rows


def response_rows(summary: Summary) -> Pairs:
    """Return (part, mean ms) of the response time, without parts that took no time.

    They add up to the mean response time; its median and 95th percentile follow.
    """
    return _response(summary, *_RESPONSE)


def _response(summary: Summary, *names: str) -> Pairs:
    link = summary.get("link") or {}
    kind = "response time" if link.get("response") == "sum" else _WITH_STAGES
    took = link.get("response_ms") or {}
    words = {"kind": kind, "drawing": drawing_text(summary), "eyes": eyes_text(summary)}
    return [(_RESPONSE[name].format(**words), f"{took[name]:.2f} ms") for name in names if took.get(name)]


def frame_rows(summary: Summary) -> Pairs:
    """Return (outcome, number of frames), without outcomes of no frame."""
    frames = (summary.get("link") or {}).get("frames") or {}
    return [(outcome, str(frames[name])) for name, outcome in _FRAMES.items() if frames.get(name)]


def coding_rows(summary: Summary) -> Pairs:
    """Return the data rate, of each layer too, and the time and loss of the codec."""
    link = summary.get("link") or {}
    if "mbit_s" not in link:
        return []
    coded = " uncompressed" if link["codec"] == "none" else ""
    rows = [(f"rate, {eyes_text(summary)}", f"{link['mbit_s']:.1f} Mbit/s{coded}")]
    layers: Mapping[str, float] = link.get("layers_mbit_s") or {}
    if len(layers) > 1:
        rows.append(("of that", ", ".join(f"{name.replace('_', ' ')} {rate:.1f}" for name, rate in layers.items())))
    if "up_mbit_s" in link:
        rows.append(("head poses to the server", f"{link['up_mbit_s']:.2f} Mbit/s"))
    if link["codec"] != "none":
        rows.append(("codec", link["codec"]))
        rows += [(label, _with_unit(link.get(name), unit)) for name, label, unit in _CODING]
    if "proxy" in link:
        rows += _about_proxy(link["proxy"])
    if "resolution" in link:
        rows += [
            (f"frames at {float(scale):.0%} of the width and height", str(count))
            for scale, count in link["resolution"]["frames"].items()
            if count
        ]
        rows.append(("changes of resolution", str(link["resolution"]["changes"])))
    return rows


def _about_proxy(proxy: Summary) -> Pairs:
    """Return what the proxy gets and does."""
    passes = proxy["warp"] if proxy["fill"] == "none" else f"{proxy['warp']} + {proxy['fill']}"
    coded = " uncompressed" if proxy["codec"] == "none" else f", {proxy['codec']}"
    took = proxy["time_ms"].get("total", {}).get("median")
    return [
        ("proxy", passes),
        ("from the server to the proxy", f"{proxy['latency_ms']:g} ms, {proxy['mbit_s']:.1f} Mbit/s{coded}"),
        ("the proxy's warp to fill, one eye (median)", _with_unit(took, "ms")),
    ]


def _with_unit(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.1f} {unit}"


def transit_lines(summary: Summary) -> list[str]:
    """Return lines for the terminal, after the table: none for a plain link and a single fill."""
    lines = []
    filled = filled_rows(summary)
    if len(filled) > 2:
        lines.append("holes: " + ", ".join(f"{name} {share}" for name, share in filled))
    lines += [f"{name}: {weight}" for name, weight in model_rows(summary)]
    link = summary.get("link") or {}
    counts = link.get("frames") or {}
    if "proxy" in link or link.get("codec", "none") != "none" or any(counts.get(name) for name in _TROUBLE):
        lines.append("frames: " + ", ".join(f"{count} {outcome}" for outcome, count in frame_rows(summary)))
        rows = [*coding_rows(summary), *_response(summary, "median_ms")]
        lines.append("link: " + ", ".join(f"{label} {text}" for label, text in rows))
    return lines
