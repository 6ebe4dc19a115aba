"""Where the experimenter sits: what is told there, and what may be asked for from there."""

from ._base import Desk, DeskState, Question
from .make import KINDS, make_desk

__all__ = ["KINDS", "Desk", "DeskState", "Question", "make_desk"]
