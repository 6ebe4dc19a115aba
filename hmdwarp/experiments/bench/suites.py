"""Named benchmarks: what they set, and what they cost."""

from __future__ import annotations

import functools
import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ... import metrics
from ...errors import InputError, unknown_name

# Halves of scenes and heads.
FIT, HELD_OUT = "fit", "held_out"
_FILE = Path(__file__).with_name("suites.toml")
# FLIP and SSIM of a 1280x800 picture take 0.6 s of a core; drawing and warping for 30 pictures of
# 480x300, two instants of a case of `standard`, 8 to 13 s without a GPU.
_S_PER_PIXEL, _DRAWN_S_PER_PIXEL = 0.6 / (1280 * 800), 10 / (30 * 480 * 300)
# A comparison draws, codes and warps every refresh: 72 runs of 64 pictures of 640x400 took 14 min.
_S_PER_RUN, _RUN_S_PER_PIXEL = 2.5, 9 / (64 * 640 * 400)


@attrs.frozen
class Suite:
    """A named benchmark."""

    name: str
    version: int
    summary: str
    # Names of the scenes by others that it takes where they are: see further.toml.
    recipes: tuple[str, ...]
    # Values by option, as the command line has them: of a bench, and of a comparison, where `scene`
    # and `links` may have several.
    sets: Mapping[str, Any]
    compare: Mapping[str, Any]


def _entries() -> dict[str, Any]:
    return tomllib.loads(_FILE.read_text(encoding="utf-8"))


@functools.cache
def halves() -> dict[str, dict[str, list[str]]]:
    """Return `scenes` and `heads` of the half that parameters are fitted on, and of the other."""
    found: dict[str, dict[str, list[str]]] = _entries()["halves"]
    return found


def half_of(head: str, scene: str) -> str:
    """Return the half that a case belongs to; "" for one of both, or of neither."""
    return next((name for name, half in halves().items() if head in half["heads"] and scene in half["scenes"]), "")


def suites() -> dict[str, Suite]:
    """Return all suites by name."""
    entries = _entries()
    del entries["halves"]
    found = {}
    for name, entry in entries.items():
        version, summary, recipes, own = (entry.pop(key) for key in ("version", "summary", "recipes", "compare"))
        shared = {name: entry[name] for name in ("scene", "traces", "headset", "samples")} | {"size": entry["size"][0]}
        found[name] = Suite(name, version, summary, tuple(recipes), entry, shared | own)
    return found


def with_suite(said: Mapping[str, Any], *, compares: bool = False) -> Mapping[str, Any]:
    """Return the set options with those of the suite that they name, if any.

    compares: whether they are those of a comparison.
    Errors: InputError for an unknown suite, and for an option that the suite sets.
    """
    if not said.get("suite"):
        if said.get("also") is not None:
            raise InputError("--also without --suite: give scenes by --scene and recorded frames by --frames")
        return said
    if said["suite"] not in suites():
        raise unknown_name("suite", said["suite"], list(suites()))
    suite = suites()[said["suite"]]
    sets = suite.compare if compares else suite.sets
    for name in (*sets, "frames", "trace", *(sets["links"][-1] if compares else ())):
        if said.get(name) not in (None, [], ()):
            flag = "a trace" if name in ("traces", "trace") else f"--{name.replace('_', '-')}"
            raise InputError(f"{flag} with --suite {suite.name}: the suite says what is run; leave one of them out")
    return {**said, **{name: value for name, value in sets.items() if not compares or name not in ("scene", "links")}}


def cost_text(
    name: str,
    sizes: Sequence[tuple[int, int]],
    pictures: Sequence[int],
    workers: int | None,
    drawn: Sequence[int] | None = None,
) -> str:
    """Return what a suite will cost, in one sentence.

    sizes, pictures: (w, h) and the number of measured pictures of each case. drawn: of those that
    are drawn and shown, for runs.
    """
    suite, count = suites()[name], max(metrics.worker_count(workers), 1)
    pixels = sum(w * h * n for (w, h), n in zip(sizes, pictures, strict=True))
    drawn_s = pixels * _DRAWN_S_PER_PIXEL
    if drawn is not None:
        drawn_s = sum(_S_PER_RUN + w * h * n * _RUN_S_PER_PIXEL for (w, h), n in zip(sizes, drawn, strict=True))
    return (
        f"suite {name} {suite.version}: {len(sizes)} cases, {sum(pictures)} pictures to measure, about "
        f"{math.ceil(pixels * _S_PER_PIXEL / count / 60)} min for the metrics in {count} threads; without a GPU "
        f"drawing and warping take about {math.ceil(drawn_s / 60)} min of one core more"
    )
