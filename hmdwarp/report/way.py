"""What became of the frames on their way, and which fill closed which holes, as text for the page and for the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Summary = Mapping[str, Any]
Pairs = list[tuple[str, str]]

_PARTS = {
    "render_ms": "drawing, both eyes",
    "encode_ms": "encoding",
    "queue_ms": "waiting for earlier frames",
    "transfer_ms": "size over bandwidth",
    "round_trip_ms": "the network, both ways",
    "decode_ms": "decoding",
    "warp_ms": "warp to lens, both eyes",
    "total_ms": "response time",
}
_FATES = {
    "drawn": "drawn",
    "sent": "sent",
    "dropped": "dropped before a full queue",
    "lost": "lost on the network",
    "undecodable": "arrived, but built on a lost one",
    "late": "came after a newer one was shown",
    "superseded": "a newer one came by the same refresh",
    "shown": "shown",
    "under_way": "still under way at the end",
}


def filled_rows(summary: Summary) -> Pairs:
    """(fill, share of all pixels) of each step of the chain, and what stayed empty; empty where the summary does not say."""
    filled = summary.get("filled") or {}
    return [
        ("left empty" if name == "empty" else f"fill {name}", f"{100 * share:.2f} %") for name, share in filled.items()
    ]


def response_rows(summary: Summary) -> Pairs:
    """(part, median ms) of the response time; parts that took nothing are left out."""
    response = (summary.get("link") or {}).get("response_ms") or {}
    return [(told, f"{response[name]:.2f} ms") for name, told in _PARTS.items() if response.get(name)]


def frame_rows(summary: Summary) -> Pairs:
    """(what became of them, how many frames); what happened to none is left out."""
    frames = (summary.get("link") or {}).get("frames") or {}
    return [(told, str(frames[name])) for name, told in _FATES.items() if frames.get(name)]


def coding_rows(summary: Summary) -> Pairs:
    """What frames weigh, and what the codec took and lost."""
    link = summary.get("link") or {}
    if "mbit_s" not in link:
        return []
    rows = [("rate, both eyes", f"{link['mbit_s']:.1f} Mbit/s{' uncompressed' if link['codec'] == 'none' else ''}")]
    if link["codec"] != "none":
        rows.append(("codec", link["codec"]))
        rows += [(told, _with_unit(link.get(name), unit)) for name, told, unit in _CODED]
    return rows


_CODED = (
    ("encode_ms", "encoding a frame", "ms"),
    ("decode_ms", "decoding a frame", "ms"),
    ("coded_psnr_db", "colour after coding", "dB PSNR"),
)


def _with_unit(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.1f} {unit}"


def told_lines(summary: Summary) -> list[str]:
    """For the terminal, after the table: nothing for a plain link and a single fill."""
    lines = []
    filled = filled_rows(summary)
    if len(filled) > 2:
        lines.append("holes: " + ", ".join(f"{name} {share}" for name, share in filled))
    link = summary.get("link") or {}
    counts = link.get("frames") or {}
    if link.get("codec", "none") != "none" or any(
        counts.get(name) for name in ("dropped", "lost", "late", "superseded", "undecodable")
    ):
        lines.append("frames: " + ", ".join(f"{count} {told}" for told, count in frame_rows(summary)))
        lines.append(
            "link: "
            + ", ".join(f"{told} {text}" for told, text in (*coding_rows(summary), *response_rows(summary)[-1:]))
        )
    return lines
