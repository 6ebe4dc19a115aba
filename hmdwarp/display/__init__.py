"""Displays: where live pictures go, and whose eyes see them.

OpenXR, a desktop window, or offscreen.

The loop knows none of this; hmdwarp.run knows only the protocol re-exported here.
"""

from ._base import Closed, Command, Display, DisplayOptions, Label, Lost, TextPanel, Tick

__all__ = ["Closed", "Command", "Display", "DisplayOptions", "Label", "Lost", "TextPanel", "Tick"]
