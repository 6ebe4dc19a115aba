"""A picture of how far two frames agree: as stated, and as the answer reads them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..gpu.textures import flip_rows
from ..report import labelled_strip, magma
from .check_answer import Answer
from .frame_reading import Reading
from .overlap import Overlap
from .search import Search
from .stated_frames import Array, Stated

Picture = NDArray[np.uint8]
_WORST = 0.2  # difference of the depths, in their size, that is drawn brightest
_LEAST_SEEN = 0.4  # of a picture that has to be in view from the other place


def mismatch(answer: Answer) -> Picture:
    """Return a strip: two frames, one as seen from the other's place, and what differs."""
    search, best = answer.decision.search, answer.reading
    one, other = _pair(search, best)
    panels = []
    readings = {"as stated": Reading()} if best == Reading() else {"as stated": Reading(), "as found": best}
    for words, reading in readings.items():
        moved, depth = _moved(search.stated, reading, one, other)
        target = _upright(search.stated.frames[one].colour, reading)
        shown = _upright(search.stated.frames[other].colour, reading)
        error = np.abs(moved.astype(int) - target).mean(axis=2) * moved.any(axis=2) / 128
        panels += [
            ("one frame", target),
            ("another", shown),
            (f"that, moved here: {words}", moved),
            ("colour differs", magma(error)),
            ("depth differs", magma(depth)),
        ]
    return labelled_strip(panels, columns=5)


def _pair(search: Search, reading: Reading) -> tuple[int, int]:
    """Return two frames that see much of the same from places far apart."""
    found = search.coarse.residuals(reading)
    seen = found.seen.mean(axis=1)
    rows, columns = search.coarse.row, search.coarse.column
    shift = np.linalg.norm(found.pixel - np.stack([columns, rows], axis=-1), axis=-1)
    moved = np.array([np.median(one[good]) if good.any() else 0 for one, good in zip(shift, found.seen, strict=True)])
    best = int(np.argmax(np.where(seen > _LEAST_SEEN, moved, seen * 1e-3)))
    one, other = search.coarse.pairs[best]
    return int(one), int(other)


def _moved(stated: Stated, reading: Reading, one: int, other: int) -> tuple[Picture, Array]:
    """Return the other frame as seen from the place of one, and how much depth differs."""
    overlap = Overlap(stated, stated.fine, np.array([[one, other]]), None, between=False)
    found = overlap.residuals(reading)
    size = stated.fine.numbers.shape[1:]
    column, row = np.rint(found.pixel[0]).astype(int).T
    moved = _upright(stated.frames[other].colour, reading)[row, column].reshape(*size, 3)
    known = found.seen[0].reshape(size) & ~np.isnan(stated.fine.numbers[one])
    depth = np.nan_to_num(np.abs(found.depth[0]).reshape(size) / _WORST) * known
    moved = np.where(known[..., None], moved, 0).astype(np.uint8)
    return (flip_rows(moved), flip_rows(depth)) if reading.depth_rows_up else (moved, depth)


def _upright(picture: Picture, reading: Reading) -> Picture:
    return flip_rows(picture) if reading.colour_rows_up else picture
