"""Fills: one file each, registered by name; each gives uncovered pixels a plausible colour."""

from ...registry import Registry
from ._base import Fill

fills: Registry[type[Fill]] = Registry("fill", __name__)

__all__ = ["Fill", "fills"]
