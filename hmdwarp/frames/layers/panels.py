"""Panels: places once, each picture once, and in every frame which of them is shown."""

from __future__ import annotations

import io
import struct
from collections.abc import Container, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import HmdwarpError
from ...geometry import Pose
from ...scenes import MOST_PANELS, Panel, Texture
from . import Delivered, Inbox, Update, bytes_of_part, layers

if TYPE_CHECKING:
    import moderngl


@attrs.frozen(order=True)
class PanelDelivery:
    """Panels that are delivered picture by picture."""

    # Bytes of each frame, at most, beside what says which pictures are shown.
    budget: int = 20_000
    # Of requests that the client makes itself, frame by frame: SHOWING or PICTURES; 0 where the
    # server knows what has arrived.
    asked: int = 0


# Of a request: which picture each panel shows, or those pictures too.
SHOWING, PICTURES = 1, 2
_MOST_BYTES = 1 << 24  # of the pictures of a request
_MOST_SIDE = 8192  # of a picture that came


@layers.register
class Panels(Delivered):
    """An Update for each PanelDelivery. The amount is the frozenset of them.

    Between processes the client asks for pictures until they have come, see PanelRequests.
    """

    name = "panels"
    summary = "text and menus: each picture once, when it is first shown; until it has come, the one before stays"
    drawn_by = "panels"
    apart = laid_over = True
    fed = True
    something = frozenset({PanelDelivery()})

    @classmethod
    def number_of(cls, amount: frozenset[PanelDelivery]) -> int:
        return max(each.asked for each in amount) or PICTURES

    @classmethod
    def amount_of(cls, number: int) -> frozenset[PanelDelivery]:
        if number not in (SHOWING, PICTURES):
            raise ValueError(f"{number}: expected {SHOWING} or {PICTURES}")
        return frozenset({PanelDelivery(_MOST_BYTES if number == PICTURES else 0, number)})

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        if len(pictures) != 1:
            return f"{len(pictures)} parts: expected one"
        try:
            _check(bytes_of_part(pictures[0]))
        except (ArithmeticError, HmdwarpError, LookupError, OSError, SyntaxError, ValueError, struct.error) as error:
            return f"panels that cannot be read ({' '.join(str(error).split())})"
        return ""

    @classmethod
    def made(cls, textures: Sequence[moderngl.Texture], numbers: NDArray[Any] | None) -> Any:
        assert numbers is not None
        return {PanelDelivery(): Update(bytes_of_part(numbers))}


# When a frame was drawn, and how many numbers follow: of each panel, which picture it shows.
_SHOWING = struct.Struct("<qH")
# Thing 0 has one for each panel: place, turn, size; head-locked, occluded; how many pictures.
_PLACE = struct.Struct("<9d2BH")


def things_of(panels: Sequence[Panel]) -> list[bytes]:
    """Return what crosses: the places of all, then their pictures as PNG files."""
    places = b"".join(
        _PLACE.pack(
            *panel.pose.position_m,
            *panel.pose.orientation_xyzw,
            *panel.size_m,
            panel.head_locked,
            panel.occluded,
            len(panel.pictures),
        )
        for panel in panels
    )
    return [places, *(_png(picture.image) for panel in panels for picture in panel.pictures)]


def first_things(panels: Sequence[Panel]) -> list[int]:
    """Return the number of the thing that is each panel's first picture."""
    counts = [len(panel.pictures) for panel in panels]
    return [1 + sum(counts[:index]) for index in range(len(counts))]


def places_in(thing: bytes) -> list[tuple[Panel, int]]:
    """Return the panels without their pictures, and how many each has."""
    return [(_placed(*row), row[-1]) for row in _PLACE.iter_unpack(thing)]


def _placed(*row: Any) -> Panel:
    nothing = Texture("panel", lambda: np.zeros((1, 1, 4), np.uint8), repeat=False)
    return Panel(nothing, Pose(row[:3], row[3:7]), row[7:9], bool(row[9]), bool(row[10]))


def picture_in(thing: bytes) -> NDArray[np.uint8]:
    """Return a picture, (h, w, 3 or 4)."""
    from PIL import Image

    with Image.open(io.BytesIO(thing), formats=["PNG"]) as found:
        if max(found.size) > _MOST_SIDE:
            raise ValueError(f"a picture of {found.width}x{found.height}: expected {_MOST_SIDE} a side at most")
        return np.asarray(found)


def _png(image: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(file, "PNG")
    return file.getvalue()


def _check(content: NDArray[np.uint8]) -> None:
    """Check what another process sent: whole things, which fit. Errors: as of reading them."""
    if not len(content):
        return  # it is in the other eye's part
    _, showing, update = showing_in(content)
    inbox = Inbox()
    things = dict(inbox.take(update))
    if inbox.begun:
        raise ValueError("a part of a picture")
    if not things:
        return
    counts = [count for _, count in places_in(things[0])]
    if len(counts) > MOST_PANELS:
        raise ValueError(f"{len(counts)} panels: expected {MOST_PANELS} at most")
    if len(counts) != len(showing) or not all(shown < count for shown, count in zip(showing, counts, strict=True)):
        raise ValueError(f"{len(showing)} panels that show pictures, of {len(counts)}")
    for number, thing in things.items():
        if number > sum(counts):
            raise ValueError(f"picture {number} of {sum(counts)}")
        if number and picture_in(thing).shape[2:] not in ((3,), (4,)):
            raise ValueError("a picture without colours")


class PanelRequests:
    """The client's side between processes: what it asks for until all that is shown has come."""

    def __init__(self) -> None:
        self._inbox, self._here = Inbox(), set[int]()
        self._first: list[int] = []
        self._lacks = True
        self._asked: int | None = None

    def number(self, request: int, pending: Container[int]) -> int:
        """Return how much to ask for: pictures once, and again only if that has no answer."""
        if not self._lacks or self._asked in pending:
            return SHOWING
        self._asked = request
        return PICTURES

    def take(self, part: NDArray[Any]) -> None:
        """Take note of what came, which fits."""
        _, showing, update = showing_in(bytes_of_part(part))
        for number, thing in self._inbox.take(update):
            self._here.add(number)
            if number == 0:
                counts = [count for _, count in places_in(thing)]
                self._first = [1 + sum(counts[:index]) for index in range(len(counts))]
        shown = {first + each for first, each in zip(self._first, showing, strict=False)}
        self._lacks = len(self._first) != len(showing) or not shown <= self._here


def with_showing(update: Update, time_ns: int, showing: Sequence[int]) -> Update:
    """Return the update with what a frame drawn at that instant says before it."""
    head = _SHOWING.pack(time_ns, len(showing)) + np.array(showing, "<u2").tobytes()
    return attrs.evolve(update, content=np.concatenate([np.frombuffer(head, np.uint8), update.content]))


def showing_in(content: NDArray[np.uint8]) -> tuple[int, list[int], NDArray[np.uint8]]:
    """Return the instant, which picture each panel shows, and the update."""
    time_ns, count = _SHOWING.unpack_from(content.tobytes())
    end = _SHOWING.size + 2 * count
    return time_ns, np.frombuffer(content[_SHOWING.size : end].tobytes(), "<u2").tolist(), content[end:]
