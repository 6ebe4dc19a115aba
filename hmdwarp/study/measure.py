"""Measures the pictures of each trial: replays its head trace against a renderer without latency.

A trial cannot be measured while it runs: the truth is a second picture, and FLIP takes a second.
The replay is the same pipeline with the trial's settings, on the recorded head and instants. It is
even in time where the display was not, and its first picture comes with the first frame, so the
first moments of a trial (its latency) are left out. Of recorded frames the camera's eye is
measured, at the recorded instants of their first time through.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs

from ..base import AUTO, InputError, __version__, parse_size
from ..experiments.sweep import Failure, Result, SweepCase, outcomes, sharing_nothing
from ..headsets import headset_names, load_headset
from ..metrics import QUALITY
from ..pipeline import PipelineOptions
from ..report import counted
from ..run import RunOptions, measured
from ..scenes import inputs_beside
from .design import live_options
from .measure_options import MeasureOptions
from .store import Session, Showing, Store

_SHARED = tuple(field.name for field in attrs.fields(PipelineOptions))
Progress = Callable[[int, int], None]
Say = Callable[[str], None]


@attrs.frozen
class Measurements:
    """Outcome of measuring a study."""

    measured: int  # showings measured now
    known: int  # showings measured before
    left_out: tuple[str, ...]  # showings that could not be measured, each with its reason
    refreshes: int  # measured now
    # Showings whose replay failed, which says nothing of the trial: they can be measured again.
    failed: tuple[Failure, ...] = ()

    def describe(self) -> list[str]:
        """Describe the outcome in sentences."""
        before = f", {self.known} {'was' if self.known == 1 else 'were'} measured before" if self.known else ""
        refreshes = f" at {counted(self.refreshes, 'refresh')}, both eyes of each" if self.refreshes else ""
        measured = f"{counted(self.measured, 'showing')} measured{refreshes}{before}"
        return [measured, *(f"left out: {why}" for why in self.left_out)]


def measure_study(
    store: Store, options: MeasureOptions, progress: Progress = lambda done, total: None, say: Say = lambda text: None
) -> Measurements:
    """Measure every complete trial, one after the other.

    Each is in the store when the next begins: running it again resumes.

    Parameters
    ----------
    store
        Of the study; locked for a moment after each trial.
    options
        Which trials, and how finely.
    progress
        Called with (done, total), in refreshes, roughly.
    say
        Called with a sentence for each trial.

    Returns
    -------
    Measurements
        A trial whose trace or settings do not allow it is left out; one whose replay fails leaves
        the others.

    Raises
    ------
    InputError
        Where there is nothing to measure.
    MachineError
        While a session runs.
    """
    contents = store.contents(pilot=options.pilot)
    showings = [showing for showing in contents.showings if showing.complete and showing.trial]
    if not showings:
        raise InputError(f"{store.folder}: no trial was shown to its end: there is nothing to measure")
    sessions = {session.id: session for session in contents.sessions}
    known, refreshes, cases = 0, [], []
    left_out, failed, of = list[str](), list[Failure](), dict[str, Showing]()
    for showing in showings:
        session = sessions[showing.session]
        try:
            run = run_options(showing, session, store.traces, options)
            how = _how(run)  # other sizes or steps are not comparable
            if not options.again and {key: showing.measured.get(key) for key in how} == how:
                known += 1
                continue
            steps = showing.actual.get("pictures") or 1
            cases.append(SweepCase.of("study measure", _name(showing, session), run, steps=steps))
        except InputError as error:
            left_out.append(f"{_name(showing, session)}: {error}")
            continue
        of[cases[-1].name] = showing
    for case, outcome in outcomes(sharing_nothing(_run), cases, options.where, progress, say):
        if isinstance(outcome, Failure):
            if outcome.exit_status == InputError.exit_status:
                left_out.append(f"{case.name}: {outcome.why}")
            else:
                failed.append(outcome)
            continue
        data = outcome.data
        unrated = data.pop("jod_failure", None)
        store.measured(of[case.name].id, data)
        refreshes.append(data["refreshes"])
        figures = [f"{name} {data[name]:.4g}" for name in ("psnr_db", "flip", "flicker") if data[name] is not None]
        told = f"{counted(data['refreshes'], 'refresh')}, {', '.join(figures)}"
        told += f", {data['jod']:.2f} JOD" if "jod" in data else ""
        say(f"{case.name}: {'; '.join(filter(None, (told, unrated)))}")
    return Measurements(len(refreshes), known, tuple(left_out), sum(refreshes), tuple(failed))


def _run(case: SweepCase, step: Callable[[float], None]) -> Result:
    run = case.what
    found = measured(run, lambda done, total: step(done / max(total, 1))).summary
    rated = {"jod": found["jod"]["mean"]} if "jod" in found else {}
    if "jod_failure" in found:  # not known as rated: the next run tries again
        rated, run = {"jod_failure": found["jod_failure"]}, attrs.evolve(run, jod_s=0.0)
    return Result({
        **{name: found["quality"][name]["mean"] for name in QUALITY},
        **rated,
        "refreshes": found["measured"]["psnr_db"] // run.source_kind.eyes,  # eyes with a truth
        **_how(run),
        "latency_ms": run.latency_ms,
        "hmdwarp": __version__,
    })  # fmt: skip


def run_options(showing: Showing, session: Session, traces: Path, options: MeasureOptions) -> RunOptions:
    """Return the options to replay a showing.

    Size and rate are by default those of the display; a headset with unknown optics is replaced by
    the study's. The lens plays no part: quality is measured before it. Over a link that only
    delays, frames are as old as they really were, with what a slow display added.
    Errors: InputError where there is no trace, or warp auto chose by the machine's speed.
    """
    actual = showing.actual
    shown_on = str(actual.get("headset", "")).partition(":")[0]  # a default of then, where none is set
    live = live_options({**({"headset": shown_on} if shown_on in headset_names() else {}), **showing.settings})
    if not live.source_kind.has_head and (not showing.trace or not (traces / showing.trace).is_file()):
        raise InputError("its head motion was not recorded, or the recording is gone")
    if live.source_kind.has_head and session.facts.get("trace"):
        raise InputError(
            f"its head was that of {session.facts['trace']}: recorded frames are the truth for their camera's own head"
        )
    if live.warp == AUTO:
        raise InputError("warp auto chose by the machine's speed, which cannot be repeated")
    shared = {name: getattr(live, name) for name in _SHARED}
    size = options.size or live.size or (parse_size(actual["size"]) if actual.get("size") else None)
    aged_ms = actual.get("latency_ms_median") if live.network.is_plain else None
    own_head, trace = live.source_kind.has_head, traces / showing.trace  # the truth is what was recorded there
    replayed = {
        "latency_ms": live.latency_ms if aged_ms is None else max(live.latency_ms, round(aged_ms, 3)),
        "lens": "none",
        "fused": False,
        "size": size or load_headset(live.headset).eye_size_px,
        "rate_hz": None if own_head else live.rate_hz or session.facts.get("rate_hz"),
        "trace": "" if own_head else str(trace),
        "as_recorded": not own_head,
        "input": "" if own_head or not (inputs := inputs_beside(trace)).is_file() else str(inputs),
        "against": "",
        "metrics_every": options.every,
        "jod_s": options.jod_s,
        "workers": options.where.measuring(options.workers),
        "images": 0,
    }
    if own_head:
        replayed["seconds"] = showing.actual.get("seconds") or None
    return RunOptions(**{**shared, **replayed})


def _how(run: RunOptions) -> dict[str, Any]:
    """Return what a trial was measured with; one with a rating is known where none is requested."""
    assert run.size is not None
    rated = {"jod_s": run.jod_s} if run.jod_s else {}
    return {"every": run.metrics_every, "size": "x".join(map(str, run.size)), **rated}


def _name(showing: Showing, session: Session) -> str:
    """Name a showing, not its condition: the experimenter may be blind too. Each has its own."""
    again = f" showing {showing.presentation}" if showing.presentation > 1 else ""
    return f"{session.sub} session {session.number} {showing.key.replace('/', ' ')}{again}"
