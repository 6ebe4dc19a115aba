"""For clients that draw the scene: its parts, and the picture less that of a simplified one."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....frames import EyeImage
from ....frames.layers import Outbox, Update
from ....frames.layers.scene_parts import Delivery, Simplified
from ....geometry import View
from ....gpu.textures import COLOUR
from ....scenes import COARSE, FULL, HALF, Scene, partial_scene, pieces_of
from ..sending import FIRST_ROUND_TRIP_NS, NEAREST_M, Head, Sender, Sending, boxes_at, distances, may_be_seen
from ..targets import BYTES_BINDING, MOST_SETTINGS, LastUsed, Renderer, display_bytes
from . import DrawContext, Drawing, Part, parts

Array = NDArray[np.float64]


@parts.register
class SceneUpdate(Sending[Delivery, "_Sender"]):
    """One sender for each Delivery that frames need."""

    name = "scene_update"
    order = 200

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._head = Head()

    def make_sender(self, wanted: Delivery) -> _Sender:
        return _Sender(self.context.scene, wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        needed = self.needed(drawing)
        if not needed:
            return {}
        self._head.see(views[0], drawing.time_ns)
        updates = {each: self.sender(each).update(views, self._head, drawing.time_ns) for each in needed}
        return {"scene_update": updates}


class _Sender(Sender):
    """What one Delivery still has to send, and in which order."""

    def __init__(self, scene: Scene, delivery: Delivery) -> None:
        self._budget = delivery.budget
        self._pieces = pieces_of(scene, delivery.share, delivery.texture, lit=delivery.lit)
        self.book: Outbox = Outbox(self._pieces.things)
        pieces, meshes = self._pieces, self._pieces.meshes
        sizes = [len(pieces.things[pieces.number_of_mesh(index)]) for index in range(len(meshes))]
        self._bytes = np.array(sizes, float)
        extremes = [(mesh.positions.min(axis=0), mesh.positions.max(axis=0)) for mesh in meshes]
        low, high = np.array(extremes, np.float64).reshape(-1, 2, 3).transpose(1, 0, 2)
        self._centres, self._halves = (low + high) / 2, (high - low) / 2
        # Textures that cross: of the pieces, and of mirrors alone.
        cross = {texture for texture, _ in self._pieces.levels}
        self._of_pieces = cross & {mesh.texture for mesh in self._pieces.meshes}
        self._of_mirrors = sorted(cross - self._of_pieces)
        self._bodies = np.array([mesh.body for mesh in self._pieces.meshes], int)

    def has_more(self, now_ns: int) -> bool:
        self.book.settle(now_ns)
        return bool(self.book.waiting)

    def update(self, views: Sequence[View], head: Head, now_ns: int) -> Update:
        order = self._order(views, head, now_ns) if self.has_more(now_ns) else iter(())
        return self.book.update(order, self._budget, now_ns)

    def _order(self, views: Sequence[View], head: Head, now_ns: int) -> Iterator[int]:
        """Yield what to send: first what makes a whole picture."""
        # Then what is visible from wherever the head can be until it arrives, what covers most for
        # its bytes first, coarse textures before sharper ones; then the rest.
        yield from self._pieces.first
        scene, origin = self._pieces.scene, self._pieces.scene.origin_m
        centres, halves = boxes_at(scene, self._bodies, self._centres, self._halves, now_ns)
        metres, radians = head.reach(self.book.round_trip_ns or FIRST_ROUND_TRIP_NS)
        seen = np.any([may_be_seen(centres, halves, view, origin, metres, radians) for view in views], axis=0)
        eye = np.mean([view.pose.position_m for view in views], axis=0) - origin
        away = distances(eye, centres, halves)
        looks = np.minimum(np.linalg.norm(halves, axis=1) / np.maximum(away - metres, NEAREST_M), 1.0)
        by_size = np.argsort(-(looks**2) / self._bytes, kind="stable")
        shown, rest = by_size[seen[by_size]].tolist(), by_size[~seen[by_size]].tolist()
        steps = [(shown, COARSE), (shown, HALF), (rest, COARSE), (shown, FULL), (rest, HALF), (rest, FULL)]
        for group, scale in steps:
            yield from self._with_textures(group, scale)
            if group is shown:
                yield from (self._pieces.number_of_level(texture, scale) for texture in self._of_mirrors)

    def _with_textures(self, indices: Sequence[int], scale: float) -> Iterator[int]:
        left = set(self._of_pieces)
        for index in indices:
            yield self._pieces.number_of_mesh(index)
            texture = self._pieces.meshes[index].texture
            if texture in left:
                left.remove(texture)
                yield self._pieces.number_of_level(texture, scale)


@parts.register
class Difference(Part):
    """Drawn when the picture is complete: the simplified scene for the same view and instant."""

    name = "difference"
    order = 190

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._program = context.gpu.shaders.compute("server/difference.comp")
        self._bytes = display_bytes(context.gpu.gl)
        self._renderers: LastUsed[Simplified, Renderer] = LastUsed()

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needed: frozenset[Simplified] = drawing.needs.get("difference", frozenset())
        if not needed:
            return eye
        made = {}
        for each in sorted(needed):
            target = self.kept("simplified", eye.size)
            self._renderers.made(each, functools.partial(self._renderer_of, each)).draw(
                eye.view, eye.size, target, drawing.time_ns
            )
            made[each] = self.context.acquire(eye.size, COLOUR, depth=False).colour
            self.context.gpu.barrier()
            for unit, texture in enumerate((eye.colour, target.colour)):
                texture.bind_to_image(unit, read=True, write=False)
            made[each].bind_to_image(2, read=False, write=True)
            self._bytes.bind_to_storage_buffer(BYTES_BINDING)
            self._program.uniforms.set(full=0, simplified=1, difference=2, rendered_size=eye.size)
            self._program.run(*eye.size)
            self.context.gpu.barrier()
        for unused in self._renderers.beyond(max(MOST_SETTINGS, len(needed))):
            unused.close()
        return eye.having(difference=made)

    def _renderer_of(self, each: Simplified) -> Renderer:
        return self.context.renderer(partial_scene(self.context.scene, each.share, each.texture, lit=each.lit))

    def close(self) -> None:
        for renderer in self._renderers.values():
            renderer.close()
        self._bytes.release()
        super().close()
