"""Every strategy on the same heads, over the same link, by the same measures."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import attrs
from numpy.typing import NDArray

from ..clients import Client, load_client
from ..errors import InputError, PlanError
from ..metrics import QUALITY
from ..pipeline.build import refreshes_of
from ..pipeline.planning import build_plan_for
from ..pipeline.recorded_scene import RecordedScene, headset_of, scene_of
from ..poses import load_trace
from ..report import SCHEMA, OutputFolder
from ..run.host import refuse_one_eye
from ..run.options import RunOptions
from ..run.recorded_frames import ONE_EYE, own_trace
from ..run.replay_run import Measured, measured
from ..run.replay_setup import schedule_for
from ..strategies import strategies
from ..version import __version__
from .fitness import client_bytes, decoded_mpx_s, start_bytes, unfit
from .options import CompareOptions

PAGE, TABLE, DATA = "compare.html", "compare.csv", "compare.json"
Progress = Callable[[int, int], None]

COLUMNS = (
    "trace",
    "scene",
    "latency_ms",
    "strategy",
    "warp",
    "fill",
    *(f"{name}{tail}" for name in QUALITY for tail in ("", "_p95")),
    "client_ms",
    "server_ms",
    "mbit_s",
    "decoded_mpx_s",
    "start_bytes",
    "client_bytes",
    "unfit",
)


@attrs.frozen(eq=False)
class CompareResult:
    """What was found, as in compare.json, and where it lies."""

    folder: Path
    data: dict[str, Any]

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / PAGE


@attrs.frozen(eq=False)
class Pictures:
    """The left eye at the first measured instant: (h, w, 3) sRGB, top row first."""

    shown: NDArray
    truth: NDArray


def compare(options: CompareOptions, progress: Progress = lambda done, total: None) -> CompareResult:
    """Run every strategy on every recording at every latency, and write options.out.

    All that was asked for is checked before anything runs; a comparison that fails or is
    interrupted leaves nothing. progress(done, total): in runs.
    Errors: InputError and its kin for what was asked, MachineError for what the machine lacks.
    """
    started = time.perf_counter()
    clients = [load_client(name) for name in options.clients]
    runs, left_out = _checked(options)
    with OutputFolder(options.out, owned=(PAGE, TABLE), last=DATA, force=options.force) as out:
        rows, pictures = [], []
        for number, run in enumerate(runs):
            progress(number, len(runs))
            result = measured(run)
            rows.append(_row(run, result, clients))
            pictures.append(_pictures(result))
        progress(len(runs), len(runs))
        data = {
            "schema": SCHEMA,
            "hmdwarp": __version__,
            "command": options.command,
            "machine": rows[0]["machine"],
            "clock": rows[0]["clock"],
            "clients": [{"name": client.name, "summary": client.summary} for client in clients],
            "strategies": [_told(name) for name in dict.fromkeys(row["strategy"] for row in rows)],
            "left_out": left_out,
            "rows": rows,
            "seconds": time.perf_counter() - started,
        }
        _write(out, data, pictures)
    return CompareResult(options.out, data)


def _checked(options: CompareOptions) -> tuple[list[RunOptions], list[dict[str, str]]]:
    """Return the options of every run, and which strategies are left out and why.

    Those that nobody named are left out where the scene does not call for them, and where recorded
    frames lack what they send.
    Errors: as build_plan_for and schedule_for.
    """
    first = _run_options(options, "", options.recordings[0], 0.0, 0.0)
    scene = scene_of(first)
    headset, left_out, names = headset_of(first, scene), [], []
    for text in options.strategies or strategies.names():
        try:
            run = _run_options(options, text, options.recordings[0], 0.0, 0.0)
            build_plan_for(run, headset, None)
            plan = build_plan_for(run, headset, scene)
            if run.is_recorded:
                refuse_one_eye(plan.needs, 1, ONE_EYE)
            names.append(text)
        except (PlanError, InputError) as error:
            if options.strategies or not (isinstance(error, PlanError) or options.frames):
                raise
            left_out.append({"strategy": text, "why": str(error)})
    rate_hz = options.rate_hz or headset.refresh_hz
    start_s = max(options.start_s, refreshes_of(max(options.latencies_ms), rate_hz) / rate_hz)
    cases = itertools.product(options.recordings, options.latencies_ms, names)
    runs = [_run_options(options, text, recording, latency, start_s) for recording, latency, text in cases]
    sequence = scene.sequence if isinstance(scene, RecordedScene) else None
    traces = {
        recording: load_trace(recording, options.trace_options) if sequence is None else own_trace(sequence)
        for recording in options.recordings
    }
    for run in runs:
        schedule_for(run, sequence, traces[run.trace], rate_hz)
    return runs, left_out


def _run_options(options: CompareOptions, text: str, recording: str, latency_ms: float, start_s: float) -> RunOptions:
    """Return the options of one run. Errors: as RunOptions.of."""
    by_strategy = RunOptions.of({"strategy": text, "frames": options.frames}, trace=recording)
    # The same way for all: a proxy stands somewhere on it.
    proxy = by_strategy.proxy.within(latency_ms) if by_strategy.proxy.on else by_strategy.proxy
    return attrs.evolve(
        by_strategy,
        scene=options.scene,
        scene_options=options.scene_options,
        sequence_options=options.sequence_options,
        repair=options.repair,
        headset=options.headset,
        size=options.eye_size,
        rate_hz=options.rate_hz,
        start_s=start_s,
        seconds=options.seconds,
        latency_ms=latency_ms - (proxy.latency_ms if proxy.on else 0.0),
        proxy=proxy,
        lens="none",
        network=_with(options.network, by_strategy.network),
        coding=_with(options.coding, by_strategy.coding),
        trace_options=options.trace_options,
        against="",
        metrics_every=options.metrics_every,
        workers=options.workers,
        images=1,
    )


def _with(chosen: Any, by_strategy: Any) -> Any:
    """Return the options of a group, with those that the strategy sets."""
    usual = type(by_strategy)()
    names = [field.name for field in attrs.fields(type(by_strategy))]
    sets = {name: value for name in names if (value := getattr(by_strategy, name)) != getattr(usual, name)}
    return attrs.evolve(chosen, **sets)


def _row(run: RunOptions, result: Measured, clients: Sequence[Client]) -> dict[str, Any]:
    """Return one row of compare.json: the keys of summary.json, and what the strategy takes."""
    summary, about = result.summary, (result.plan, result.sizes)
    summary["link"].pop("timeline")
    return {
        **summary,
        "latency_ms": run.total_latency_ms,
        "client_ms": summary["time_ms"]["total"]["median"],
        "server_ms": summary["link"]["response_ms"]["render_ms"] + summary["link"]["response_ms"]["encode_ms"],
        "mbit_s": summary["link"]["mbit_s"],
        "decoded_mpx_s": decoded_mpx_s(summary, *about),
        "start_bytes": start_bytes(summary),
        "client_bytes": client_bytes(summary, *about),
        "unfit": {client.name: unfit(summary, *about, client) for client in clients},
    }


def _told(text: str) -> dict[str, Any]:
    strategy = strategies.get(text.partition(":")[0])
    return {
        "name": text,
        "summary": strategy.summary,
        "crosses": strategy.crosses,
        "client": strategy.client,
        "late": strategy.late,
        "classes": [f"class-{number}" for number in strategy.classes],
        "source": strategy.source,
    }


def _pictures(result: Measured) -> Pictures:
    job = min(result.kept, key=lambda kept: kept.key).job
    return Pictures(job.now.shown, job.now.truth)


def _write(out: OutputFolder, data: dict[str, Any], pictures: Sequence[Pictures]) -> None:
    from ..report.compare_page import render_compare_page

    out.write_csv(TABLE, _flat(data["rows"]), COLUMNS)
    out.write_text(PAGE, render_compare_page(data, [(one.shown, one.truth) for one in pictures]))
    out.write_json(DATA, data)


def _flat(rows: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    for row in rows:
        plain = {name: row[name] for name in COLUMNS if name in row}
        quality = {
            f"{name}{tail}": row["quality"][name][which]
            for name in QUALITY
            for tail, which in (("", "mean"), ("_p95", "p95"))
        }
        why = "; ".join(f"{client}: {reason}" for client, reason in row["unfit"].items() if reason)
        yield {**plain, **quality, "unfit": why}
