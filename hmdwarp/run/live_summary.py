"""The summary.json of a live run.

It has the keys of a replay's, so that the same tools compare both, and `live`.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from ..colour import picture_from_linear
from ..display import Display
from ..errors import counted
from ..gpu.textures import download
from ..metrics import aggregate_columns, middle_and_tail
from ..options import AUTO
from ..pipeline.loop import Refresh
from ..report import OutputFolder
from .frame_rows import STAGE_COLUMNS
from .host import PipelineHost
from .live_figures import OF_EYE, Events, LiveFigures
from .misses import MEASURED, STANDS, TURNED
from .options import OPENXR, LiveOptions
from .run_summary import EYES, Facts

if TYPE_CHECKING:
    from numpy.typing import NDArray


MOST = 1000
_WAITING = 8  # full pictures in memory at a time; beyond that the loop waits for the disk


class Pictures:
    """Keep every n-th refresh as images/frame-NNNNNN-{left,right}.png, at most `MOST` of them.

    Reading a picture back waits for the GPU: such a refresh is late, and its time shows it. A
    thread encodes and writes the PNGs. every: 0 for none.
    """

    def __init__(self, out: OutputFolder, every: int, most: int = MOST) -> None:
        self._out, self._every, self._most = out, every, most
        self._writer = ThreadPoolExecutor(1, "pictures") if every else None
        self._under_way: deque[Future[None]] = deque()
        self.count = 0

    def wants(self, number: int) -> bool:
        """Return whether the refresh of that number is to be kept."""
        return self._writer is not None and number % self._every == 0 and self.count < self._most

    @property
    def is_full(self) -> bool:
        """Whether the limit was reached."""
        return self.count >= self._most

    def keep(self, number: int, refresh: Refresh) -> None:
        """Read a picture back. Errors: as OutputFolder.write_png, for an earlier picture."""
        if self._writer is None:
            return
        for eye, result in enumerate(refresh.eyes):
            while len(self._under_way) >= _WAITING:
                self._under_way.popleft().result()
            name = f"images/frame-{number:06d}-{EYES[eye]}.png"
            self._under_way.append(self._writer.submit(self._write, name, download(result.panel.texture)))
        self.count += 1

    def _write(self, name: str, linear: NDArray[np.floating]) -> None:
        self._out.write_png(name, picture_from_linear(linear))

    def close(self) -> None:
        """Wait until all pictures are written. Errors: as keep; safe to call twice."""
        if self._writer is None:
            return
        self._writer.shutdown()
        while self._under_way:
            self._under_way.popleft().result()


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
    own = display.about.get("trace") if host.run.source.kind.has_head else ""
    trace, axes = Path(named).stem if named else own or display.name, display.about.get("trace_axes", "")
    shared = Facts.of(host.run, trace, headset, display.rate_hz, axes)
    notes = (*host.run.source.notes, *host.run.source.scene.notes)
    return LiveFacts(shared, options, display.name, dict(display.about), host.run.plans[0].lens.name, notes)


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
    if (acted := figures.answers.entry())["count"]:
        more |= {"input": acted, "notes": [*more["notes"], figures.answers.note()]}
    fill = AUTO if options.warp == AUTO else options.fill
    return facts.shared.summary((options.warp, fill, facts.lens), frames, more)


def _live(facts: LiveFacts, frames: int, figures: LiveFigures) -> dict[str, Any]:
    """Return the keys that only a live run has."""
    times, options = figures.times, facts.options
    seconds, render = times.column("time_s"), times.column("render_ms")
    # All eyes together: drawing, each stage, and the sum.
    both = {name: np.nansum([times.column(f"{name}/{eye}") for eye in (0, 1)], axis=0) for name in STAGE_COLUMNS}
    refresh = {"render": render, **{name.removesuffix("_ms"): values for name, values in both.items()}}
    refresh["total"] = render + refresh["total"]
    return {
        "source": facts.source,
        "about": facts.about,
        "record": str(options.record) if options.record is not None else None,
        "seconds": float(seconds[-1]) if len(seconds) else 0.0,
        "refreshes": frames,
        **attrs.asdict(figures.counts),
        **{name: middle_and_tail(times.measured(name)) for name in ("age_ms", "pose_age_ms", "period_ms")},
        "budget_ms": facts.budget_ms,
        "refresh_ms": {name: middle_and_tail(values) for name, values in refresh.items()},
        **figures.events.as_dict(),
        "garbage_collector": {"between": options.collect, **figures.pauses.as_dict()},
        "sampled_every": times.every,
    }


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
