"""Poses, views, the map between two views, and depth, in float64: docs/conventions.md."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
