"""What every registry holds, as plain rows: for `hmdwarp list`, the README's tables and other programs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import attrs

if TYPE_CHECKING:
    from .client.warps import Warp
    from .headsets import Headset
    from .poses import PoseTrack


def entries(kind: str) -> list[dict[str, str]]:
    """Rows of one kind, each with at least `name` and `summary`. kind: warps, fills, lenses, scenes, headsets, formats, recordings."""
    return _MAKERS[kind]()


def _warps() -> list[dict[str, str]]:
    from .client.warps import warps

    return [_warp_row(warp) for warp in warps]


def _warp_row(warp: type[Warp]) -> dict[str, str]:
    return {
        "name": warp.name,
        "summary": warp.summary,
        "kind": warp.kind,
        "reads": ", ".join(warp.reads),
        "settings": ", ".join(f"{field.name}={field.default}" for field in attrs.fields(warp.Settings)) or "none",
        "fused_with_the_lens": "yes" if warp.fuses else "no",
        "follows_scanout": "yes" if warp.scans_out else "no",
        "exact_when": warp.exact_when,
        "gets_wrong": warp.gets_wrong,
        "source": warp.source,
    }


def _fills() -> list[dict[str, str]]:
    from .client.fills import fills

    return [{"name": f.name, "summary": f.summary, "source": f.source} for f in fills]


def _lenses() -> list[dict[str, str]]:
    from .client.lens import lenses

    return [{"name": x.name, "summary": x.summary, "source": x.source} for x in lenses]


def _scenes() -> list[dict[str, str]]:
    from .scenes import scenes

    return [{"name": s.name, "summary": s.summary, "effects": " ".join(e.name for e in s.effects) or "none"} for s in scenes]


def _headsets() -> list[dict[str, str]]:
    from .headsets import headset_names, load_headset

    return [_headset_row(load_headset(name)) for name in headset_names()]


def _headset_row(headset: Headset) -> dict[str, str]:
    angles = (math.degrees(angle) for angle in attrs.astuple(headset.left_fov))
    return {
        "name": headset.name,
        "summary": headset.summary,
        "eye_size": "x".join(map(str, headset.eye_size_px)),
        "refresh_hz": f"{headset.refresh_hz:g}",
        "left_fov_deg": ", ".join(f"{side} {angle:.1f}" for side, angle in zip(("left", "right", "down", "up"), angles, strict=True)),
        "lens": "radial" if headset.lens is not None else "none",
        "source": headset.source,
    }


def _formats() -> list[dict[str, str]]:
    from .poses.formats import FORMATS

    return [{"name": f.name, "summary": f.summary, "can_write": "yes" if f.writes else "no"} for f in FORMATS]


def _recordings() -> list[dict[str, str]]:
    from .poses import load_trace
    from .resources import recording_names

    return [_recording_row(load_trace(name).track) for name in recording_names()]


def _recording_row(track: PoseTrack) -> dict[str, str]:
    made_by, _, what = track.origin.rpartition("; ")  # as 'hmdwarp trace synth' writes it into the file
    return {
        "name": track.name,
        "summary": what,
        "seconds": f"{track.duration_ns * 1e-9:.1f}",
        "rate_hz": f"{track.rate_hz:.0f}",
        "origin": made_by or track.origin,
    }


_MAKERS: dict[str, Callable[[], list[dict[str, str]]]] = {
    "warps": _warps,
    "fills": _fills,
    "lenses": _lenses,
    "scenes": _scenes,
    "headsets": _headsets,
    "formats": _formats,
    "recordings": _recordings,
}
