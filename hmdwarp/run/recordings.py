"""The option that names several recordings: as arguments, or each with --trace."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from .. import poses
from ..errors import InputError
from ..options import Option, several
from .options import RunOptions

_TRACE = Option("As an argument; repeat it for several.", list, name="trace", metavar="TRACE")


def recordings_field() -> Any:
    """Return the field; its class passes the set options through with_recordings()."""
    return several(
        attrs.fields(RunOptions).trace,
        ("look-around", "walk"),
        name="traces",
        metavar="TRACE",
        positional=True,
        parse=None,
        beside=(_TRACE,),
    )


def with_recordings(said: Mapping[str, Any]) -> dict[str, Any]:
    """Return the set options, with the recordings of both ways together."""
    return {**said, "traces": [*(said.get("traces") or ()), *(said.get("trace") or ())] or None}


def refuse_traces_of_one_name(traces: Mapping[str, poses.LoadedTrace]) -> None:
    """Raise InputError if two traces have one name. traces: by option."""
    refuse_one_name(
        "recordings", {recording: trace.track.name or trace.path.stem for recording, trace in traces.items()}
    )


def refuse_one_name(kind: str, called: Mapping[str, str]) -> None:
    """Raise InputError if two share a name: rows, tables and charts distinguish cases by it.

    called: name by option.
    """
    found: dict[str, str] = {}
    for asked, name in called.items():
        first = found.setdefault(name, asked)
        if first != asked:
            raise InputError(
                f"{kind} '{first}' and '{asked}' are both called '{name}': leave one out, or rename a file"
            )
