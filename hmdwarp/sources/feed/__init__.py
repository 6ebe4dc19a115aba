"""Frames from another process or machine: messages, clocks, and both ends (docs/feed.md)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
