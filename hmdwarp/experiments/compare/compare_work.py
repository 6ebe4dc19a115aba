"""Runs the cases of a comparison, and says which clients each strategy suits."""

from __future__ import annotations

import math
import platform
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...client.capability import lacking
from ...client.classes import Client, load_client
from ...client.plan import Plan
from ...frames import EyeSizes, frame_bytes, video_pixels
from ...report import png_bytes
from ...run.options import RunOptions
from ...run.replay_run import Measured, measured
from ..sweep import KeptCases, Result, SweepCase

Picture = NDArray[np.uint8]
SHOWN, TRUTH = "shown.png", "truth.png"


@attrs.frozen
class ComparePart:
    """What one case runs."""

    run: RunOptions
    # Whom it may suit: names or files.
    clients: tuple[str, ...]


def pictures_of(kept: KeptCases, case: SweepCase) -> tuple[Picture, Picture]:
    """Return what the left eye saw at the first measured instant, and the truth.

    Each is (h, w, 3) sRGB, top row first.
    """
    from PIL import Image

    shown, truth = (np.asarray(Image.open(kept.file(case.identity, name))) for name in (SHOWN, TRUTH))
    return shown, truth


def run_part(case: SweepCase, step: Callable[[float], None]) -> Result:
    """Run one strategy; its pictures are kept beside its row."""
    part: ComparePart = case.what
    result = measured(part.run)
    job = min(result.kept, key=lambda kept: kept.key).job
    pictures = {SHOWN: png_bytes(job.now.shown), TRUTH: png_bytes(job.now.truth)}
    return Result(_row(part.run, result, [load_client(name) for name in part.clients]), pictures)


def _row(run: RunOptions, result: Measured, clients: Sequence[Client]) -> dict[str, Any]:
    """Return one row of compare.json: the keys of summary.json, and what the strategy takes."""
    summary, about = result.summary, (result.plan, result.sizes)
    summary["link"].pop("timeline")
    return {
        **summary,
        "machine": {**summary["machine"], "host": platform.node()},
        "latency_ms": run.total_latency_ms,
        "client_ms": summary["time_ms"]["total"]["median"],
        "server_ms": summary["link"]["response_ms"]["render_ms"] + summary["link"]["response_ms"]["encode_ms"],
        "mbit_s": summary["link"]["mbit_s"],
        "up_mbit_s": summary["link"]["up_mbit_s"],
        "decoded_mpx_s": decoded_mpx_s(summary, *about),
        "start_bytes": start_bytes(summary),
        "client_bytes": client_bytes(summary, *about),
        "unfit": {client.name: unfit(summary, *about, client) for client in clients},
    }


def unfit(summary: Mapping[str, Any], plan: Plan, sizes: EyeSizes, client: Client) -> str:
    """Return why the client cannot do what was measured, "" if it can.

    summary: as summary.json. Its time counts where a GPU measured it: a class's budget is of its
    own machine, and a software renderer's times say nothing about that.
    """
    reasons = [lacking(plan, client)]
    mbit_s = summary["link"]["mbit_s"]
    if mbit_s > client.download_mbit_s:
        reasons.append(f"it takes {mbit_s:.0f} Mbit/s, and the client has {client.download_mbit_s:g}")
    mpx_s = decoded_mpx_s(summary, plan, sizes)
    if summary["link"]["codec"] != "none" and mpx_s > client.decoder_mpx_s:
        reasons.append(f"it takes {mpx_s:.0f} Mpx/s of video, and the client decodes {client.decoder_mpx_s:g}")
    total_ms = summary["time_ms"]["total"]["median"]
    if summary["clock"] == "gpu" and math.isfinite(client.budget_ms) and total_ms > client.budget_ms:
        reasons.append(f"it takes {total_ms:.2f} ms an eye here, and the client has {client.budget_ms:g}")
    return "; ".join(filter(None, reasons))


def decoded_mpx_s(summary: Mapping[str, Any], plan: Plan, sizes: EyeSizes) -> float:
    """Return the million pixels of video that the client decodes in a second.

    A proxy sends a picture at each refresh, however often the server draws.
    """
    drawn_hz = None if "proxy" in summary["link"] else summary["server_rate_hz"]
    rate_hz: float = drawn_hz or summary["rate_hz"]
    return video_pixels(frame_bytes(plan.needs, sizes, set(plan.layers))) * rate_hz * 1e-6


def start_bytes(summary: Mapping[str, Any]) -> int:
    """Return what the client must have got before the first picture, beside the first frame.

    Packed where a model says so. One that has not become a picture counts with all that came.
    """
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
