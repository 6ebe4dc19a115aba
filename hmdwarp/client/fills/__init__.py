"""Fills: one file each, registered by name; each turns coverage 0 into a guess."""

from ...registry import Registry
from ._base import Fill

fills: Registry[type[Fill]] = Registry("fill", __name__)

__all__ = ["Fill", "fills"]
