"""hmdwarp record: a head's motion as a trace."""

from __future__ import annotations

from ..run.options import RecordOptions
from ._options import QUIET, Said, takes
from ._show import sayer


@takes(RecordOptions, QUIET)
def record(said: Said) -> None:
    """Record a head while it moves; each pose is on the disk within a second. A window shows the scene."""
    from ..run import record as go

    go(RecordOptions.of(said), sayer(said["quiet"]))
