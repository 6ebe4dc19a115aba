"""Panels: places once, each picture once, and in every frame which of them is shown."""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import HmdwarpError
from ...geometry import Pose
from ...scenes import MOST_PANELS, Panel, Texture
from . import MOST_BUDGET, Delivered, Inbox, Update, between, layers


@attrs.frozen(order=True)
class PanelDelivery:
    """Panels that are delivered picture by picture."""

    # Bytes of each frame, at most, beside what says which pictures are shown.
    budget: int = attrs.field(default=20_000, validator=between(1, MOST_BUDGET))


_MOST_SIDE = 8192  # of a picture that came


@layers.register
class Panels(Delivered):
    """An Update for each PanelDelivery. The amount is the frozenset of them."""

    name = "panels"
    summary = "text and menus: each picture once, when it is first shown; until it has come, the one before stays"
    drawn_by = "panels"
    apart = laid_over = True
    something = frozenset({PanelDelivery()})

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        try:
            for content in pictures:
                _check(content.ravel())
        except UNREADABLE as error:
            return f"panels that cannot be read ({' '.join(str(error).split())})"
        return super().misfit(pictures, numbers)


# What reading bytes raises that are no panels.
UNREADABLE = (ArithmeticError, HmdwarpError, LookupError, OSError, SyntaxError, ValueError, struct.error)
# When a frame was drawn, and how many numbers follow: of each panel, which picture it shows.
_SHOWING = struct.Struct("<qH")
# Thing 0 has one for each panel: place, turn, size; head-locked, occluded; how many pictures.
_PLACE = struct.Struct("<9d2BH")


def things_of(panels: Sequence[Panel]) -> list[bytes]:
    """Return what crosses: the places of all, then their pictures as PNG files."""
    from PIL import Image

    places, pictures = b"", []
    for panel in panels:
        where = (*panel.pose.position_m, *panel.pose.orientation_xyzw, *panel.size_m)
        places += _PLACE.pack(*where, panel.head_locked, panel.occluded, len(panel.pictures))
        for picture in panel.pictures:
            file = io.BytesIO()
            Image.fromarray(np.ascontiguousarray(picture.image)).save(file, "PNG")
            pictures.append(file.getvalue())
    return [places, *pictures]


def first_things(panels: Sequence[Panel]) -> list[int]:
    """Return the number of the thing that is each panel's first picture."""
    counts = [len(panel.pictures) for panel in panels]
    return [1 + sum(counts[:index]) for index in range(len(counts))]


def places_in(thing: bytes) -> list[tuple[Panel, int]]:
    """Return the panels without their pictures, and how many each has."""
    nothing = Texture("panel", lambda: np.zeros((1, 1, 4), np.uint8), repeat=False)
    return [
        (Panel(nothing, Pose(row[:3], row[3:7]), row[7:9], bool(row[9]), bool(row[10])), row[-1])
        for row in _PLACE.iter_unpack(thing)
    ]


def picture_in(thing: bytes) -> NDArray[np.uint8]:
    """Return a picture, (h, w, 3 or 4)."""
    from PIL import Image

    with Image.open(io.BytesIO(thing), formats=["PNG"]) as found:
        if max(found.size) > _MOST_SIDE:
            raise ValueError(f"a picture of {found.width}x{found.height}: expected {_MOST_SIDE} a side at most")
        picture = np.asarray(found)
    if picture.shape[2:] not in ((3,), (4,)):
        raise ValueError("a picture without colours")
    return picture


def _check(content: NDArray[np.uint8]) -> None:
    """Check what another process sent, as far as it is whole. Errors: as of reading it."""
    _, showing, update = showing_in(content)
    for number, thing in Inbox().take(update):
        if number:
            picture_in(thing)
            continue
        counts = [count for _, count in places_in(thing)]
        if len(counts) > MOST_PANELS:
            raise ValueError(f"{len(counts)} panels: expected {MOST_PANELS} at most")
        if len(counts) != len(showing) or not all(shown < count for shown, count in zip(showing, counts, strict=True)):
            raise ValueError(f"{len(showing)} panels that show pictures, of {len(counts)}")


def with_showing(update: Update, time_ns: int, showing: Sequence[int]) -> Update:
    """Return the update with what a frame drawn at that instant says before it."""
    head = _SHOWING.pack(time_ns, len(showing)) + np.array(showing, "<u2").tobytes()
    return attrs.evolve(update, content=np.concatenate([np.frombuffer(head, np.uint8), update.content]))


def showing_in(content: NDArray[np.uint8]) -> tuple[int, list[int], NDArray[np.uint8]]:
    """Return the instant, which picture each panel shows, and the update."""
    time_ns, count = _SHOWING.unpack_from(content.tobytes())
    end = _SHOWING.size + 2 * count
    return time_ns, np.frombuffer(content[_SHOWING.size : end].tobytes(), "<u2").tolist(), content[end:]
