"""Where live pictures go and whose eyes see them: a headset through OpenXR, or a window on the desktop.

The loop knows none of this; live.py knows the protocol in `_base` alone.
"""

from ._base import Closed, Command, Display, DisplayOptions, Lost, Tick

__all__ = ["Closed", "Command", "Display", "DisplayOptions", "Lost", "Tick"]
