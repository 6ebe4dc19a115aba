"""Options of `hmdwarp compare`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...link import LinkOptions
from ...link.codec import Coding
from ...options import Declared, force_field, group, names_in, out_field, same_as, several, split_names
from ...poses.options import TraceOptions
from ...run.options import RunOptions
from ...run.recordings import recordings_field, with_recordings
from ...scenes.options import SceneOptions
from ...sources.sequences.options import SequenceOptions
from ..sweep.options import SweepOptions

_RUN = attrs.fields(RunOptions)
SIZE, START_S = (640, 400), 1.0
# In place of a recording: the head of the camera whose frames are compared.
OWN_HEAD = ""
_NOT_WITH_FRAMES = {"recordings": "TRACE", "scene": "--scene", "headset": "--headset", "rate_hz": "--rate"}


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
        _RUN.strategy, (), f"Strategy: {names_in('client/strategies')}; by default all.", split=split_names
    )
    latencies_ms: tuple[float, ...] = several(_RUN.latency_ms, (200.0, 400.0, 800.0))
    clients: tuple[str, ...] = several(
        _RUN.client,
        ("class-1", "class-2", "class-3"),
        f"Whom the fronts are for: {names_in('client/classes', '*.toml')}, or a .toml file",
    )
    scene: str = same_as(_RUN.scene)
    scene_options: SceneOptions = group(SceneOptions)
    frames: Path | None = same_as(_RUN.frames)
    sequence_options: SequenceOptions = group(SequenceOptions)
    repair: str = same_as(_RUN.repair)
    headset: str = same_as(_RUN.headset)
    size: tuple[int, int] | None = same_as(
        _RUN.size, help=f"Pixels of one eye, by default {SIZE[0]}x{SIZE[1]}, or as recorded."
    )
    rate_hz: float | None = same_as(_RUN.rate_hz)
    start_s: float = same_as(_RUN.start_s, START_S)
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
    def eye_size(self) -> tuple[int, int] | None:
        """Pixels of one eye; None for those of recorded frames."""
        return self.size or (None if self.frames is not None else SIZE)

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that something was said about. Errors: InputError."""
        values = super().values_of(with_recordings(said))
        if values.get("frames") is None:
            return values
        for name, flag in _NOT_WITH_FRAMES.items():
            usual = attrs.fields_dict(cls).get(name)
            if name in values and (usual is None or values[name] != usual.default):
                raise InputError(
                    f"{flag} with --frames: all are compared on the camera's own frames, head and rate; leave it out"
                )
        # A second into a recording that may last less is not begun unless it is asked for.
        start_s = values.get("start_s", START_S)
        return {**values, "recordings": (OWN_HEAD,), "start_s": 0.0 if start_s == START_S else start_s}
