"""Named benchmarks: what they set."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from ...base import InputError, unknown_name

# Halves of scenes and heads.
FIT, HELD_OUT = "fit", "held_out"
_FILE = Path(__file__).with_name("suites.toml")


@attrs.frozen
class Suite:
    """A named benchmark."""

    name: str
    version: int
    summary: str
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
        version, summary, own = (entry.pop(key) for key in ("version", "summary", "compare"))
        shared = {name: entry[name] for name in ("scene", "traces", "headset", "samples")} | {"size": entry["size"][0]}
        found[name] = Suite(name, version, summary, entry, shared | own)
    return found


def with_suite(said: Mapping[str, Any], *, compares: bool = False) -> Mapping[str, Any]:
    """Return the set options with those of the suite that they name, if any.

    compares: whether they are those of a comparison.
    Errors: InputError for an unknown suite, and for an option that the suite sets.
    """
    if not said.get("suite"):
        if said.get("also"):
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
