"""Golden pictures: what a test compares its picture with, pixel by pixel.

They notice what no figure was asked about. HMDWARP_GOLDEN=write writes those of the tests that run.
A failure writes the picture, the golden one and their difference, ten times as strong, to the
folder that the message names.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

GOLDEN = Path(__file__).resolve().parent / "golden"
WRITING = os.environ.get("HMDWARP_GOLDEN") == "write"
# Another driver or CPU may round a value to the other grey level, and a place to the other side of
# an edge: of a picture of one pass at most one pixel in 1000.
GREY_LEVELS, MOVED_SHARE = 1, 1 / 1000
BRIGHTEST = 2.0  # what random worlds and their inverse depths go up to


def sheet(*pairs: tuple[NDArray, NDArray | None]) -> NDArray[np.uint8]:
    """Pairs of colour (h, w, 4), linear, and inverse depth (h, w), one below the other.

    Colour on the left; on the right coverage in red, inverse depth in green, which is 0 for none.
    Rows of less than the widest end in black.
    """
    rows = []
    for colour, depth in pairs:
        known = np.zeros(colour.shape[:2]) if depth is None else np.where(depth < 0, 0, depth / BRIGHTEST * 0.9 + 0.1)
        beside = np.dstack([colour[..., 3], known, np.zeros(colour.shape[:2])])
        rows.append(np.concatenate([colour[..., :3] / BRIGHTEST, beside], axis=1)[::-1])
    widest = max(row.shape[1] for row in rows)
    rows = [np.pad(row, ((0, 0), (0, widest - row.shape[1]), (0, 0))) for row in rows]
    return np.rint(255 * np.clip(np.concatenate(rows), 0, 1)).astype(np.uint8)


def difference(found: NDArray[np.uint8], golden: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Absolute, per channel."""
    return np.abs(found.astype(np.int16) - golden).astype(np.uint8)


def assert_golden(name: str, found: NDArray[np.uint8], folder: Path, share: float = MOVED_SHARE) -> None:
    """Compare with golden/NAME.png: at most this share of pixels differ by more than a level."""
    path = GOLDEN / f"{name}.png"
    if WRITING:
        path.parent.mkdir(exist_ok=True)
        Image.fromarray(found).save(path, optimize=True)
        pytest.skip(f"wrote {path.name}; look at it before committing it")
    if not path.exists():
        pytest.fail(f"tests/golden/{name}.png is missing: run this test with HMDWARP_GOLDEN=write, and look at it")
    golden = np.asarray(Image.open(path).convert("RGB"))
    assert found.shape == golden.shape
    apart = difference(found, golden)
    moved = float((apart.max(axis=-1) > GREY_LEVELS).mean())
    if moved > share:
        strong = np.minimum(apart.astype(np.int16) * 10, 255).astype(np.uint8)
        for what, picture in (("found", found), ("golden", golden), ("difference", strong)):
            Image.fromarray(picture).save(folder / f"{path.stem}-{what}.png")
        pytest.fail(f"{moved:.2%} of the pixels differ by more than {GREY_LEVELS} grey level; see {folder}")


def name_of(spec: str) -> str:
    """The file name of `name:key=value,..`."""
    return re.sub("[:=,]", "-", spec)


def names_in(folder: str) -> set[str]:
    """The golden pictures there are."""
    return {path.stem for path in (GOLDEN / folder).glob("*.png")}
