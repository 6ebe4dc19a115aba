"""Folders of recorded frames that are changed in places, and what is said of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from recorded_folders import taken
from ros_bags import form_of

from hmdwarp.base import InputError
from hmdwarp.poses.assumptions import By
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import Sequence, SequenceOptions


def made(folder: Path, form: str, count: int = 2, **how: Any) -> Path:
    """Write frames in a layout, into a folder whose parent may hold what belongs to it."""
    folder.mkdir(parents=True, exist_ok=True)
    form_of(form).write(folder, taken(count), **how)
    return folder


def edit(path: Path, change: Any) -> None:
    """Change a file: None removes it, text and bytes take its place, a dictionary is what it says.
    A function changes what a JSON or .npz file says, the text of another, or a picture's array."""
    if change is None:
        path.unlink()
    elif isinstance(change, bytes | str):
        path.write_bytes(change.encode() if isinstance(change, str) else change)
    elif path.suffix in (".json", ".npz"):
        data = dict(np.load(path)) if path.suffix == ".npz" else json.loads(path.read_text())
        data.update(change) if isinstance(change, dict) else change(data)
        data = {name: value for name, value in data.items() if value is not None}
        np.savez(path, **data) if path.suffix == ".npz" else path.write_text(json.dumps(data))
    elif path.suffix == ".png":
        pixels = np.array(Image.open(path))
        changed = change(pixels)
        Image.fromarray(pixels if changed is None else changed).save(path)
    else:
        path.write_text(change(path.read_text()))


def edited(folder: Path, form: str, edits: dict[str, Any], count: int = 2) -> Path:
    """Write frames in a layout, and change files of it, by their names or patterns of them."""
    made(folder, form, count)
    for name, change in edits.items():
        for path in sorted(folder.glob(name)) if "*" in name else [folder / name]:
            edit(path, change)
    return folder


def fact(sequence: Sequence, what: str) -> tuple[str, By]:
    """Return what is assumed of that, and who says so."""
    (found,) = [assumption for assumption in sequence.assumptions if assumption.what == what]
    return found.value, found.by


def refused(folder: Path, *words: str, options: SequenceOptions | None = None) -> None:
    """Check that a folder, or a frame of it, is refused in a line with these words."""
    with pytest.raises(InputError) as caught:
        for frame in sequences.open(folder, options).frames:
            frame.read()
    said = str(caught.value)
    assert all(word in said for word in words) and "\n" not in said, said


def blotted(rows: slice, columns: slice, value: float) -> Callable[[np.ndarray], None]:
    """Give a part of a picture one value."""

    def change(pixels: np.ndarray) -> None:
        pixels[rows, columns] = value

    return change
