"""An experiment of the thesis as data: what it says, what to run, what to compute, and the rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs

from .run_kinds import Figures, PictureRun, Run, StreamRun
from .verdicts import Rule

# The number of a cell from the figures of its runs, in their order; None where it is not known.
Value = Callable[[Sequence[Figures]], float | None]


@attrs.frozen
class Cell:
    """One setting: its place in the table of the experiment, and what is run for it."""

    row: str
    column: str
    runs: tuple[Run, ...]
    # In place of the experiment's own.
    rule: Rule | None = None
    value: Value | None = None


@attrs.frozen(kw_only=True)
class Experiment:
    """One figure, time or claim of the thesis."""

    # For --only.
    name: str
    # Where the thesis has it.
    source: str
    # The claim, as a sentence.
    claim: str
    # The thesis's value or finding.
    thesis: str
    # What `value` is, as a noun.
    measured: str
    value: Value
    rule: Rule
    unit: str = ""
    digits: int = 2
    # Turns the number into `unit`.
    scale: float = 1.0
    cells: tuple[Cell, ...] = ()
    # Runs whose pictures are shown; of a stream the time line of its frames.
    pictures: tuple[PictureRun | StreamRun, ...] = ()
    # What the reader must know; not computed.
    note: str = ""

    def runs(self) -> tuple[Run, ...]:
        """Return all runs, each once."""
        found = [run for cell in self.cells for run in cell.runs]
        return tuple(dict.fromkeys([*found, *self.pictures]))

    def rule_words(self) -> str:
        """Return the rule in words."""
        special = {cell.row: cell.rule for cell in self.cells if cell.rule is not None}
        if special:
            each = "; ".join(f"{row} {rule.words(self.unit, self.scale)}" for row, rule in special.items())
            return f"{self.measured}: {each}"
        return f"{self.measured}: {self.rule.words(self.unit, self.scale)}"
