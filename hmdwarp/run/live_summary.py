"""The summary.json of a live run.

It has the keys of a replay's, so that the same tools compare both, and `live`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ..display import Display
from ..errors import counted
from ..metrics import aggregate_columns, middle_and_tail
from .frame_rows import STAGE_COLUMNS
from .host import PipelineHost
from .kept_pictures import Pictures
from .live_figures import OF_EYE, Events, LiveFigures, Thinned
from .misses import MEASURED, STANDS, TURNED
from .options import OPENXR, LiveOptions
from .run_summary import Facts, chosen_passes


@attrs.frozen(eq=False)
class LiveFacts:
    """Facts about a live run that are settled when it begins."""

    shared: Facts
    options: LiveOptions
    # Name of the display, and its own description.
    source: str
    about: dict[str, str]
    # Of the first plan.
    lens: str
    scene_notes: tuple[str, ...]

    @property
    def budget_ms(self) -> float:
        """The period of the display."""
        return 1e3 / self.shared.rate_hz

    @property
    def turns(self) -> bool:
        """Whether the display turns a picture that it shows again to the newest head."""
        return self.source == OPENXR


def live_facts_of(options: LiveOptions, display: Display, host: PipelineHost) -> LiveFacts:
    """Return the facts of a run on this display."""
    headset = display.headset.name if display.headset is not None else display.about.get("headset") or display.name
    named = options.record or options.trace
    own = display.about.get("trace") if host.source.kind.has_head else ""
    trace, axes = Path(named).stem if named else own or display.name, display.about.get("trace_axes", "")
    shared = Facts.of(host.pipeline, trace, headset, display.rate_hz, axes)
    notes = (*host.source.notes, *host.source.scene.notes)
    return LiveFacts(shared, options, display.name, dict(display.about), host.plan.lens.name, notes)


def live_summary_of(facts: LiveFacts, frames: int, figures: LiveFigures, pictures: Pictures | None) -> dict[str, Any]:
    """Return the summary. Settings are those at the start; later changes are in `live`."""
    options, times = facts.options, figures.times
    of_eyes = {name: times.measured(*(f"{name}/{eye}" for eye in (0, 1))) for name in OF_EYE}
    live = _live(facts, frames, figures)
    more = {
        **aggregate_columns(of_eyes),
        "link": figures.fates.as_dict((frames - 1) / live["seconds"] if live["seconds"] else facts.shared.rate_hz),
        "miss": {
            "budget_ms": facts.budget_ms,
            "times": MEASURED,
            "show": TURNED if facts.turns else STANDS,
            **figures.misses.as_dict(),
        },
        "notes": [*facts.scene_notes, *options.notes, *_notes(figures.events, live, pictures)],
        "live": live,
    }
    return facts.shared.summary(chosen_passes(options, facts.lens), frames, more)


def _live(facts: LiveFacts, frames: int, figures: LiveFigures) -> dict[str, Any]:
    """Return the keys that only a live run has."""
    times, options = figures.times, facts.options
    seconds = times.column("time_s")
    return {
        "source": facts.source,
        "about": facts.about,
        "record": str(options.record) if options.record is not None else None,
        "seconds": float(seconds[-1]) if len(seconds) else 0.0,
        "refreshes": frames,
        **attrs.asdict(figures.counts),
        **{name: middle_and_tail(times.measured(name)) for name in ("age_ms", "pose_age_ms", "period_ms")},
        "budget_ms": facts.budget_ms,
        "refresh_ms": _of_refresh(times),
        **figures.events.as_dict(),
        "garbage_collector": {"between": options.collect, **figures.pauses.as_dict()},
        "sampled_every": times.every,
    }


def _of_refresh(times: Thinned) -> dict[str, dict[str, float | None]]:
    """Return the times of a whole refresh on this machine, all eyes together.

    Drawing, each stage, and the sum.
    """
    render = times.column("render_ms")
    stages = {name: np.nansum([times.column(f"{name}/{eye}") for eye in (0, 1)], axis=0) for name in STAGE_COLUMNS}
    columns = {"render": render, **{name.removesuffix("_ms"): values for name, values in stages.items()}}
    columns["total"] = render + columns["total"]
    return {name: middle_and_tail(values) for name, values in columns.items()}


def _notes(events: Events, live: dict[str, Any], pictures: Pictures | None) -> list[str]:
    notes = []
    if events.change_count:
        times = "once" if events.change_count == 1 else f"{events.change_count} times"
        notes.append(
            f"Settings were changed {times} while it ran. Figures are over all of it; frames.csv has each one's warp "
            "and fill."
        )
    for lost in events.lost[:5]:
        away = "and did not come back" if lost["away_s"] is None else f"for {lost['away_s']:.1f} s"
        notes.append(f"The display went away at {lost['time_s']:.2f} s {away}: {lost['why']}")
    if pictures is not None and pictures.count:
        notes.append("Kept pictures were read back from the GPU, which makes their refreshes late.")
    if pictures is not None and pictures.is_full:
        notes.append(f"Only the first {counted(pictures.count, 'picture')} were kept: the limit.")
    if live["sampled_every"] > 1:
        notes.append(
            f"Medians, percentiles and curves are of every {live['sampled_every']}th refresh; frames.csv has all of "
            "them."
        )
    if not live["timed"]:
        notes.append("The times of the passes are unknown: the run ended before they could be read.")
    return notes
