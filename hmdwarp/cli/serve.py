"""hmdwarp serve: draw a scene for clients elsewhere."""

from __future__ import annotations

from ..run.options import ServeOptions
from ._options import QUIET, Said, takes
from ._show import sayer


@takes(ServeOptions, QUIET)
def serve(said: Said) -> None:
    """Draw a scene for clients in other processes or on other machines, until Ctrl-C.

    They are 'hmdwarp live --connect', 'hmdwarp replay --connect', and programs that speak
    docs/feed.md.
    """
    from ..run import serve as go

    go(ServeOptions.of(said), sayer(said["quiet"]))
