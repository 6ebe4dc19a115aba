"""A short trial of every warp and fill on a run's own frames, so that the run can choose among them."""

from __future__ import annotations

from collections.abc import Callable

from .client.choice import best_within
from .errors import InputError
from .ladder import Ladder, ladder_from_file
from .options import AUTO, RunOptions

Say = Callable[[str], None]


def ladder_for(options: RunOptions, say: Say = lambda text: None) -> Ladder:
    """What warp "auto" chooses from; an empty ladder for any other warp. Errors: InputError if nothing fits the budget."""
    if options.warp != AUTO:
        return Ladder()
    if options.bench is None:
        raise InputError("not yet")
    found = ladder_from_file(options.bench, options)
    best_within(found.rungs, options.budget_ms)
    return found
