"""Options of `hmdwarp compare`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from ...link import LinkOptions
from ...link.codec import Coding
from ...options import group, names_in, out_field, same_as, several, split_names
from ...run.options import RunOptions
from ..sweep.options import RecordedOptions, own_first

_RUN = attrs.fields(RunOptions)
SIZE, START_S = (640, 400), 1.0


@attrs.frozen
class _Coding(Coding):
    codec: str = same_as(attrs.fields(Coding).codec, "h264")


@attrs.frozen(kw_only=True, field_transformer=own_first)
class CompareOptions(RecordedOptions):
    """Every strategy on every recording at every latency, over the same link.

    Errors: InputError for a value out of range, and for an empty list.
    """

    with_frames = ("recordings", "scene", "headset", "rate_hz")
    why_not = "all are compared on the camera's own frames, head and rate"

    # With settings where they matter; empty for all.
    strategies: tuple[str, ...] = several(
        _RUN.strategy, (), f"Strategy: {names_in('client/strategies')}; by default all.", split=split_names
    )
    latencies_ms: tuple[float, ...] = several(_RUN.latency_ms, (200.0, 400.0, 800.0))
    clients: tuple[str, ...] = several(
        _RUN.client,
        ("class-1", "class-2", "class-3"),
        f"Clients to draw Pareto fronts for: {names_in('client/classes', '*.toml')}, or a .toml file",
    )
    scene: str = same_as(_RUN.scene)
    repair: str = same_as(_RUN.repair)
    size: tuple[int, int] | None = same_as(
        _RUN.size, help=f"Pixels of one eye, by default {SIZE[0]}x{SIZE[1]}, or as recorded."
    )
    start_s: float = same_as(_RUN.start_s, START_S)
    seconds: float | None = same_as(_RUN.seconds, 1.0, help="Seconds to show of each recording.")
    metrics_every: int = same_as(_RUN.metrics_every)
    network: LinkOptions = group(LinkOptions)
    coding: Coding = group(_Coding)
    out: Path = out_field(Path("out/compare"), "Folder for compare.html, compare.json and compare.csv.")

    @property
    def eye_size(self) -> tuple[int, int] | None:
        """Pixels of one eye; None for those of recorded frames."""
        return self.size or (None if self.frames is not None else SIZE)

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that were set. Errors: InputError."""
        values = super().values_of(said)
        # A second into a recording that may last less is not begun unless it is asked for.
        if values.get("frames") is not None and values.get("start_s", START_S) == START_S:
            values["start_s"] = 0.0
        return values
