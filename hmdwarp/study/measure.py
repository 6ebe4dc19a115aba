"""Measures afterwards what was shown: each trial's head trace goes through the replay again, against a renderer without latency.

What a trial showed cannot be measured while it is shown: the truth is a second picture, and FLIP takes a second. The replay is the same
pipeline with the trial's settings, on the head as it was recorded and at the instants it was recorded at. It is even in time where the
display was not, and its first pictures come when the first frame has arrived, so the first moments of a trial (its latency) are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from ..headsets import load_headset
from ..metrics import QUALITY
from ..pipeline.options import AUTO, PipelineOptions, RunOptions, number, parse_size
from ..run.replay import figures
from ..version import __version__
from .design.settings import live_options
from .store import Session, Showing, Store

_SHARED = tuple(field.name for field in attrs.fields(PipelineOptions))
Progress = Callable[[int, int], None]
Say = Callable[[str], None]


@attrs.frozen(kw_only=True)
class MeasureOptions:
    """every: pictures are measured at every n-th refresh. size: (w, h) of one eye, None for as it was shown. again: also what was measured
    before in the same way. pilot: rehearsals instead of sessions. workers: as RunOptions."""

    every: int = attrs.field(default=10, validator=number("every", least=1))
    size: tuple[int, int] | None = None
    again: bool = False
    pilot: bool = False
    workers: int | None = None


@attrs.frozen
class Measurements:
    """Showings: measured now, known from before, and those that could not be, each with its reason. refreshes: measured now."""

    measured: int
    known: int
    left_out: tuple[str, ...]
    refreshes: int

    def told(self) -> list[str]:
        """In sentences."""
        before = f", {self.known} were measured before" if self.known else ""
        refreshes = f" at {self.refreshes} refreshes, both eyes of each" if self.refreshes else ""
        return [f"{self.measured} showings measured{refreshes}{before}", *(f"left out: {why}" for why in self.left_out)]


def measure_study(
    store: Store, options: MeasureOptions, progress: Progress = lambda done, total: None, say: Say = lambda text: None
) -> Measurements:
    """Every trial that was shown to its end, one after the other; each is in the store when the next begins, so that going on is starting
    again. progress(done, total): in refreshes, about. say: gets a sentence for each.

    Errors: InputError where there is nothing to measure; MachineError for what the machine lacks, and where a session is running. What one
    trace or setting does not allow is told, and the others go on.
    """
    contents = store.contents(pilot=options.pilot)
    showings = [one for one in contents.showings if one.complete and one.trial]
    if not showings:
        raise InputError(f"{store.folder}: no trial that was shown to its end, so there is nothing to measure")
    sessions = {one.id: one for one in contents.sessions}
    bar = _Bar(progress, [one.actual.get("pictures") or 1 for one in showings])
    known, refreshes = 0, []
    left_out: list[str] = []
    for showing in showings:
        session = sessions[showing.session]
        try:
            run = run_options(showing, session, store.traces, options)
            if not options.again and is_known(showing, run):
                known += 1
                continue
            data = _measured(run, bar.within)
        except (InputError, OSError) as error:
            left_out.append(f"{_name(showing, session)}: {error}")
            continue
        finally:
            bar.next()
        store.measured(showing.id, data)
        refreshes.append(data["refreshes"])
        say(f"{_name(showing, session)}: {_told(data)}")
    return Measurements(len(refreshes), known, tuple(left_out), sum(refreshes))


class _Bar:
    """One bar over replays of different lengths. lengths: of each, in about its refreshes."""

    def __init__(self, progress: Progress, lengths: list[int]) -> None:
        self._progress, self._lengths, self._at = progress, lengths, 0
        progress(0, sum(lengths))

    def within(self, done: int, total: int) -> None:
        """Of the present one."""
        before, length = sum(self._lengths[: self._at]), self._lengths[self._at]
        self._progress(before + length * done // max(total, 1), sum(self._lengths))

    def next(self) -> None:
        """It is over, whichever way."""
        self._at += 1
        self._progress(sum(self._lengths[: self._at]), sum(self._lengths))


def run_options(showing: Showing, session: Session, traces: Path, options: MeasureOptions) -> RunOptions:
    """The replay of a showing. Size and rate are those of the display it was shown on, unless asked for otherwise; a headset whose optics
    are not known here is measured through the study's own. The lens plays no part: quality is of what comes before it. Over a link that
    only delays, frames are as old as they really were: a display that shows a picture two refreshes later adds them.

    Errors: InputError where there is no trace, or the warp was chosen by how fast the machine was.
    """
    if not showing.trace or not (traces / showing.trace).is_file():
        raise InputError("its head was not recorded, or the recording is gone")
    live = live_options(showing.settings)
    if live.warp == AUTO:
        raise InputError("warp auto took what the machine had time for, which cannot be repeated")
    shared = {name: getattr(live, name) for name in _SHARED}
    size = options.size or live.size or _size(showing.actual) or load_headset(live.headset).eye_size_px
    aged_ms = showing.actual.get("latency_ms_median") if live.network.is_plain else None
    asked = {
        "latency_ms": live.latency_ms if aged_ms is None else max(live.latency_ms, round(aged_ms, 3)),
        "lens": "none",
        "fused": False,
        "size": size,
        "rate_hz": live.rate_hz or session.facts.get("rate_hz"),
        "trace": str(traces / showing.trace),
        "as_recorded": True,
        "against": "",
        "metrics_every": options.every,
        "workers": options.workers,
        "images": 0,
    }
    return RunOptions(**{**shared, **asked})


def _size(actual: Mapping[str, Any]) -> tuple[int, int] | None:
    return parse_size(actual["size"]) if actual.get("size") else None


def is_known(showing: Showing, run: RunOptions) -> bool:
    """Whether it was measured before as `run` would: figures of other sizes or steps are not put beside one another."""
    return {key: showing.measured.get(key) for key in ("every", "size")} == _how(run)


def _how(run: RunOptions) -> dict[str, Any]:
    assert run.size is not None
    return {"every": run.metrics_every, "size": "x".join(map(str, run.size))}


def _measured(run: RunOptions, progress: Progress) -> dict[str, Any]:
    found = figures(run, progress)
    means = {name: found["quality"][name]["mean"] for name in QUALITY}
    pictures = found["measured"]["psnr_db"]
    return {**means, "refreshes": pictures // 2, **_how(run), "latency_ms": run.latency_ms, "hmdwarp": __version__}


def _name(showing: Showing, session: Session) -> str:
    """By the random word, and by the trial: who measures may be blind too."""
    return f"{session.sub} session {session.number} trial {showing.trial}"


def _told(data: Mapping[str, Any]) -> str:
    figures_ = ", ".join(
        f"{name} {data[name]:.4g}" for name in ("psnr_db", "flip", "flicker") if data[name] is not None
    )
    return f"{data['refreshes']} refreshes, {figures_}"
