"""Options of every run that is a set of cases."""

from __future__ import annotations

import re
from typing import Any

import attrs

from ...errors import InputError
from ...options import Declared, one_of, option

LOCAL = r"local:([1-9]\d{0,2})"
_ADDRESS = r"([a-z]+://[^\s/]+|(?!local:)[^\s/:]+):[1-9]\d*"
EACH, ONE = "each", "one"


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
        """Return the measuring processes of a run: a cluster's workers measure themselves."""
        return 0 if self.cluster and workers is None else workers


@attrs.frozen(kw_only=True)
class KeptOptions(ClusterOptions):
    """How a set of cases is run and kept."""

    heading = "Many cases"
    resume: bool = option(False, "Go on with the run in this folder: only cases that are missing or failed are run.")

    @property
    def in_turn(self) -> bool:
        """Whether one case runs after the other, all on one machine."""
        return False


@attrs.frozen(kw_only=True)
class SweepOptions(KeptOptions):
    """How a set of cases is run that are timed and compared with each other."""

    timing_on: str = option(
        EACH,
        "With --cluster, time cases on each machine that runs them, or all of them on one.",
        metavar="WHICH",
        valid=one_of(EACH, ONE),
        limits="each or one",
    )

    @property
    def in_turn(self) -> bool:
        return self.timing_on == ONE
