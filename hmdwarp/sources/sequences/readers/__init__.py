"""Readers of recorded sequences: a function for each layout, recognised by its files."""

from __future__ import annotations

import math
import os
from pathlib import Path

import attrs

from ....errors import InputError
from ....options import as_path
from ....options.named_files import enter
from ..camera import read_json
from ..options import MASK, SequenceOptions
from ..recorded import Sequence
from ._base import CAMERA, SequenceReader, readers

# Folder of what the right eye saw, in that of the left one.
RIGHT = "right"
_NAMED = 6  # files of a folder that no reader knows


def open(path: str | os.PathLike[str], options: SequenceOptions | None = None) -> Sequence:
    """Return the recorded sequence of a folder, or of a file in it (transforms.json).

    options: overrides facts of the files, or adds missing ones. Pixels are read later, frame by
    frame. Errors: InputError for what no reader knows, for files that are missing or damaged, for
    facts that are missing (intrinsics, depth scale), and for lens distortion, by its name.
    """
    options, place = SequenceOptions.checked(options, optional=True), as_path(path)
    if not place.exists():
        raise InputError(f"{place}: no such file or folder; expected a folder of recorded frames")
    if place.is_dir():
        enter(place)
    if options.layout is not None:
        return _read(readers.get(options.layout), place, options)
    chances = {reader.name: reader.fits(place) for reader in readers}
    best = max(chances, key=lambda name: chances[name])
    if not chances[best]:
        known = ", ".join(readers.names())
        raise InputError(
            f"{place} ({_content(place)}): no layout of recorded frames that is known: expected one of {known}; "
            "'hmdwarp list layouts' says what each holds"
        )
    return _read(readers.get(best), place, options)


def _read(reader: SequenceReader, place: Path, options: SequenceOptions) -> Sequence:
    for name in ("frames_axes", "frames_camera", "frames_topics"):
        if getattr(options, name) is not None and name not in reader.takes:
            known = ", ".join(known.name for known in readers if name in known.takes)
            raise InputError(f"--{name.replace('_', '-')}: layout {reader.name} does not take it; expected {known}")
    path = (place if place.is_dir() else place.parent) / CAMERA
    floor_db = read_json(path).get("noise_floor_db") if path.exists() else None
    if floor_db is not None and (type(floor_db) not in (int, float) or not 0 < floor_db < math.inf):
        raise InputError(f"{path}: noise_floor_db is {floor_db!r}; expected a positive number of dB")
    sequence = attrs.evolve(reader.read(place, options), noise_floor_db=floor_db)
    if (place / RIGHT).is_dir():
        sequence = attrs.evolve(sequence, right=_right(sequence, reader.read(place / RIGHT, options)))
    mask = options.hidden or place / MASK
    if options.hidden or mask.is_file():
        sequence = sequence.masked(mask)
    return sequence.cropped(options.crop).with_no_depth(options.no_depth)


def _right(left: Sequence, right: Sequence) -> Sequence:
    for name, one, other in (
        ("instants", [frame.time_ns for frame in left.frames], [frame.time_ns for frame in right.frames]),
        ("pixels", [left.frames[0].size], [right.frames[0].size]),
    ):
        if one != other:
            raise InputError(f"{right.path}: frames of other {name} than those of {left.path}; expected the same")
    return right


def _content(place: Path) -> str:
    if not place.is_dir():
        return "a file"
    names = sorted(f"{path.name}/" if path.is_dir() else path.name for path in place.iterdir())
    return f"holds {', '.join(names[:_NAMED])}{' ..' if len(names) > _NAMED else ''}" if names else "an empty folder"


__all__ = ["SequenceReader", "open", "readers"]
