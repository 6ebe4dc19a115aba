"""Readers of recorded sequences: one file for each layout, recognised by its files."""

from ....registry import Registry
from ._base import SequenceReader

readers: Registry[SequenceReader] = Registry("layout", __name__)

__all__ = ["SequenceReader", "readers"]
