"""Holes stay black."""

from __future__ import annotations

from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill


@fills.register
class NoFill(Fill):
    """Leave every hole as it is; the plan leaves this pass out."""

    name = "none"
    summary = "holes stay black, so that they can be seen and counted"
    source = "the baseline of every fill"
    is_pass = False

    def prepare(self) -> None:
        """Do nothing."""

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        raise AssertionError("the plan leaves this fill out")
