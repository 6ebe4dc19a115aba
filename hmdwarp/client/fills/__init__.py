"""Fills, registered by name; each gives uncovered pixels a plausible colour."""

from ..settings import DescribedRegistry
from ._base import Fill

fills: DescribedRegistry[type[Fill]] = DescribedRegistry(
    "fill",
    __name__,
    modules={
        **dict.fromkeys(("model", "relight", "composite"), "model"),
        **dict.fromkeys(("none", "constant", "interpolate", "stretch"), "plain"),
        **dict.fromkeys(("memory", "wide"), "memory"),
    },
    columns="reads settings=Settings leaves_no_hole=complete source",
)

__all__ = ["Fill", "fills"]
