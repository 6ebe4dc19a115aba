"""Scales: one .toml file each, with its anchors, its direction and where it comes from."""

from ._model import Item, Scale, Score

__all__ = ["Item", "Scale", "Score"]
