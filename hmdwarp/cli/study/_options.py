"""Options that several study commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...options import Declared, option, same_as
from ...study import design as designs
from ...study.measure_options import MeasureOptions


def study_field() -> Any:
    """Return the field of a study."""
    about = "The study's .toml file, or the name of a shipped study, such as thesis."
    return option(attrs.NOTHING, about, positional=True, metavar="STUDY", names_files=True)


def store_field() -> Any:
    """Return the field of a study's folder of data."""
    return option(None, "Folder of the study's data; by default STUDY-data beside its file.", kind=Path)


def pilot_field() -> Any:
    """Return the field that chooses pilot sessions."""
    return same_as(attrs.fields(MeasureOptions).pilot)


def simulated_field() -> Any:
    """Return the field that chooses simulated sessions."""
    return option(False, "Simulated sessions instead of those of participants.")


def origin_of(pilot: bool, simulated: bool) -> str:
    """Return whose sessions the options choose: one of store.ORIGINS.

    Errors: InputError for both.
    """
    from ...study.store import PERSON, PILOT, SIMULATED

    if pilot and simulated:
        raise InputError("--pilot and --simulated: their data lie apart and are never mixed: one after the other")
    return PILOT if pilot else SIMULATED if simulated else PERSON


@attrs.frozen
class DataOptions(Declared):
    """Whose data of a study."""

    store: Path | None = store_field()
    pilot: bool = pilot_field()
    simulated: bool = simulated_field()


def store_of(study: str, options: DataOptions) -> tuple[Path, designs.Design | None]:
    """Return folder of data and study; with --store the file of the study may be broken."""
    from ...study.store import store_folder

    origin = origin_of(options.pilot, options.simulated)
    try:
        design = designs.load_design(study, checked=False)
    except InputError:
        if options.store is None:
            raise
        return options.store, None
    return store_folder(design, options.store, origin), design
