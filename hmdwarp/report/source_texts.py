"""What a page says of recorded frames in the place of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Facts = list[tuple[str, str]]


def source_facts(summary: Mapping[str, Any]) -> Facts:
    """Return (kind, text) of the frames' origin: a scene, or a folder, its camera and the eyes."""
    recorded = summary.get("recorded")
    if recorded is None:
        return [("scene", summary["scene"])]
    across, down = recorded["fov_deg"]
    camera = f"{'×'.join(map(str, recorded['size']))}, {across:.1f} × {down:.1f} degrees"
    distance = recorded["eye_distance_mm"]
    eyes = f"both, the right one {distance:g} mm beside the camera" if distance else "one, the camera's"
    return [
        ("recorded frames", f"{recorded['folder']} ({recorded['frames']}, {recorded['layout']})"),
        ("camera", camera),
        ("eyes", eyes),
    ]


def source_text(summary: Mapping[str, Any]) -> str:
    """Return "scene room", or "recorded frames NAME"."""
    return f"{'scene' if 'recorded' not in summary else 'recorded frames'} {summary['scene']}"


def eyes_text(summary: Mapping[str, Any]) -> str:
    """Return whose time it is that all eyes take together."""
    recorded = summary.get("recorded")
    return "both eyes" if recorded is None or recorded["eye_distance_mm"] else "the camera's eye"


def drawing_text(summary: Mapping[str, Any]) -> str:
    """Return what the server does before it sends a frame."""
    return "drawing" if "recorded" not in summary else "reading the recorded frame"
