"""Warp `auto`: quality levels and the governor that keeps a run within its time budget."""

from .governor import Governor
from .levels import QualityLevel, choose, levels_from, settings_of

__all__ = ["Governor", "QualityLevel", "choose", "levels_from", "settings_of"]
