"""Layers that cross piece by piece: what waits to be sent, and what the head may see until then."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import deque
from collections.abc import Mapping
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...frames import EyeImage
from ...geometry import View
from ...scenes import Scene
from .parts import DrawContext, Drawing, Part
from .targets import MOST_SETTINGS, LastUsed
from .visibility import boxes_of, clip_from_eye, eye_from_scene, side_planes, visible

Array = NDArray[np.float64]
FIRST_ROUND_TRIP_NS = 200_000_000  # from sending to the news of the arrival, until the first news says it
FRAMES = 16  # the head's speed is the fastest between two of so many frames
NEAREST_M = 0.1  # an eye that is this near to a piece, or inside, sees all of it


class Sender:
    """The pieces of one layer for one kind of client."""

    book: Any  # what was sent, a frames.layers.Book
    complete = False  # whether nothing waits to be sent

    def has_more(self, now_ns: int) -> bool:
        return not self.complete


Wanted = TypeVar("Wanted")
S = TypeVar("S", bound=Sender)


class Sending(Part, Generic[Wanted, S]):
    """A part with one sender for each variant of its layer that frames need."""

    of_client = True

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._senders: LastUsed[Wanted, S] = LastUsed()

    @abstractmethod
    def make_sender(self, wanted: Wanted) -> S:
        """Return the sender of a variant."""

    def sender(self, wanted: Wanted) -> S:
        return self._senders.made(wanted, lambda: self.make_sender(wanted))

    def needed(self, drawing: Drawing) -> list[Wanted]:
        """Return the variants that a picture needs, in their order; others are kept, but a few."""
        found = sorted(drawing.needs.get(self.name, frozenset()))
        for wanted in found:
            self.sender(wanted)
        self._senders.beyond(max(MOST_SETTINGS, len(found)))
        return found

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye

    def heard(self, carried: Mapping[str, Any], arrived: bool, heard_ns: int) -> None:
        for wanted, update in carried.get(self.name, {}).items():
            if wanted in self._senders:
                self._senders[wanted].book.heard(update, arrived, heard_ns)

    def has_more(self, now_ns: int) -> bool:
        return any(sender.has_more(now_ns) for sender in self._senders.values())


class Head:
    """How fast the head has moved of late."""

    def __init__(self) -> None:
        self._seen: deque[tuple[int, View]] = deque(maxlen=FRAMES)

    def see(self, view: View, now_ns: int) -> None:
        if not self._seen or now_ns > self._seen[-1][0]:
            self._seen.append((now_ns, view))

    def reach(self, within_ns: int) -> tuple[float, float]:
        """Return metres and radians that it may move by within that time."""
        metres = radians = 0.0
        for (before_ns, before), (now_ns, now) in zip(self._seen, list(self._seen)[1:], strict=False):
            times = within_ns / (now_ns - before_ns)
            metres = max(metres, times * float(np.linalg.norm(now.pose.position_m - before.pose.position_m)))
            turned = before.pose.angle_to(now.pose)
            radians = max(radians, min(times * turned, math.pi))
        return metres, radians


def may_be_seen(
    centres: Array, halves: Array, view: View, origin_m: Array, metres: float, radians: float
) -> NDArray[np.bool_]:
    """Return which boxes an eye may see that moves and turns so far; relative to `origin_m`."""
    clip = clip_from_eye(view.fov)
    steep = np.linalg.norm(side_planes(clip)[:, :3], axis=1)
    reach = np.linalg.norm(centres - (view.pose.position_m - origin_m), axis=1)
    reach += np.linalg.norm(halves, axis=1)
    slack = steep[:, None] * (radians * reach + metres)
    return visible(boxes_of(centres, halves), clip @ eye_from_scene(view, origin_m), slack)


def boxes_at(
    scene: Scene, bodies: NDArray[np.int64], centres: Array, halves: Array, time_ns: int
) -> tuple[Array, Array]:
    """Return centres and halves (n, 3) at an instant; bodies' from their axes, however turned."""
    centres, halves = centres.copy(), halves.copy()
    for number in set(bodies.tolist()) - {0}:
        world_from_body = scene.bodies[number - 1].motion.state(time_ns).pose.matrix()
        own = bodies == number
        centres[own] = centres[own] @ world_from_body[:3, :3].T + world_from_body[:3, 3] - scene.origin_m
        halves[own] = np.linalg.norm(halves[own], axis=1, keepdims=True)
    return centres, halves


def distances(eye: Array, centres: Array, halves: Array) -> Array:
    """Return (n,) metres from a place to the nearest point of each box."""
    away: Array = np.linalg.norm(np.maximum(np.abs(centres - eye) - halves, 0), axis=1)
    return away
