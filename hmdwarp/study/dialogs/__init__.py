"""Dialogs of the participant, shown as panels: questions, consent, breaks and the menu."""

from .buttons import CONTROLLERS, KEYS, InputHints, hints_for
from .canvas import PAD, TEXT, WIDTH, width_of, wrapped
from .choice_dialogs import AGAIN, BREAK, CONTINUE, SKIP, STOP, BreakDialog, ConsentDialog, MenuDialog
from .dialog_panels import MessagePanel, QuestionPanel, message_panel, trial_panel
from .question_dialog import QuestionDialog
from .scale_layout import LineLayout, ScaleForm, layout_of
from .study_controls import CONTROLS

__all__ = [
    "AGAIN",
    "BREAK",
    "CONTINUE",
    "CONTROLLERS",
    "CONTROLS",
    "KEYS",
    "PAD",
    "SKIP",
    "STOP",
    "TEXT",
    "WIDTH",
    "BreakDialog",
    "ConsentDialog",
    "InputHints",
    "LineLayout",
    "MenuDialog",
    "MessagePanel",
    "QuestionDialog",
    "QuestionPanel",
    "ScaleForm",
    "hints_for",
    "layout_of",
    "message_panel",
    "trial_panel",
    "width_of",
    "wrapped",
]
