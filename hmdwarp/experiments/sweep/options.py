"""Options of every run that is a set of cases."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import attrs

from ...base import Declared, InputError, force_field, group, option, option_of, same_as
from ...poses import TraceOptions
from ...run.options import RunOptions, recordings_field
from ...scenes import SceneOptions
from ...sources.sequences.options import SequenceOptions

LOCAL = r"local:([1-9][0-9]{0,2})"
_ADDRESS = r"([a-z]+://[^\s/]+|(?!local:)[^\s/:]+):[1-9][0-9]*"
# In place of a recording: the head of the camera whose frames are used.
_OWN_HEAD = ""
_OF_EVERY_RUN = (
    *("scene_options", "sequence_options", "trace_options", "samples", "client_motion", "input"),
    *("headset", "rate_hz", "seconds"),
)
_RUN = attrs.fields(RunOptions)


def _check(instance: Any, field: attrs.Attribute[Any], value: str | None) -> None:
    if value is not None and not re.fullmatch(f"{LOCAL}|{_ADDRESS}", value):
        raise InputError(f"--cluster {value}: expected local:N, or the address of a Dask scheduler, HOST:PORT")


@attrs.frozen(kw_only=True)
class ClusterOptions(Declared):
    """Where a set of cases is run. Errors: InputError for an address that cannot be one."""

    cluster: str | None = option(
        None,
        "Run the cases on a Dask cluster: local:N for N processes here, or the address of a scheduler.",
        metavar="WHERE",
        valid=_check,
    )

    def measuring(self, workers: int | None) -> int | None:
        """Return the measuring threads of a run: a cluster's workers measure themselves."""
        return 0 if self.cluster and workers is None else workers


@attrs.frozen(kw_only=True)
class KeptOptions(ClusterOptions):
    """How a set of cases is run and kept."""

    heading = "Many cases"
    resume: bool = option(False, "Continue the run in this folder: run only the missing and failed cases.")


def own_first(kind: type, fields: Sequence[attrs.Attribute[Any]]) -> list[attrs.Attribute[Any]]:
    """Return a class's fields in the order of its help: its own, then those that it inherits."""
    return sorted(fields, key=lambda field: field.name not in kind.__annotations__)


@attrs.frozen(kw_only=True, field_transformer=own_first)
class ExperimentOptions(Declared):
    """Options of an experiment: a set of cases, and the folder of what they gave."""

    out: Path
    force: bool = force_field()
    sweep: KeptOptions = group(KeptOptions)
    command: str = ""


@attrs.frozen(kw_only=True, field_transformer=own_first)
class RecordedOptions(ExperimentOptions):
    """Options of an experiment on recorded heads, in scenes or on recorded frames."""

    # Fields that recorded frames decide, and why, as a message says it.
    with_frames: ClassVar[tuple[str, ...]] = ()
    why_not: ClassVar[str] = ""

    recordings: tuple[str, ...] = recordings_field()
    scene_options: SceneOptions = group(SceneOptions)
    frames: Path | None = same_as(_RUN.frames)
    sequence_options: SequenceOptions = group(SequenceOptions)
    headset: str = same_as(_RUN.headset)
    rate_hz: float | None = same_as(_RUN.rate_hz)
    start_s: float = same_as(_RUN.start_s)
    seconds: float | None = same_as(_RUN.seconds)
    samples: int = same_as(_RUN.samples)
    client_motion: str = same_as(_RUN.client_motion)
    input: str = same_as(_RUN.input)
    workers: int | None = same_as(_RUN.workers)
    trace_options: TraceOptions = group(TraceOptions)

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that were set. Errors: InputError for one that frames decide."""
        values = super().values_of(said)
        if values.get("frames") is None:
            return values
        taken = (*cls.with_frames, "samples")
        for decided in (option_of(field) for field in attrs.fields(cls) if field.name in taken):
            if said.get(decided.name) not in (None, decided.default):
                raise InputError(f"{decided.flag} with --frames: {cls.why_not}; leave it out")
        return {**values, "recordings": (_OWN_HEAD,)}

    def of_run(self, *names: str) -> dict[str, Any]:
        """Return the fields that each run takes as they are; names: further ones."""
        return {name: getattr(self, name) for name in (*_OF_EVERY_RUN, *names)}
