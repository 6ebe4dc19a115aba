"""The server: draws a scene for two eyes into a Frame.

It knows nothing of lateness, warps or lenses.
"""

from .draw import Server
from .targets import Target, TargetPool

__all__ = ["Server", "Target", "TargetPool"]
