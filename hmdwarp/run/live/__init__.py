"""The loop, live: a headset or a window instead of a trace, and whoever looks may change everything while it runs."""

from .options import LiveOptions

__all__ = ["LiveOptions"]
