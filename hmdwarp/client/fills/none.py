"""Holes stay black."""

from __future__ import annotations

from ...gpu.textures import Canvas
from . import fills
from ._base import Fill


@fills.register
class NoFill(Fill):
    """Leaves every hole as it is; it is never run, the plan leaves it out."""

    name = "none"
    summary = "holes stay black, so that they can be seen and counted"
    source = "the baseline of every fill"
    is_pass = False

    def prepare(self) -> None:
        """Nothing to prepare."""

    def run(self, warped: Canvas, into: Canvas) -> None:
        raise AssertionError("the plan leaves this fill out")
