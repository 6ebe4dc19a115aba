"""Fills: one file each, registered by name; each gives uncovered pixels a plausible colour."""

from ...registry import Registry
from ._base import Fill

fills: Registry[type[Fill]] = Registry(
    "fill",
    __name__,
    modules=dict.fromkeys(("model", "relight"), "model"),
    columns="reads settings=Settings leaves_no_hole=complete source",
)

__all__ = ["Fill", "fills"]
