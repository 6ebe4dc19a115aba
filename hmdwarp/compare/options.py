"""Options of `hmdwarp compare`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from ..link import LinkOptions
from ..link.codec import Coding
from ..options import Declared, force_field, group, names_in, out_field, same_as, several, split_names
from ..poses.options import TraceOptions
from ..run.options import RunOptions
from ..run.recordings import recordings_field, with_recordings
from ..scenes.options import SceneOptions
from ..sweep.options import SweepOptions

_RUN = attrs.fields(RunOptions)
SIZE = (640, 400)


@attrs.frozen
class _Coding(Coding):
    codec: str = same_as(attrs.fields(Coding).codec, "h264")


@attrs.frozen(kw_only=True)
class CompareOptions(Declared):
    """Every strategy on every recording at every latency, over the same link.

    Errors: InputError for a value out of range, and for an empty list.
    """

    recordings: tuple[str, ...] = recordings_field()
    # With settings where they matter; empty for all.
    strategies: tuple[str, ...] = several(
        _RUN.strategy, (), f"Strategy: {names_in('strategies')}; by default all.", split=split_names
    )
    latencies_ms: tuple[float, ...] = several(_RUN.latency_ms, (200.0, 400.0, 800.0))
    clients: tuple[str, ...] = several(
        _RUN.client,
        ("class-1", "class-2", "class-3"),
        f"Whom the fronts are for: {names_in('clients', '*.toml')}, or a .toml file",
    )
    scene: str = same_as(_RUN.scene)
    scene_options: SceneOptions = group(SceneOptions)
    headset: str = same_as(_RUN.headset)
    size: tuple[int, int] | None = same_as(_RUN.size, help=f"Pixels of one eye, by default {SIZE[0]}x{SIZE[1]}.")
    rate_hz: float | None = same_as(_RUN.rate_hz)
    start_s: float = same_as(_RUN.start_s, 1.0)
    seconds: float | None = same_as(_RUN.seconds, 1.0, help="Seconds to show of each recording.")
    metrics_every: int = same_as(_RUN.metrics_every)
    jod_s: float = same_as(_RUN.jod_s)
    network: LinkOptions = group(LinkOptions)
    coding: Coding = group(_Coding)
    workers: int | None = same_as(_RUN.workers)
    trace_options: TraceOptions = group(TraceOptions)
    out: Path = out_field(Path("out/compare"), "Folder for compare.html, compare.json and compare.csv.")
    force: bool = force_field()
    sweep: SweepOptions = group(SweepOptions)
    command: str = ""

    @property
    def eye_size(self) -> tuple[int, int]:
        """Pixels of one eye."""
        return self.size or SIZE

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that something was said about. Errors: InputError."""
        return super().values_of(with_recordings(said))
