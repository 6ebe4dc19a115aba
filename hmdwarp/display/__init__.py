"""Where live pictures go and whose eyes see them: a headset through OpenXR, a window on the desktop, or nowhere.

The loop knows none of this; live/ knows the protocol in `_base` alone.
"""

from ._base import Closed, Command, Display, DisplayOptions, Label, Lost, TextPanel, Tick

__all__ = ["Closed", "Command", "Display", "DisplayOptions", "Label", "Lost", "TextPanel", "Tick"]
