"""Options of `hmdwarp thesis`."""

from __future__ import annotations

from pathlib import Path

import attrs

from ...errors import InputError
from ...options import group, option, out_field, same_as
from ...run import RunOptions
from ..sweep.options import ExperimentOptions, KeptOptions, own_first
from .experiment import experiments_named
from .run_kinds import FULL_SIZE

_RUN = attrs.fields(RunOptions)
QUICK_SCALE = 1 / 8
QUICK_SIZE = (160, 100)


def _names(texts: list[str]) -> tuple[str, ...]:
    return tuple(name.strip() for text in texts for name in text.split(","))


@attrs.frozen(kw_only=True, field_transformer=own_first)
class ThesisOptions(ExperimentOptions):
    """Which experiments of the thesis to run again, and how large.

    Errors: UnknownNameError for an unknown experiment; InputError for a size with
    `quick`.
    """

    out: Path = out_field(attrs.NOTHING, "Folder for thesis.html, results.json, results.csv and the folder cases.")
    only: tuple[str, ...] = option(
        (),
        "Only these experiments, by their names on the page; for several, repeat it or use commas.",
        kind=list,
        default=None,
        metavar="NAME,..",
        parse=_names,
    )
    quick: bool = option(
        False, "Small pictures and the middle speed only: a check that everything runs, in two minutes."
    )
    size: tuple[int, int] | None = same_as(
        _RUN.size,
        help=f"Pixels of one eye, by default {FULL_SIZE[0]}x{FULL_SIZE[1]}; streams keep those of the thesis.",
    )
    sweep: KeptOptions = group(KeptOptions)

    def __attrs_post_init__(self) -> None:
        experiments_named(self.only)
        if self.quick and self.size is not None:
            raise InputError(f"size {self.size[0]}x{self.size[1]} beside --quick, which has its own: leave one out")

    @property
    def eye_size(self) -> tuple[int, int]:
        """Pixels of one eye."""
        return self.size or (QUICK_SIZE if self.quick else FULL_SIZE)
