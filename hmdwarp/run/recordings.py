"""The option that names several recordings: as arguments, or each with --trace."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from ..options import Option, several
from .options import RunOptions

_TRACE = Option("As an argument; repeat it for several.", list, name="trace", metavar="TRACE")


def recordings_field() -> Any:
    """Return the field; its class passes what was said through with_recordings()."""
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
    """Return what was said, with the recordings of both ways together."""
    return {**said, "traces": [*(said.get("traces") or ()), *(said.get("trace") or ())] or None}
