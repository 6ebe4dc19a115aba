"""The scene as the client has it and draws it, and what it keeps from frame to frame."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from typing import Any, ClassVar, TypeVar, cast

import moderngl
import numpy as np
from numpy.typing import NDArray

from .. import scenes
from ..frames import Frame
from ..frames.layers import Inbox
from ..frames.layers.scene_parts import Delivery
from ..geometry import View
from ..gpu import Gpu
from ..gpu.textures import SCALAR, Owner, allocate, drawing_into
from ..sources import server as drawing
from .inputs import ShownPicture

Size = tuple[int, int]


class Store(Owner):
    """Something that the client keeps for all passes that ask for the same: on the GPU, or not.

    A strategy declares one next to its warp, effect or fill. Each is made at first use, and closed
    with the client's scene. Which of its kind it is, `wanted` says: an attrs class, a tuple, or
    None where there is one only.
    """

    layer: ClassVar[str] = ""  # The frame layer whose updates it receives, see receiver_of; "" for none.

    def __init__(self, client: ClientScene, wanted: Any) -> None:
        self.client, self.wanted = client, wanted

    def receive(self, content: Any) -> None:
        """Take what a frame brought; frames may come in any order, and more than once."""

    def begin_anew(self) -> None:
        """Forget what has arrived: the sender begins with nothing."""
        self.close()
        type(self).__init__(self, self.client, self.wanted)

    def weights(self) -> list[dict[str, Any]]:
        """Return what it takes in memory and on the link, one dict for each row of the report.

        `share` and `texture` say which model it is of; else the last entry is how many things it
        holds, named for them, and `geometry_bytes` is there.
        """
        return []


StoreT = TypeVar("StoreT", bound=Store)
_receivers: dict[str, type[Store]] = {}


def receiver_of(layer: str) -> Callable[[type[StoreT]], type[StoreT]]:
    """Return a decorator: the class receives the updates of a layer.

    Parameters
    ----------
    layer : str
        Name of a Delivered. Raises ValueError for one that a class receives already.
    """

    def register(kind: type[StoreT]) -> type[StoreT]:
        if layer in _receivers:
            raise ValueError(f"layer '{layer}' is received by {_receivers[layer].__name__} already")
        kind.layer = layer
        _receivers[layer] = kind
        return kind

    return register


class ClientScene:
    """What a client with some of the scene can draw by itself, for any view and instant.

    server: of the same scene; it draws the exact depth, and belongs to the caller. arrived: what
    the server's scene knows of its own motion, where that comes with the frames.
    """

    def __init__(self, server: drawing.Renderer, arrived: scenes.ArrivedState | None = None) -> None:
        self.server, self.gpu, self.scene = server, server.gpu, server.scene
        self._arrived = arrived
        self._stores: dict[tuple[type[Store], Hashable], Store] = {}
        # Of the newest frame that was received: what it built on, and when it was drawn.
        self._newest: tuple[int, int] | None = None

    def store(self, kind: type[StoreT], wanted: Hashable = None) -> StoreT:
        """Return the store of that kind; it is made at first use."""
        key = (kind, wanted)
        if key not in self._stores:
            self._stores[key] = kind(self, wanted)
        return cast("StoreT", self._stores[key])

    def receive(self, frame: Frame) -> None:
        """Hand what a frame brings to the stores; call it with each frame that arrives."""
        if self._arrived is not None:
            self._arrived.take(frame.drawn_ns)
        began, drawn_ns = self._newest or (frame.began, frame.drawn_ns)
        if frame.began != began:  # it does not build on what is here: an older one is late, a newer one begins anew
            if frame.drawn_ns < drawn_ns:
                return
            for store in self._stores.values():
                if store.layer:
                    store.begin_anew()
        self._newest = frame.began, max(drawn_ns, frame.drawn_ns)
        for layer, kind in _receivers.items():
            for wanted, update in frame.eyes[0].carried.get(layer, {}).items():
                self.store(kind, wanted).receive(update.content)

    def weights(self) -> list[dict[str, Any]]:
        """Return the weights of all stores as they were made, first of those that never crossed."""
        found = [weight for store in self._stores.values() for weight in store.weights()]
        return sorted(found, key=lambda weight: "start_up_bytes" in weight)

    def close(self) -> None:
        """Close the stores; the caller closes the server."""
        for store in self._stores.values():
            store.close()
        self._stores.clear()


Light = TypeVar("Light", bound=drawing.Lighting)


class Surfaces(Owner):
    """The surfaces of a scene, drawn by the server's own passes: rgba16f and r32f inverse depth.

    kinds: of light. samples: of each pixel; inverse depth is that of the pixel's centre.
    """

    def __init__(self, gpu: Gpu, scene: scenes.Scene, *kinds: type[drawing.Lighting], samples: int = 1) -> None:
        self.scene, self._gpu = scene, gpu
        self._several = self.own(drawing.Multisampled(gpu, samples)) if samples > 1 else None
        surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
        textures = self.own(drawing.SceneTextures(gpu, scene))
        self._buffers = self.own(drawing.SceneBuffers(gpu, [mesh for mesh in surfaces if mesh.stands_still], textures))
        self._moving = [self.own(part) for part in drawing.moving_parts(gpu, scene, textures)]
        self._framebuffers = self.own(drawing.Framebuffers(gpu.gl))
        self._passes = {kind: self._passes_of(colour=True, light=kind) for kind in kinds}
        self._depth: drawing.ScenePasses | None = None

    def _passes_of(self, **how: Any) -> drawing.ScenePasses:
        return self.own(drawing.ScenePasses(self._gpu, self.scene, self._buffers, moving=self._moving, **how))

    def reserve(self, size: Size) -> None:
        """Allocate what pictures of that size need."""
        self._framebuffers.reserve(size)

    def lighting(self, kind: type[Light]) -> Light | None:
        """Return the light of the passes of that kind; None without lamps."""
        return cast("Light | None", self._passes[kind].lighting)

    def draw(
        self, view: View, into: ShownPicture, time_ns: int, kind: type[drawing.Lighting] = drawing.ConvergedLight
    ) -> None:
        """Draw the whole picture: coverage 1 everywhere, sky included (inverse depth 0).

        What is read as data, not seen, has one sample a pixel: a mean of normals is none.
        """
        if self._several is None or not kind.coloured:
            self._passes[kind].draw(view, self._over(into), time_ns)
            return
        self._several.draw(self._passes[kind], view, into.colour.texture, time_ns)
        if into.inverse_depth is not None:
            if self._depth is None:
                self._depth = self._passes_of(colour=False)
            self._depth.draw(view, self._framebuffers.over(into.inverse_depth), time_ns)

    def _over(self, into: ShownPicture) -> moderngl.Framebuffer:
        depth = (into.inverse_depth,) if into.inverse_depth is not None else ()
        return self._framebuffers.over(into.colour.texture, *depth)


class ReducedModel(Store):
    """Surfaces with a share of the scene's triangles and textures' resolution: (share, texture).

    Errors: SceneError for a share or scale that is not above 0 and at most 1.
    """

    def __init__(self, client: ClientScene, wanted: tuple[float, float]) -> None:
        super().__init__(client, wanted)
        self._scene = scenes.reduced(scenes.with_lamps_stopped(client.scene), wanted[0], texture=wanted[1])
        self._drawn: dict[bool | None, DrawnModel] = {}

    def drawn(self, *, lit: bool) -> DrawnModel:
        """Return the model with baked light, else with light of 1 everywhere (albedo)."""
        if lit not in self._drawn:
            self._drawn[lit] = self.own(DrawnModel(self.client, self._scene if lit else scenes.unlit(self._scene)))
        return self._drawn[lit]

    def shining(self) -> DrawnModel | None:
        """Return the model with what its textures emit alone, black elsewhere; None without any."""
        if None not in self._drawn and (scene := scenes.only_emission(self._scene)) is not None:
            self._drawn[None] = self.own(DrawnModel(self.client, scene))
        return self._drawn.get(None)

    def weights(self) -> list[dict[str, Any]]:
        """Count it once, with light and without: that differs by three numbers a vertex."""
        share, texture = self.wanted
        return [{"share": share, "texture": texture, **weight_of(self._scene)}]


class DrawnModel(Surfaces):
    """A model that can also be drawn into holes alone, then with one sample a pixel."""

    def __init__(self, client: ClientScene, scene: scenes.Scene) -> None:
        super().__init__(client.gpu, scene, drawing.ConvergedLight, samples=client.server.samples)
        gpu, self._gl = client.gpu, client.gpu.gl
        self._cover = gpu.shaders.draw("server/background.vert", "fills/model_cover.frag")
        self._empty = self.own(gpu.gl.vertex_array(self._cover.program, []))
        self._no_depth = self.own(allocate(gpu.gl, (1, 1), SCALAR))

    def draw_holes(self, view: View, picture: ShownPicture, into: ShownPicture, time_ns: int) -> None:
        """Draw into the holes of `picture`; elsewhere copy its colour and inverse depth.

        Covered pixels get the nearest value in the depth buffer, so that only holes are shaded.
        """
        framebuffer, gl = self._over(into), self._gl
        drawing.clear_depth(gl, framebuffer)
        picture.colour.texture.use(0)
        (picture.inverse_depth if picture.inverse_depth is not None else self._no_depth).use(1)
        self._cover.uniforms.set(warped=0, warped_inverse_depth=1)
        with drawing_into(framebuffer, moderngl.DEPTH_TEST):
            self._empty.render(moderngl.TRIANGLES, vertices=3)
        gl.polygon_offset = 0.0, 2.0  # surfaces at the near plane must stay behind covered pixels
        self._passes[drawing.ConvergedLight].draw_into(view, framebuffer, None, time_ns)
        gl.polygon_offset = 0.0, 0.0


class WholeScene(Store):
    """A scene that is drawn with all that is in it: mirrors, glass, overlays.

    wanted: a Simplified of frames.layers.scene_parts: share of the triangles of plain surfaces,
    scale of textures, whether lit. With a share and a scale of 1, lit, it is drawn as the server
    draws it, to the last bit.
    """

    def __init__(self, client: ClientScene, wanted: Any) -> None:
        super().__init__(client, wanted)
        self.scene = scenes.partial_scene(client.scene, wanted.share, wanted.texture, lit=wanted.lit)
        is_own = self.scene is not client.scene
        self._renderer = self.own(server_of(client.server, self.scene)) if is_own else client.server

    def draw(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw the whole picture."""
        target = drawing.Target(into.colour.texture, into.depth)
        self._renderer.draw(view, target.size, target, time_ns)

    def weights(self) -> list[dict[str, Any]]:
        return [whole_weight(self.scene, self.wanted.share, self.wanted.texture)]


def server_of(
    server: drawing.Renderer, scene: scenes.Scene, lighting: drawing.Lighting | None = None, *, changes: bool = False
) -> drawing.Server:
    """Return a server of another scene, which draws as `server` does where that draws.

    changes: whether its textures will.
    """
    if isinstance(server, drawing.Server):
        return server.of_another(scene, lighting, changes=changes)
    return drawing.Server(server.gpu, scene, lighting=lighting, changes=changes)


def weight_of(scene: scenes.Scene) -> dict[str, int]:
    """Return `triangles`, `geometry_bytes` and `texture_bytes` of a scene, uncompressed.

    Vertices are a position, a place on the texture and a light in float32; triangles three 32-bit
    indices; texels 8 bits a channel, without mipmaps, of the textures that some mesh has.
    """
    vertices = sum(len(mesh.positions) for mesh in scene.meshes)
    used = {mesh.texture for mesh in scene.meshes if mesh.texture >= 0}
    return {
        "triangles": scene.triangle_count,
        "geometry_bytes": 4 * (3 + 2 + 3) * vertices + 4 * 3 * scene.triangle_count,
        "texture_bytes": sum(scene.textures[index].image.nbytes for index in used),
    }


def whole_weight(scene: scenes.Scene, share: float = 1.0, texture: float = 1.0) -> dict[str, Any]:
    """Return the weight of a scene that is drawn instead of a picture, with what crosses of it.

    It crosses once, packed: at the start, so until the first whole picture, and in all.
    """
    packed = dict.fromkeys(("start_up_bytes", "first_picture_bytes", "arrived_bytes"), scenes.Pieces(scene).whole_bytes)
    return {"share": share, "texture": texture, **weight_of(scene), **packed}


@receiver_of("scene_update")
class ArrivingScene(Store):
    """What has arrived so far of the scene that a Delivery describes.

    Until the stand-ins have come every pixel is a hole. From then on each piece of a mesh is its
    stand-in or itself, and each texture as sharp as it has arrived; when all is there it is what
    the server draws, to the last bit. Lamps stand still; what is here stops their light.
    """

    def __init__(self, client: ClientScene, wanted: Delivery) -> None:
        super().__init__(client, wanted)
        pieces = scenes.pieces_of(client.scene, wanted.share, wanted.texture, lit=wanted.lit)
        self._pieces, self._inbox = pieces, Inbox()
        blank, gpu = pieces.blank(), client.gpu
        light = pieces.light
        self._light = (
            self.own(drawing.ArrivingLight(gpu, blank, light, pieces.most_blockers)) if light is not None else None
        )
        self._renderer = self.own(server_of(client.server, blank, self._light, changes=True))
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
        started, meshes = time.perf_counter_ns(), False
        for number, thing in self._inbox.take(content):
            self._first.discard(number)
            found = self._pieces.meshes_in(number, thing)
            for index, mesh in found:
                buffers, place = self._places[index, number == 0]
                buffers.put(place, mesh)
                if number:
                    self._here.add(index)
            meshes = meshes or bool(found)
            if not found and number:
                texture, scale, image = self._pieces.level_in(number, thing)
                if scale > self._scale_of[texture]:
                    self._scale_of[texture] = scale
                    high, wide = self._pieces.scene.textures[texture].image.shape[:2]
                    if image.shape[:2] != (high, wide):
                        from PIL import Image

                        resized = Image.fromarray(image).resize((wide, high), Image.Resampling.BILINEAR)
                        image = np.asarray(resized)
                    self._renderer.textures.put(texture, image)
        if meshes:
            self._draw_what_is_here()
        if not self._first and self.first_picture_bytes is None:
            self.first_picture_bytes = self._pieces.start_bytes + self._inbox.bytes
        took_ms = (time.perf_counter_ns() - started) * 1e-6
        self._unpack_ms, self._worst_ms = self._unpack_ms + took_ms, max(self._worst_ms, took_ms)

    def _draw_what_is_here(self) -> None:
        drawn: dict[drawing.SceneBuffers, list[int]] = {buffers: [] for buffers in self._renderer.surfaces()}
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
        target = drawing.Target(into.colour.texture, into.depth)
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


def _places(
    renderer: drawing.Server, blank: scenes.Scene, pieces: scenes.Pieces
) -> dict[tuple[int, bool], tuple[drawing.SceneBuffers, int]]:
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
