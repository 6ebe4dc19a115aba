"""The scene on the client while it arrives: pieces as they come, stand-ins until then."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..frames.layers import Inbox
from ..frames.layers.scene_parts import Delivery
from ..geometry import View
from ..scenes import Mesh, Pieces, Scene, pieces_of
from ..sources.server import ArrivingLight, SceneBuffers, Server, Target
from .client_scene import ClientScene, Store, receiver_of
from .drawn_scenes import server_of, weight_of
from .inputs import ShownPicture


@receiver_of("scene_update")
class ArrivingScene(Store):
    """What has arrived so far of the scene that a Delivery describes.

    Until the stand-ins have come there is no picture: every pixel is a hole. From then on each
    piece of a mesh is its stand-in or itself, and each texture as sharp as it has arrived. When all
    is there it is what the server draws, to the last bit. Lamps stand still, as in a scene that is
    there from the start; what is here stops their light.
    """

    def __init__(self, client: ClientScene, wanted: Delivery) -> None:
        super().__init__(client, wanted)
        pieces = pieces_of(client.scene, wanted.share, wanted.texture, lit=wanted.lit)
        self._pieces, self._inbox = pieces, Inbox()
        blank, gpu = pieces.blank(), client.gpu
        self._light: ArrivingLight | None = None
        if pieces.light is not None:
            self._light = ArrivingLight(gpu, blank, pieces.light, pieces.most_blockers)
        self._renderer = server_of(client.server, blank, self._light, changes=True)
        self._first = set(pieces.first)
        self._here: set[int] = set()  # the meshes that have come
        self._scale_of = dict.fromkeys((texture for texture, _ in pieces.levels), 0.0)
        self._places = _places(self._renderer, blank, pieces)
        # Bytes received when the first whole picture was possible; None before.
        self.first_picture_bytes: int | None = None
        # Milliseconds on the CPU: of all that was unpacked and uploaded, and of the worst frame.
        self._unpack_ms = self._worst_ms = 0.0
        self._draw_what_is_here()

    def receive(self, content: NDArray[np.uint8]) -> None:
        started = time.perf_counter_ns()
        self._take(content)
        took_ms = (time.perf_counter_ns() - started) * 1e-6
        self._unpack_ms, self._worst_ms = self._unpack_ms + took_ms, max(self._worst_ms, took_ms)

    def _take(self, content: NDArray[np.uint8]) -> None:
        meshes = False
        for number, thing in self._inbox.take(content):
            self._first.discard(number)
            found = self._pieces.meshes_in(number, thing)
            for index, mesh in found:
                stands_in = number == 0
                self._put(index, mesh, stands_in=stands_in)
                if not stands_in:
                    self._here.add(index)
            meshes = meshes or bool(found)
            if not found and number:
                self._put_level(*self._pieces.level_in(number, thing))
        if meshes:
            self._draw_what_is_here()
        if not self._first and self.first_picture_bytes is None:
            self.first_picture_bytes = self._pieces.start_bytes + self._inbox.bytes

    def _put(self, index: int, mesh: Mesh, *, stands_in: bool) -> None:
        buffers, number = self._places[index, stands_in]
        buffers.put(number, mesh)

    def _put_level(self, texture: int, scale: float, image: NDArray[np.uint8]) -> None:
        if scale <= self._scale_of[texture]:
            return
        self._scale_of[texture] = scale
        self._renderer.textures.put(texture, _enlarged(image, self._pieces.scene.textures[texture].image.shape))

    def _draw_what_is_here(self) -> None:
        drawn: dict[SceneBuffers, list[int]] = {buffers: [] for buffers in self._renderer.surfaces()}
        for (index, stands_in), (buffers, number) in self._places.items():
            if stands_in != (index in self._here):
                drawn[buffers].append(number)
        for buffers, numbers in drawn.items():
            sent = {number for each, number in self._places.values() if each is buffers}
            buffers.draw_only([*numbers, *(set(range(len(buffers.meshes))) - sent)])
        if self._light is not None and 0 not in self._first:
            here = [buffers.meshes[number] for buffers, numbers in drawn.items() for number in numbers]
            self._light.put([*here, *self._pieces.at_start])

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw the whole picture: holes alone before the stand-ins have come."""
        target = Target(into.colour.texture, into.depth)
        if self._first:
            self._renderer.clear(target)
        else:
            self._renderer.draw(view, target.size, target, time_ns)

    def weights(self) -> list[dict[str, Any]]:
        """Return what crossed, in bytes and how much of it is whole, and the times of unpacking."""
        wanted = self.wanted
        weight = {
            "share": wanted.share,
            "texture": wanted.texture,
            "budget": wanted.budget,
            **weight_of(self._pieces.scene),
            "start_up_bytes": self._pieces.start_bytes,
            "first_picture_bytes": self.first_picture_bytes,
            "arrived_bytes": self._pieces.start_bytes + self._inbox.bytes,
            "arrived": self._inbox.whole,
            "things": self._pieces.count,
            "unpack_ms": self._unpack_ms,
            "unpack_worst_ms": self._worst_ms,
        }
        return [weight]

    def close(self) -> None:
        self._renderer.close()
        if self._light is not None:
            self._light.close()


def _places(renderer: Server, blank: Scene, pieces: Pieces) -> dict[tuple[int, bool], tuple[SceneBuffers, int]]:
    """Return where each piece is drawn from, and (True) each stand-in."""
    found = {id(mesh): (buffers, k) for buffers in renderer.surfaces() for k, mesh in enumerate(buffers.meshes)}
    own = iter(blank.meshes)
    places = {}
    index = 0
    for _, parts in pieces.cut:
        for mesh in (next(own) for _ in range(len(parts) or 1)):
            if parts:
                places[index, False] = found[id(mesh)]
                index += 1
    standing = [index for index, mesh in enumerate(pieces.stand_ins) if mesh is not None]
    places |= {(index, True): found[id(mesh)] for index, mesh in zip(standing, own, strict=True)}
    return places


def _enlarged(image: NDArray[np.uint8], shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return the image at that size, (h, w, c), between its texels linear."""
    if image.shape == shape:
        return image
    from PIL import Image

    return np.asarray(Image.fromarray(image).resize((shape[1], shape[0]), Image.Resampling.BILINEAR))
