"""Read the frames that are to be checked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..image import read_frame
from .stated import LEFT, RIGHT, StatedFrame

MOST = 24  # frames that are compared
_EVERY_NS = 10**8  # between two of them, where there are more


def read_stated(paths: Sequence[Path]) -> list[StatedFrame]:
    """Return the frames of a folder, of two folders (left and right eye) or of files.

    Of more than MOST, those where the eye moves most. Errors: InputError.
    """
    folders = [path for path in paths if path.is_dir()]
    if not folders:
        return [_frame(path) for path in paths]
    if len(folders) < len(paths) or len(paths) > 2:
        raise InputError(
            f"{' '.join(map(str, paths))}: expected a folder, two folders (the left and the right eye), or files"
        )
    if len(paths) == 1:
        return _of_folder(paths[0], None)
    both = [_of_folder(path, eye) for path, eye in zip(paths, (LEFT, RIGHT), strict=True)]
    return [one for pair in zip(*both, strict=False) for one in pair]


def _of_folder(folder: Path, eye: int | None) -> list[StatedFrame]:
    files = sorted(folder.glob("*.npz"))
    if not files:
        raise InputError(f"{folder}: no .npz file in it")
    return [_frame(path, eye) for path in files[:MOST]]


def _frame(path: Path, eye: int | None = None) -> StatedFrame:
    found = read_frame(path)
    return StatedFrame(path.name, found.colour, np.asarray(found.depth_m, np.float64), found.view, None, eye)
