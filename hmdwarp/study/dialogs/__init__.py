"""Dialogs of the participant, shown as panels: questions, consent, breaks and the menu."""
