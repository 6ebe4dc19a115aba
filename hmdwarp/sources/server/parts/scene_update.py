"""Parts of the scene for a client that draws it, in the order in which it will need them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ....frames.deliveries import Outbox, Update
from ....frames.layers.scene_update import Delivery
from ....scenes import COARSE, FULL, HALF, pieces_of
from ..reach import FIRST_ROUND_TRIP_NS, NEAREST_M, Head, may_be_seen
from . import parts
from ._base import DrawContext, Drawing, Part

if TYPE_CHECKING:
    from ....frames import EyeImage, Frame
    from ....geometry import View
    from ....scenes import Mesh, Scene

Array = NDArray[np.float64]


@parts.register
class SceneUpdate(Part):
    """One sender for each Delivery that frames need."""

    name = "scene_update"
    order = 200

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._head, self._senders = Head(), dict[Delivery, _Sender]()

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        needed: frozenset[Delivery] = drawing.needs.get("scene_update", frozenset())
        if not needed:
            return {}
        self._head.see(views[0], drawing.time_ns)
        updates = {each: self._sender(each).update(views, self._head, drawing.time_ns) for each in sorted(needed)}
        return {"scene_update": updates}

    def _sender(self, delivery: Delivery) -> _Sender:
        if delivery not in self._senders:
            self._senders[delivery] = _Sender(self.context.scene, delivery)
        return self._senders[delivery]

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:
        updates: Mapping[Delivery, Update] = frame.eyes[0].get("scene_update", {})
        for delivery, update in updates.items():
            self._senders[delivery].outbox.heard(update, arrived, heard_ns)

    def has_more(self, now_ns: int) -> bool:
        return any(sender.has_more(now_ns) for sender in self._senders.values())


@attrs.frozen(eq=False)
class _Boxes:
    """Boxes around pieces, relative to the scene's origin: (n, 3) each."""

    centres: Array
    halves: Array


class _Sender:
    """What one Delivery still has to send, and in which order."""

    def __init__(self, scene: Scene, delivery: Delivery) -> None:
        self._budget = delivery.budget
        self._pieces = pieces_of(scene, delivery.share, delivery.texture, lit=delivery.lit)
        self.outbox = Outbox(self._pieces.things)
        numbers = map(self._pieces.number_of_mesh, range(len(self._pieces.meshes)))
        self._bytes = np.array([len(self._pieces.things[number]) for number in numbers], float)
        self._rest = _boxes(self._pieces.meshes)
        # Textures that cross: of the pieces, and of mirrors alone.
        cross = {texture for texture, _ in self._pieces.levels}
        self._of_pieces = cross & {mesh.texture for mesh in self._pieces.meshes}
        self._of_mirrors = sorted(cross - self._of_pieces)
        self._bodies = np.array([mesh.body for mesh in self._pieces.meshes], int)

    def has_more(self, now_ns: int) -> bool:
        """Return whether anything waits to be sent."""
        self.outbox.settle(now_ns)
        return bool(self.outbox.waiting)

    def update(self, views: Sequence[View], head: Head, now_ns: int) -> Update:
        """Return what a frame drawn now brings."""
        order = self._order(views, head, now_ns) if self.has_more(now_ns) else iter(())
        return self.outbox.update(order, self._budget, now_ns)

    def _order(self, views: Sequence[View], head: Head, now_ns: int) -> Iterator[int]:
        """Yield what to send: first what makes a whole picture.

        Then what is visible from any place that the head can reach until it arrives, what covers
        most of the picture for its bytes first, with coarse textures and then sharper ones; then
        the rest. Of what is visible the last texels come after all triangles.
        """
        yield from self._pieces.first
        boxes, origin = self._boxes_at(now_ns), self._pieces.scene.origin_m
        metres, radians = head.reach(self.outbox.round_trip_ns or FIRST_ROUND_TRIP_NS)
        seen = np.any(
            [may_be_seen(boxes.centres, boxes.halves, view, origin, metres, radians) for view in views], axis=0
        )
        eye = np.mean([view.pose.position_m for view in views], axis=0) - origin
        away = np.linalg.norm(np.maximum(np.abs(boxes.centres - eye) - boxes.halves, 0), axis=1)
        looks = np.minimum(np.linalg.norm(boxes.halves, axis=1) / np.maximum(away - metres, NEAREST_M), 1.0)
        by_size = np.argsort(-(looks**2) / self._bytes, kind="stable")
        shown, rest = by_size[seen[by_size]].tolist(), by_size[~seen[by_size]].tolist()
        steps = [(shown, COARSE), (shown, HALF), (rest, COARSE), (shown, FULL), (rest, HALF), (rest, FULL)]
        for group, scale in steps:
            yield from self._with_textures(group, scale)
            if group is shown:
                yield from (self._pieces.number_of_level(texture, scale) for texture in self._of_mirrors)

    def _with_textures(self, indices: Sequence[int], scale: float) -> Iterator[int]:
        """Yield the meshes, and the texture of each where it first occurs."""
        left = set(self._of_pieces)
        for index in indices:
            yield self._pieces.number_of_mesh(index)
            texture = self._pieces.meshes[index].texture
            if texture in left:
                left.remove(texture)
                yield self._pieces.number_of_level(texture, scale)

    def _boxes_at(self, time_ns: int) -> _Boxes:
        """Return the boxes at that instant; those of bodies hold them however they are turned."""
        centres, halves = self._rest.centres.copy(), self._rest.halves.copy()
        scene = self._pieces.scene
        for number in set(self._bodies.tolist()) - {0}:
            world_from_body = scene.bodies[number - 1].motion.state(time_ns).pose.matrix()
            own = self._bodies == number
            centres[own] = centres[own] @ world_from_body[:3, :3].T + world_from_body[:3, 3] - scene.origin_m
            halves[own] = np.linalg.norm(halves[own], axis=1, keepdims=True)
        return _Boxes(centres, halves)


def _boxes(meshes: Sequence[Mesh]) -> _Boxes:
    low, high = (
        np.array([extreme(mesh.positions, axis=0) for mesh in meshes], np.float64).reshape(-1, 3)
        for extreme in (np.min, np.max)
    )
    return _Boxes((low + high) / 2, (high - low) / 2)
