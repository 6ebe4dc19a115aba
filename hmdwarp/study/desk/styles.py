"""Colours of a desk's screen: the terminal's own sixteen, so that they are readable on whatever the user has chosen behind them.

What must be seen has both its colours set; everything else has the terminal's own text colour.
"""

from __future__ import annotations

from prompt_toolkit.styles import Style

ALWAYS = {
    "heading": "reverse", "phase": "bold reverse", "key": "bold", "prompt": "bold", "entered": "reverse bold", "rule": "", "bar": "",
    "note": "bold", "refused": "bold underline", "loud": "bold reverse", "none": "",
}  # fmt: skip
COLOURS = {
    "loud": "bold bg:ansired fg:ansiwhite", "refused": "bold fg:ansired", "bar": "fg:ansigreen", "rule": "fg:ansibrightblack",
    "phase.showing": "bold noreverse bg:ansigreen fg:ansiblack", "phase.paused": "bold noreverse bg:ansiyellow fg:ansiblack",
    "phase.break": "bold noreverse bg:ansiyellow fg:ansiblack", "phase.asking": "bold noreverse bg:ansicyan fg:ansiblack",
    "phase.reading": "bold noreverse bg:ansicyan fg:ansiblack",
}  # fmt: skip


def style(colours: bool) -> Style:
    """colours: False where NO_COLOR is set; bold and reversed text remain."""
    return Style.from_dict({**ALWAYS, **(COLOURS if colours else {})})
