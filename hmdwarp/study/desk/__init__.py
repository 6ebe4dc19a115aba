"""Where the experimenter sits: what is told there, and what may be asked for from there."""

from ._base import Desk, DeskState, Question

__all__ = ["Desk", "DeskState", "Question"]
