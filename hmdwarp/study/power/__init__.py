"""How many people a planned effect needs, by simulation of the whole study and its analysis."""

from .shares import Share, people_for, share_of
from .simulation import Power, Strength, power_of

__all__ = ["Power", "Share", "Strength", "people_for", "power_of", "share_of"]
