"""What a suite takes besides what ships: scenes by others, checked, and recorded sequences."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...options.identity import hash_of_files
from ...pipeline.recorded_source import RecordingSource
from ...sources.sequences.readers import readers
from .cases import source_of
from .options import BenchOptions
from .suites import suites

_FILE = Path(__file__).with_name("further.toml")
# A recording shows no more than was taken, so its guard band is cut off what is shown.
_GUARD = 1.25


@attrs.frozen
class Recipe:
    """A scene that does not ship."""

    get: str
    credit: str
    # In the folder of --also.
    file: str
    # See hash_of_files.
    sha256: str

    def missing(self, folder: Path | None) -> str:
        """Return why it cannot take part, "" if it can."""
        if folder is None or not (folder / self.file).is_file():
            return f"get {self.get}, and name its folder by --also DIR; expected DIR/{self.file}"
        found = hash_of_files(folder / self.file)
        changed = f"{folder / self.file}: SHA-256 {found} with the files that it names; expected {self.sha256}"
        return "" if found == self.sha256 else f"{changed}; get {self.get} again"


def recipes() -> dict[str, Recipe]:
    """Return all recipes by name."""
    return {name: Recipe(**entry) for name, entry in tomllib.loads(_FILE.read_text(encoding="utf-8")).items()}


def further(options: BenchOptions) -> tuple[list[BenchOptions], list[str]]:
    """Return the options of a suite's further parts, one scene or one sequence each.

    And a sentence on each scene that is not there. Errors: as sequences.open.
    """
    if not options.suite:
        return [], []
    found, told = [], []
    for name in suites()[options.suite].recipes:
        recipe = recipes()[name]
        if why := recipe.missing(options.also):
            told.append(f"without {recipe.credit}: {why}")
        else:
            assert options.also is not None
            found.append(attrs.evolve(options, scenes=(str(options.also / recipe.file),)))
    return [*found, *(_recorded(options, folder) for folder in _sequences(options.also))], told


def _sequences(folder: Path | None) -> Iterator[Path]:
    """Yield the folders of recorded frames. Errors: InputError for what is no folder."""
    if folder is None:
        return
    if not folder.is_dir():
        raise InputError(f"--also {folder}: no such folder; expected one of scenes and of recorded sequences")
    for place in sorted(each for each in folder.iterdir() if each.is_dir()):
        if any(reader.fits(place) for reader in readers):
            yield place


def _recorded(options: BenchOptions, folder: Path) -> BenchOptions:
    """Return the options of a bench of a sequence, with at most as many pixels as the suite has."""
    recorded = attrs.evolve(options, frames=folder, recordings=("",), guard=_GUARD)
    source = source_of(recorded, "")
    (wide, high), (w, h) = source.headset.eye_size_px, options.sizes[0]
    scale = min(1.0, math.sqrt(w * h / (wide * high)))
    size = (round(wide * scale), round(high * scale))
    return attrs.evolve(recorded, scenes=(source.scene.name,), sizes=(size,))


def about_sequence(options: BenchOptions) -> dict[str, Any]:
    """Return what bench.json says of a recorded sequence: name, hash and noise floor."""
    assert options.frames is not None
    source = source_of(options, "")
    assert isinstance(source, RecordingSource)
    floor = source.sequence.noise_floor_db
    return {"name": source.scene.name, "sha256": hash_of_files(options.frames), "noise_floor_db": floor}
