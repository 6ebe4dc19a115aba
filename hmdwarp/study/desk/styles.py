"""Colours of a desk's screen: the terminal's own sixteen, so that they are readable on whatever the user has chosen behind them.

What must be seen has both its colours set; everything else has the terminal's own text colour. Black is never bold: xterm and others draw
bold black as dark grey, which on cyan or yellow cannot be read.
"""

from __future__ import annotations

from prompt_toolkit.styles import Style

ALWAYS = {
    "heading": "reverse", "phase": "bold reverse", "key": "bold", "prompt": "bold", "entered": "reverse bold", "rule": "", "bar": "",
    "rest": "", "note": "bold", "refused": "bold underline", "loud": "bold reverse", "none": "",
}  # fmt: skip
COLOURS = {
    "loud": "bold bg:ansired fg:ansiwhite", "refused": "bold fg:ansired", "bar": "fg:ansigreen", "rule": "fg:ansibrightblack",
    "rest": "fg:ansibrightblack",
    "phase.showing": "nobold noreverse bg:ansigreen fg:ansiblack", "phase.paused": "nobold noreverse bg:ansiyellow fg:ansiblack",
    "phase.break": "nobold noreverse bg:ansiyellow fg:ansiblack", "phase.asking": "nobold noreverse bg:ansicyan fg:ansiblack",
    "phase.reading": "nobold noreverse bg:ansicyan fg:ansiblack", "phase.waiting": "nobold noreverse bg:ansicyan fg:ansiblack",
}  # fmt: skip


def style(colours: bool) -> Style:
    """colours: False where NO_COLOR is set; bold and reversed text remain."""
    return Style.from_dict({**ALWAYS, **(COLOURS if colours else {})})
