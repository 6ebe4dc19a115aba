"""summary.json of a live run: the keys of a replay's, so that both are compared with the same tools, and `live` beside them."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from ...link import ResponseTime
from ...metrics import aggregate_columns, middle_and_tail
from ...report import SCHEMA
from ...version import __version__
from .facts import Facts
from .rows import STAGE_COLUMNS
from .thinned import Thinned

if TYPE_CHECKING:
    from ...display import Tick
    from ...pipeline.channel import Channel
    from ...pipeline.loop import Refresh
    from .events import Events
    from .pauses import Pauses
    from .pictures import Pictures

_OF_EYE = (*STAGE_COLUMNS, "hole_share")
SHARED = (
    "time_s",
    "age_ms",
    "pose_age_ms",
    "period_ms",
    "angular_speed_deg_s",
    "linear_speed_m_s",
    "render_ms",
    "busy_ms",
)
COLUMNS = (*SHARED, *(f"{name}/{eye}" for eye in (0, 1) for name in _OF_EYE))
_RESPONSE = (*ResponseTime().parts(), "total_ms")
_RESPONSE_EVERY = 8  # adding up its parts takes 10 us


@attrs.define(eq=False)
class Counts:
    """Refreshes: missed: that went by without a new picture. waiting: with nothing to show yet. unseen: when nobody would have seen it.
    over: whose passes and drawing together took longer than a refresh, of timed."""

    missed: int = 0
    waiting: int = 0
    unseen: int = 0
    over: int = 0
    timed: int = 0

    def without(self, tick: Tick) -> None:
        """A refresh that got no picture."""
        if tick.render:
            self.waiting += 1
        else:
            self.unseen += 1

    def busy(self, over: bool) -> None:
        """A refresh whose times are known."""
        self.timed += 1
        self.over += over


class Fates:
    """What became of the frames, over all the links a run had one after the other."""

    def __init__(self) -> None:
        self._past: Counter[str] = Counter()
        self._channel: Channel | None = None
        self._responses = Thinned(_RESPONSE)
        self._seen = 0

    def follow(self, channel: Channel) -> None:
        """This one from now on; the one before is closed."""
        if channel is self._channel:
            return
        if self._channel is not None:
            self._past.update(self._channel.link.tally.as_dict())
        self._channel = channel

    def look(self, refresh: Refresh) -> None:
        """A refresh whose times are known."""
        if self._seen % _RESPONSE_EVERY == 0:
            response = refresh.response
            self._responses.add((*response.parts().values(), response.total_ms))
        self._seen += 1

    def as_dict(self, rate_hz: float) -> dict[str, Any]:
        """The `link` of summary.json; size and codec are those of the last link. rate_hz: of the pictures, as they came."""
        told = self._channel.summary(rate_hz)
        frames = dict(Counter(told["frames"]) + self._past) if self._past else told["frames"]
        times = {name: self._responses.column(name) for name in _RESPONSE}
        response = (
            {name: float(np.median(values)) for name, values in times.items()} if len(times["total_ms"]) else None
        )
        return {**told, "frames": {name: frames.get(name, 0) for name in told["frames"]}, "response_ms": response}


def summary_of(
    facts: Facts,
    count: int,
    counts: Counts,
    figures: Thinned,
    fates: Fates,
    events: Events,
    pauses: Pauses,
    pictures: Pictures,
) -> dict[str, Any]:
    """The whole of it. Settings are those it began with; what was changed later is in `live`."""
    options = facts.options
    of_eyes = {name: figures.measured(*(f"{name}/{eye}" for eye in (0, 1))) for name in _OF_EYE}
    live = _live(facts, count, counts, figures, events, pauses)
    return {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "trace": _trace_of(facts),
        "scene": facts.scene,
        "effects": facts.effects,
        "latency_ms": options.latency_ms,
        "warp": options.warp,
        "fill": options.fill if options.warp != "auto" else options.warp,
        "lens": facts.lens,
        "headset": facts.headset,
        "size": list(facts.size),
        "frames": count,
        "rate_hz": facts.rate_hz,
        "guard": options.guard,
        "predict": options.predict,
        "pixels_per_degree": facts.pixels_per_degree,
        "machine": facts.machine,
        "clock": facts.clock,
        **aggregate_columns(of_eyes),
        "link": fates.as_dict((count - 1) / live["seconds"] if live["seconds"] else facts.rate_hz),
        "notes": [*facts.scene_notes, *_notes(events, live, pictures)],
        "live": live,
    }


def _trace_of(facts: Facts) -> str:
    """What a replay would be given, else whose head it was."""
    named = facts.options.record or facts.options.trace
    return Path(named).stem if named else facts.source


def _live(facts: Facts, count: int, counts: Counts, figures: Thinned, events: Events, pauses: Pauses) -> dict[str, Any]:
    """What a replay has not."""
    seconds = figures.column("time_s")
    return {
        "source": facts.source,
        "about": facts.about,
        "record": str(facts.options.record) if facts.options.record is not None else None,
        "seconds": float(seconds[-1]) if len(seconds) else 0.0,
        "refreshes": count,
        **attrs.asdict(counts),
        **{name: middle_and_tail(figures.measured(name)) for name in ("age_ms", "pose_age_ms", "period_ms")},
        "budget_ms": facts.budget_ms,
        "refresh_ms": _of_refresh(figures),
        **events.as_dict(),
        "garbage_collector": {"between": facts.options.collect, **pauses.as_dict()},
        "sampled_every": figures.every,
    }


def _of_refresh(figures: Thinned) -> dict[str, dict[str, float | None]]:
    """What a whole refresh goes into on this machine, all eyes together: the server's drawing, each stage, and the sum."""
    render = figures.column("render_ms")
    stages = {name: np.nansum([figures.column(f"{name}/{eye}") for eye in (0, 1)], axis=0) for name in STAGE_COLUMNS}
    times = {"render": render, **{name.removesuffix("_ms"): values for name, values in stages.items()}}
    times["total"] = render + times["total"]
    return {name: middle_and_tail(values) for name, values in times.items()}


def _notes(events: Events, live: dict[str, Any], pictures: Pictures) -> list[str]:
    notes = []
    if events.change_count:
        times = "once" if events.change_count == 1 else f"{events.change_count} times"
        notes.append(
            f"Settings were changed {times} while it ran. Figures are over all of it; frames.csv has each one's warp and fill."
        )
    for lost in events.lost[:5]:
        away = "and did not come back" if lost["away_s"] is None else f"for {lost['away_s']:.1f} s"
        notes.append(f"The display went away at {lost['time_s']:.2f} s {away}: {lost['why']}")
    if pictures.count:
        notes.append("Each kept picture was read back from the GPU: those refreshes are late by it.")
    if pictures.is_full:
        notes.append(f"After {pictures.count} kept pictures no more were kept.")
    if live["sampled_every"] > 1:
        notes.append(
            f"Medians, percentiles and curves are of every {live['sampled_every']}th refresh; frames.csv has all of them."
        )
    if not live["timed"]:
        notes.append("What the passes took is not known: the run ended before anybody could ask.")
    return notes
