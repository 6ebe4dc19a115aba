"""What lenses hide of views, for compute shaders: lists of the strips that a grid runs over."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal, Protocol
from weakref import WeakKeyDictionary

import moderngl
import numpy as np
from numpy.typing import NDArray

STRIPS, STRIP = 7, 16  # storage buffer and columns of shaders/lib/rows.glsl
NO_STRIP = 0xFFFF  # beyond every picture: the last work group may have fewer
Size = tuple[int, int]
Fov = Any
Strips = Literal["seen", "hidden", "edge"]
Grid = Literal["rendered", "shown", "panel"]


class HiddenArea(Protocol):
    """What is hidden of a view, as geometry.Hidden has it."""

    def rows(self, fov: Fov, size: Size) -> NDArray[np.int32]: ...

    def seen(self, fov: Fov, size: Size) -> NDArray[np.bool_]: ...


class SeenView(Protocol):
    """A geometry.View."""

    @property
    def fov(self) -> Fov: ...

    @property
    def hidden(self) -> HiddenArea | None: ...


class _Whole:
    """A view of which nothing is hidden, and its hidden area."""

    fov, hidden = None, None

    def rows(self, fov: Fov, size: Size) -> NDArray[np.int32]:
        return np.array([[0, size[1]]] * size[0], np.int32)

    def seen(self, fov: Fov, size: Size) -> NDArray[np.bool_]:
        return np.ones(size[::-1], bool)


WHOLE = _Whole()


class SeenStrips:
    """Whose hidden areas count, and the strips of them, listed once for each size.

    The compensator sets both attributes; passes only say which view their grid is of.
    """

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        # Whether programs that are made now leave out what is hidden, if their grid is of a view.
        self.skips = False
        # The views that count now; nothing is hidden of one that is missing.
        self.views: dict[Grid, SeenView] = {}
        self._made: WeakKeyDictionary[HiddenArea, dict[tuple[object, ...], tuple[moderngl.Buffer, int]]]
        self._made = WeakKeyDictionary()

    @contextmanager
    def skipping(self, skips: bool) -> Iterator[None]:
        """Set `skips` inside the block."""
        before, self.skips = self.skips, skips
        try:
            yield
        finally:
            self.skips = before

    def bind(self, view: SeenView, size: Size, group: int, rows: int, cell: int = 1, of: Strips = "seen") -> int:
        """Bind the list of strips for a program made with HIDES; return its work groups.

        size: in pixels. group: invocations across. rows: as its ROWS. cell: pixels on each axis for
        which it has one invocation, or row of one. of: strips at a seen pixel, with a hidden one,
        or with a hidden one near the outline.
        """
        hidden = view.hidden or WHOLE
        made, key = self._made.setdefault(hidden, {}), (view.fov, size, group, rows, cell, of)
        if key not in made:
            seen = hidden.seen(view.fov, size)
            # Passes read beside the pixels that they write.
            beside = np.pad(seen, 1)
            beside = beside[:-2, 1:-1] | beside[2:, 1:-1] | beside[1:-1, :-2] | beside[1:-1, 2:] | seen
            any_seen, any_hidden = (_any_of(part, STRIP * cell, rows * cell) for part in (beside, ~seen))
            # A pass of other rows writes up to the next of these.
            written = any_seen | np.roll(any_seen, 1, axis=0) | np.roll(any_seen, -1, axis=0)
            lists = {"seen": any_seen, "hidden": any_hidden, "edge": written & any_hidden}
            row, column = np.nonzero(lists[of])
            each = group // STRIP
            count = -(-len(row) // each)
            places = np.full(max(1, count * each), NO_STRIP, np.uint32)
            places[: len(row)] = column | row << 16
            made[key] = self._gl.buffer(places.tobytes()), count
        strips, count = made[key]
        strips.bind_to_storage_buffer(STRIPS)
        return count


def _any_of(chosen: NDArray[np.bool_], wide: int, high: int) -> NDArray[np.bool_]:
    """Return which groups of wide x high pixels have one that is chosen."""
    rows = np.logical_or.reduceat(chosen, np.arange(0, chosen.shape[0], high), axis=0)
    found: NDArray[np.bool_] = np.logical_or.reduceat(rows, np.arange(0, chosen.shape[1], wide), axis=1)
    return found
