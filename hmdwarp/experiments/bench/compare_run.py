"""Every strategy on the same heads, over the same link, by the same measures."""

from __future__ import annotations

import functools
import itertools
import math
import platform
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import PAPER, InputError, PlanError
from ...client import Plan
from ...client.capability import lacking
from ...client.classes import Client, load_client
from ...client.strategies import options_of_strategy, strategies
from ...frames import EyeSizes, frame_bytes, video_pixels
from ...link import LinkOptions
from ...link.codec import codecs
from ...metrics import MeasuringThreads, at_instants
from ...pipeline import build_plan_for, source_of
from ...report import png_bytes, write_paper
from ...report.bench.rows import first_cases
from ...report.compare_page import COLUMNS, OF_COMPARE, OF_NOTEBOOK, compare_page
from ...run import RunOptions
from ...run.replay_run import Measured, NothingShown, measured
from ...run.run import first_shown_s, schedule_for
from ..sweep import MOST_SHOWN, ExperimentResult, KeptCases, Result, SweepCase, experiment, with_threads
from .bench_run import flat
from .cases import heads_of
from .options import CompareOptions
from .suite_means import MEASURES, compared_entry
from .suites import suites

_DUPLICATE = (
    "nothing in '{scene}' calls for it, so that it would do what '{alike}' does; name it by --strategy to run it"
)
Progress = Callable[[int, int], None]

PAGE, TABLE, DATA = "compare.html", "compare.csv", "compare.json"
FILES = (PAGE, TABLE, *PAPER, DATA)


def compare(
    options: CompareOptions,
    progress: Progress = lambda done, total: None,
    say: Callable[[str], None] = lambda text: None,
) -> ExperimentResult:
    """Run every strategy on every recording at every latency, and write options.out.

    Each run is a case; those of a recording and latency, which are compared, run on one machine.

    Parameters
    ----------
    options
        All of them are checked before anything runs.
    progress
        Called with (done, total) runs.
    say
        Called with a sentence for the user.

    Returns
    -------
    ExperimentResult
        The content of compare.json, and the runs that failed.

    Raises
    ------
    InputError
        For wrong options; the error of the run where none of several was done.
    MachineError
        For what the machine lacks.
    """
    options = CompareOptions.checked(options)
    clients = [load_client(name) for name in options.clients]
    runs, left_out = list[RunOptions](), list[dict[str, str]]()
    for scene in options.scenes:
        own, left = _checked(attrs.evolve(options, scene=scene))
        runs, left_out = runs + own, left_out + left
    cases = [_case(run, options.clients) for run in runs]
    if options.suite:
        minutes = sum(run.seconds or 0 for run in runs) / 60
        version = suites()[options.suite].version
        say(f"suite {options.suite} {version}: {len(runs)} runs, {minutes:.1f} min of motion are drawn, sent and shown")

    work = functools.partial(with_threads, _run_part, options.sweep.measuring(options.workers))
    with experiment(options, FILES, work, cases, progress, say) as (out, swept, described):
        rows = swept.rows(lambda row: (row,))
        failed = [{"strategy": failure.name, "why": f"failed: {failure.why}"} for failure in swept.failed]
        about = []
        for name in dict.fromkeys(row["strategy"] for row in rows):
            strategy = strategies.get(name.partition(":")[0])
            facts = {key: getattr(strategy, key) for key in ("summary", "crosses", "client", "late", "source")}
            about.append({"name": name, **facts, "classes": [f"class-{number}" for number in strategy.classes]})
        data = described(
            {
                **{key: rows[0][key] for key in ("machine", "clock")},
                "clients": [{"name": client.name, "summary": client.summary} for client in clients],
                "strategies": about,
                "left_out": [*left_out, *failed],
                **compared_entry(options.suite, rows),
                "rows": rows,
            }
        )
        pictures = [functools.partial(pictures_of, swept.kept, case) for case in swept.done]
        first, count = first_cases(data["rows"], MOST_SHOWN, OF_COMPARE)
        page = compare_page({**data, "rows": [*first.values()], "cases": count}, [pictures[at] for at in first])
        out.write_csv(TABLE, flat(data["rows"], COLUMNS), list(COLUMNS))
        out.write_text(PAGE, page.html())
        write_paper(out, page, options.paper)
        out.write_json(DATA, data)
    return ExperimentResult(options.out, data, options.out / PAGE, swept, columns=OF_NOTEBOOK)


def _case(run: RunOptions, clients: Sequence[str]) -> SweepCase:
    front = ", ".join(filter(None, (run.trace, f"{run.total_latency_ms:g} ms", run.scene, _over_text(run.network))))
    return SweepCase.of("compare", f"{run.strategy}, {front}", _ComparePart(run, tuple(clients)), group=front)


def _over_text(network: LinkOptions) -> str:
    """Return the bandwidth and loss of a link in words, "" without either."""
    rate, loss = network.bandwidth, network.loss
    words = [] if rate is None else [f"{rate.mbit:g} Mbit/s"]
    return ", ".join(words if loss is None else [*words, f"{100 * loss.mean:g} % lost"])


def _checked(options: CompareOptions) -> tuple[list[RunOptions], list[dict[str, str]]]:
    """Return the options of every run, what is left out and why.

    Strategies not named are left out where the scene does not call for them, where they would do
    what another one does, and where recorded frames lack what they send.
    """
    links = options.links
    options = attrs.evolve(options, network=links[0])
    first = _run_options(options, "", options.recordings[0], 0.0, 0.0)
    source = source_of(first)
    scene, headset, left_out, chosen = source.scene, source.headset, [], dict[str, Any]()
    for text in options.strategies or strategies.names():
        options_of_strategy(text)  # no name is none for a run alone, and unknown here
        try:
            run = _run_options(options, text, options.recordings[0], 0.0, 0.0)
            build_plan_for(run, headset, None)
            plan = build_plan_for(run, headset, scene)
            source.check([plan], plan.needs)
        except (PlanError, InputError) as error:
            if options.strategies or not (isinstance(error, PlanError) or options.frames):
                raise
            left_out.append({"strategy": text, "why": str(error)})
            continue
        does = (
            attrs.evolve(run, strategy="", warp="none", fill="none", effects="none"),
            attrs.evolve(plan, steps=(), left_out=()),
        )
        alike = None if options.strategies else next((name for name, same in chosen.items() if same == does), None)
        if alike is None:
            chosen[text] = does
        else:
            left_out.append({"strategy": text, "why": _DUPLICATE.format(scene=scene.name, alike=alike)})
    rate_hz = options.rate_hz or headset.refresh_hz
    # From the same refresh on: that of the longest wait for a first frame.
    over = [attrs.evolve(options, network=link) for link in links]
    late = max(options.latencies_ms)
    latest = [_run_options(one, text, one.recordings[0], late, 0.0) for one in over for text in chosen]
    start_s = max([options.start_s, *(first_shown_s(run, rate_hz) for run in latest)])
    cases = itertools.product(options.recordings, over, options.latencies_ms, chosen)
    runs = [_run_options(one, text, recording, latency, start_s) for recording, one, latency, text in cases]
    traces = heads_of(options, source)
    for run in runs:
        codecs.get(run.coding.codec)
        schedule_for(run, source, traces[run.trace], rate_hz)
    return runs, left_out


def _run_options(options: CompareOptions, text: str, recording: str, latency_ms: float, start_s: float) -> RunOptions:
    """Return the options of one run. Errors: as RunOptions.of."""
    by_strategy = RunOptions.of({"strategy": text, "frames": options.frames}, trace=recording)
    return attrs.evolve(
        by_strategy.over(latency_ms, options.network, options.coding),
        **options.of_run("scene", "repair", "fovea_deg", "rim", "metrics_every", "jod_s"),
        size=options.eye_size,
        start_s=start_s,
        lens="none",
        against="",
        workers=options.sweep.measuring(options.workers),
        images=1,
    )


Picture = NDArray[np.uint8]
SHOWN, TRUTH = "shown.png", "truth.png"


@attrs.frozen
class _ComparePart:
    """What one case runs."""

    run: RunOptions
    # Whom it may suit: names or files.
    clients: tuple[str, ...]


def pictures_of(kept: KeptCases, case: SweepCase) -> tuple[Picture, Picture]:
    """Return what the left eye saw at the first measured instant, and the truth: (h, w, 3) sRGB."""
    from PIL import Image

    shown, truth = (np.asarray(Image.open(kept.file(case.identity, name))) for name in (SHOWN, TRUTH))
    return shown, truth


def _run_part(threads: MeasuringThreads, case: SweepCase, step: Callable[[float], None]) -> Result:
    """Run one strategy; its pictures are kept with its row."""
    part: _ComparePart = case.what
    clients = [load_client(name) for name in part.clients]
    try:
        result = measured(part.run, threads=threads)
    except NothingShown as error:  # a result of its own, without pictures
        assert error.result is not None
        return Result(_row(part.run, error.result, clients))
    job = min(result.kept, key=lambda kept: kept.key).job
    return Result(_row(part.run, result, clients), {SHOWN: png_bytes(job.now.shown), TRUTH: png_bytes(job.now.truth)})


def _row(run: RunOptions, result: Measured, clients: Sequence[Client]) -> dict[str, Any]:
    """Return one row of compare.json: the keys of summary.json, and what the strategy takes."""
    summary, about = result.summary, (result.plan, result.sizes)
    answer = summary["link"]["response_ms"]  # None where nothing was shown
    summary["link"].pop("timeline")
    return {
        **summary,
        "machine": {**summary["machine"], "host": platform.node()},
        "latency_ms": run.total_latency_ms,
        "client_motion": run.client_motion,
        "over": _over_text(run.network),
        "at_instants": {
            name: {str(frame): value for frame, value in at_instants(result.rows, name).items()} for name in MEASURES
        },
        "client_ms": summary["time_ms"]["total"]["median"],
        "server_ms": answer and answer["render_ms"] + answer["encode_ms"],
        "mbit_s": summary["link"]["mbit_s"],
        "up_mbit_s": summary["link"]["up_mbit_s"],
        "decoded_mpx_s": decoded_mpx_s(summary, *about),
        "start_bytes": start_bytes(summary),
        "client_bytes": client_bytes(summary, *about),
        "unfit": {client.name: unfit(summary, *about, client) for client in clients},
    }


def unfit(summary: Mapping[str, Any], plan: Plan, sizes: EyeSizes, client: Client) -> str:
    """Return why the client cannot do what was measured, "" if it can; summary: as summary.json."""
    if "nothing" in summary:
        return str(summary["nothing"])
    reasons = [lacking(plan, client)]
    mbit_s = summary["link"]["mbit_s"]
    if mbit_s > client.download_mbit_s:
        reasons.append(f"it takes {mbit_s:.0f} Mbit/s, and the client has {client.download_mbit_s:g}")
    mpx_s = decoded_mpx_s(summary, plan, sizes)
    if summary["link"]["codec"] != "none" and mpx_s > client.decoder_mpx_s:
        reasons.append(f"it takes {mpx_s:.0f} Mpx/s of video, and the client decodes {client.decoder_mpx_s:g}")
    total_ms = summary["time_ms"]["total"]["median"]
    # A class's budget is of its own machine; a software renderer's times say nothing of that.
    if summary["clock"] == "gpu" and math.isfinite(client.budget_ms) and total_ms > client.budget_ms:
        reasons.append(f"it takes {total_ms:.2f} ms an eye here, and the client has {client.budget_ms:g}")
    return "; ".join(filter(None, reasons))


def decoded_mpx_s(summary: Mapping[str, Any], plan: Plan, sizes: EyeSizes) -> float:
    """Return the million pixels of video that the client decodes in a second."""
    # A proxy sends a picture at each refresh, however often the server draws.
    drawn_hz = None if "proxy" in summary["link"] else summary["server_rate_hz"]
    rate_hz: float = drawn_hz or summary["rate_hz"]
    return video_pixels(frame_bytes(plan.needs, sizes, set(plan.layers))) * rate_hz * 1e-6


def start_bytes(summary: Mapping[str, Any]) -> int:
    """Return the bytes that the client needs before the first picture, besides the first frame."""
    # Packed where a model says so; one that has not become a picture counts with all that came.
    return sum(
        int(model.get("first_picture_bytes") or model["arrived_bytes"])
        if "arrived_bytes" in model
        else _held_bytes(model)
        for model in summary.get("client_models", ())
    )


def _held_bytes(model: Mapping[str, Any]) -> int:
    return int(model["geometry_bytes"] + model["texture_bytes"])


def client_bytes(summary: Mapping[str, Any], plan: Plan, sizes: EyeSizes) -> int:
    """Return what the client holds: the frames that it reads, its fills' memory and its models."""
    frames = (1 + plan.needs.others.past) * sum(frame_bytes(plan.needs, sizes, set(plan.layers)).values())
    rendered = sizes.rendered[0] * sizes.rendered[1]
    kept = sum(fill.entry.bytes_kept(rendered, fill.settings) for fill in plan.fills)
    return frames + kept + sum(map(_held_bytes, summary.get("client_models", ())))
