"""Asking: questions, texts, breaks and the menu, as a participant sees them over the picture and answers by hand."""

from .asked import Asked
from .card import Card, card, trial_card
from .controls import CONTROLS
from .hints import CONTROLLERS, KEYS, Hints, hints_for
from .menu import AGAIN, BREAK, CONTINUE, SKIP, STOP, Menu
from .question import QuestionPlate
from .reading import Reading
from .resting import Resting

__all__ = [
    "AGAIN",
    "BREAK",
    "CONTINUE",
    "CONTROLLERS",
    "CONTROLS",
    "KEYS",
    "SKIP",
    "STOP",
    "Asked",
    "Card",
    "Hints",
    "Menu",
    "QuestionPlate",
    "Reading",
    "Resting",
    "card",
    "hints_for",
    "trial_card",
]
