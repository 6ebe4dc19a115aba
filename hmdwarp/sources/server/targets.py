"""Pools of texture pairs to draw into, allocated on demand and reused; what renders into them."""

from __future__ import annotations

import operator
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, TypeVar

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...base import MachineError, srgb8_from_linear
from ...frames import EyeImage, Frame
from ...frames.layers import layers
from ...geometry import Pose, View
from ...gpu import Gpu
from ...gpu.textures import COLOUR, SCALAR, Owner, allocate, check_size, release_all, texture_bytes
from ...scenes import Scene
from ..array_passes import Arrays, GiveCodes, Upload
from .passes import ScenePasses

MOST_SETTINGS = 8  # settings of a layer for which something is kept, of all clients: those of one request, at most
K = TypeVar("K")
V = TypeVar("V")
Size = tuple[int, int]
Kind = tuple[int, str]  # of a texture: components and type, as in gpu.textures
Forget = Callable[[moderngl.Texture], None]  # is called with each texture before it is freed
IDLE_AFTER = 2048  # after so many hand-outs what none of them needed is freed: half a minute of two eyes at 30 Hz
# What trim() leaves of each kind of memory that the last frame did not need.
MOST_IDLE_BYTES, MOST_IDLE = 16 << 20, 64


class LastUsed(dict[K, V]):
    """What was made once for each key, in the order of use; the longest unused comes first."""

    def __init__(self) -> None:
        super().__init__()
        self._used: set[K] = set()

    def made(self, key: K, make: Callable[[], V]) -> V:
        self[key] = found = self.pop(key) if key in self else make()
        self._used.add(key)
        return found

    def use(self, key: K) -> None:
        self._used.add(key)

    def beyond(self, most: int) -> list[V]:
        """Take out what is more than so many, the longest unused, and return it."""
        return [self.pop(key) for key in list(self)[: max(0, len(self) - most)]]

    def trimmed(self, bytes_of: Callable[[K, V], int]) -> list[tuple[K, V]]:
        """Take out what was not used since the last call, but a little: see MOST_IDLE."""
        idle = {key: bytes_of(key, value) for key, value in self.items() if key not in self._used}
        self._used.clear()
        found: list[tuple[K, V]] = []
        for key in list(idle):
            if sum(idle.values()) <= MOST_IDLE_BYTES and len(idle) <= MOST_IDLE:
                break
            del idle[key]
            found.append((key, self.pop(key)))
        return found


_DEPTH_BYTES = 4
_NAME = operator.attrgetter("glo")  # OpenGL's of a texture


@attrs.frozen(eq=False)
class Target:
    colour: moderngl.Texture  # rgba16f, or the format of its pool
    depth: moderngl.Texture | None = None  # r32f of the same size, None where only colour is kept

    @property
    def inverse_depth(self) -> moderngl.Texture:
        """The r32f texture. Errors: ValueError for a target without one."""
        if self.depth is None:
            raise ValueError("this target has no inverse depth: acquire one with depth=True")
        return self.depth

    @property
    def size(self) -> tuple[int, int]:
        return self.colour.size

    @property
    def bytes(self) -> int:
        return sum(map(texture_bytes, filter(None, (self.colour, self.depth))))

    def release(self, forget: Forget = lambda texture: None) -> None:
        for texture in (self.colour, self.depth):
            if texture is not None:
                forget(texture)
                texture.release()


class TargetPool:
    """Targets of one size and kind; those IDLE_AFTER hand-outs did not need are freed."""

    def __init__(self, gpu: Gpu, size: Size, kinds: Sequence[Kind], forget: Forget) -> None:
        self._gpu, self._size, self._kinds, self._forget = gpu, size, kinds, forget
        # The last one is handed out first, so what is not needed stays at the beginning.
        self._free: list[Target] = []
        self.out: dict[moderngl.Texture, Target] = {}  # those that are in use, by their colour texture
        # Hand-outs since idle ones were freed, and how many targets were out at most meanwhile.
        self._handed = self._most_out = 0

    @property
    def live(self) -> int:
        return len(self.out)

    @property
    def made(self) -> int:
        """How many targets exist, out or free: the most that were lately out at the same time."""
        return len(self.out) + len(self._free)

    def acquire(self) -> Target:
        made = None if self._free else [allocate(self._gpu.gl, self._size, kind) for kind in self._kinds]
        target = Target(*made) if made else self._free.pop()
        self.out[target.colour] = target
        self._handed, self._most_out = self._handed + 1, max(self._most_out, len(self.out))
        if self._handed == IDLE_AFTER:
            idle = self.made - self._most_out
            for unused in self._free[:idle]:
                unused.release(self._forget)
            del self._free[:idle]
            self._handed, self._most_out = 0, self.live
            # Not only for what was freed: each frame that came through leaves gaps in the heap.
            self._gpu.give_back_memory()
        return target

    @property
    def bytes(self) -> int:
        return sum(target.bytes for target in (*self._free, *self.out.values()))

    def take_back(self) -> None:
        self._free += self.out.values()
        self.out.clear()

    def release(self, colour: moderngl.Texture | Target) -> None:
        """Take back a target, by it or its colour. Errors: ValueError if it is not out."""
        key = colour.colour if isinstance(colour, Target) else colour
        if key not in self.out:
            raise ValueError("this target is not out: it was released before, or comes from another pool")
        self._free.append(self.out.pop(key))

    def close(self) -> None:
        for target in [*self._free, *self.out.values()]:
            target.release(self._forget)
        self._free.clear()
        self.out.clear()


class Renderer(Owner):
    """What gives frames in textures of its own pools; without a scene here it is empty."""

    samples: int = 1  # Of each pixel that is drawn; what a client draws beside it has as many.
    draw_frame: Callable[..., Frame]  # returns a frame with all eyes, and the needed layers, see Server.draw_frame
    draw_depth: Callable[..., moderngl.Texture]  # draws inverse depth alone, see Server.draw_depth

    def __init__(self, gpu: Gpu, scene: Scene, forget: Forget = lambda texture: None) -> None:
        self.gpu, self.scene, self._forget = gpu, scene, forget
        self._pools: LastUsed[tuple[Any, ...], TargetPool] = LastUsed()
        self._uploads: LastUsed[Size, Upload] = LastUsed()
        self._given: LastUsed[Size, GiveCodes] = LastUsed()

    def take_in(self, picture: Arrays, into: Target) -> None:
        upload = self._uploads.made(picture.size, lambda: Upload(self.gpu, picture.size))
        upload.run(picture, (into.colour, into.inverse_depth))

    def give_codes(self, eye: EyeImage) -> tuple[NDArray[np.uint8], NDArray[np.uint16], float]:
        """Return an eye's pictures in the half form of the feed, see GiveCodes."""
        giving = self._given.made(eye.size, lambda: GiveCodes(self.gpu, eye.size))
        return giving.run((eye.colour, eye.inverse_depth))

    def draw(self, view: View, size: Size, into: Target | None = None, time_ns: int = 0) -> EyeImage:
        """Return the whole picture of `view` at `time_ns`: the truth. into: a target, or None."""
        raise NotImplementedError

    def truth_facts(
        self, shown: Sequence[tuple[int, Pose]], missing: int, pixels_per_degree: float, *, own_head: bool
    ) -> tuple[dict[str, Any], str]:
        """Return what summary.json says of the truth, and a sentence, "" for a scene's own."""
        return {}, ""

    def content(self, time_ns: int) -> object:
        """Return what tells frames of an instant from others where no scene says what moves."""
        return None

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:
        """Take note of whether a frame arrived, which the server hears at that instant."""
        self.heard_of(None, frame.eyes[0].carried, arrived, heard_ns)

    def heard_of(self, client: Hashable, carried: Mapping[str, Any], arrived: bool, heard_ns: int) -> None:
        """Take note of whether a client's frame with these layers arrived."""

    def reacts_to(self, client: Hashable) -> bool:
        return self.scene.inputs is not None

    def begin_anew(self, client: Hashable) -> None:
        """Begin anew what builds on the frames before, for a client that has none of them."""
        self.forget(client)

    def forget(self, client: Hashable) -> None:
        """Free what depends on the frames that were drawn for a client."""

    def has_more(self, now_ns: int, client: Hashable = None) -> bool:
        """Return whether there is something to send even if nothing has moved."""
        return False

    def recycle(self, frame: Frame) -> None:
        """Take the frame's textures back; later frames will overwrite them."""
        for number, eye in frame.pictures():
            self.pool(eye.colour.size).release(eye.colour)
            for name, data in eye.carried.items():
                if number and layers.get(name).per_frame:
                    continue
                for texture in layers.get(name).textures(data):
                    for pool in self._pools.values():
                        if texture in pool.out:
                            pool.release(texture)
                layers.get(name).release(data)

    def acquire(self, size: Size, kind: Kind = COLOUR, *, depth: bool = True) -> Target:
        """Return a target from the pool of its kind; recycle() returns it with its frame."""
        return self.pool(size, kind, depth=depth).acquire()

    def pool(self, size: Size, kind: Kind = COLOUR, *, depth: bool = True) -> TargetPool:
        """Return the targets of that size and kind, with or without inverse depth."""
        kinds = (kind, SCALAR) if depth else (kind,)
        return self._pools.made((size, kinds), lambda: TargetPool(self.gpu, size, kinds, self._forget))

    def take_back(self) -> None:
        """Take back every target that is out: of a frame that could not be drawn to its end."""
        for pool in self._pools.values():
            pool.take_back()

    def trim(self) -> None:
        """Free targets that were not needed since the last call, but a few."""
        for key in [key for key, pool in self._pools.items() if pool.live]:
            self._pools.use(key)
        kinds: tuple[LastUsed[Any, Any], ...] = (self._pools, self._uploads, self._given)
        freed: list[Any] = [one for kind in kinds for _, one in kind.trimmed(lambda _, one: int(one.bytes))]
        for one in freed:
            one.close()
        if freed:
            self.gpu.give_back_memory()
        self.gpu.forget_released()

    def close(self) -> None:
        super().close()
        made: list[Any] = [*self._pools.values(), *self._uploads.values(), *self._given.values()]
        for one in made:
            one.close()


class Framebuffers:
    """Framebuffers over textures that others own; those of one size share a depth buffer."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._depth: LastUsed[Size, moderngl.Renderbuffer] = LastUsed()
        self._made: dict[tuple[int, ...], tuple[tuple[moderngl.Texture, ...], moderngl.Framebuffer]] = {}

    def over(self, *textures: moderngl.Texture) -> moderngl.Framebuffer:
        """Return the framebuffer that draws into `textures` of one size; created on first use."""
        # GL reuses the names of deleted textures, so the entry holds the textures and is checked
        # against them.
        key = tuple(map(_NAME, textures))
        held, framebuffer = self._made.get(key, ((), None))
        self._depth.use(textures[0].size)
        if framebuffer is None or not all(map(operator.is_, held, textures)):
            size = textures[0].size
            self.reserve(size)
            if framebuffer is not None:
                framebuffer.release()
            framebuffer = self._gl.framebuffer(list(textures), self._depth[size])
            self._made[key] = (textures, framebuffer)
        return framebuffer

    def forget(self, texture: moderngl.Texture) -> None:
        for key, (textures, framebuffer) in list(self._made.items()):
            if texture in textures:
                framebuffer.release()
                del self._made[key]

    def reserve(self, size: Size) -> None:
        """Allocate the depth buffer of that size now rather than at the first call of over()."""
        self._depth.made(size, lambda: self._gl.depth_renderbuffer(size))

    def trim(self) -> None:
        for size, depth in self._depth.trimmed(lambda size, _: _DEPTH_BYTES * size[0] * size[1]):
            for texture in {held[0] for held, _ in self._made.values() if held[0].size == size}:
                self.forget(texture)
            depth.release()

    def close(self) -> None:
        for _, framebuffer in self._made.values():
            framebuffer.release()
        for depth in self._depth.values():
            depth.release()
        self._made.clear()
        self._depth.clear()


class Multisampled:
    """Framebuffers with several samples a pixel. Errors: MachineError for more than the GPU has."""

    def __init__(self, gpu: Gpu, count: int) -> None:
        most = min(gpu.gl.info[f"GL_MAX_{kind}SAMPLES"] for kind in ("", "COLOR_TEXTURE_"))
        if count > most:
            raise MachineError(f"--samples {count}: {gpu.renderer} draws at most {most} a pixel; use as many or fewer")
        self._gpu, self.count, self._resolve = gpu, count, gpu.shaders.compute("server/resolve.comp")
        self._made: LastUsed[tuple[Any, ...], moderngl.Framebuffer] = LastUsed()

    def over(self, size: Size, *kinds: Kind) -> moderngl.Framebuffer:
        """Return a framebuffer over textures of these kinds, with depth, of undefined content."""
        gl, count = self._gpu.gl, self.count

        def make() -> moderngl.Framebuffer:
            check_size(gl, size)
            textures = [gl.texture(size, components, dtype=dtype, samples=count) for components, dtype in kinds]
            return gl.framebuffer(textures, gl.depth_renderbuffer(size, samples=count))

        return self._made.made((size, kinds), make)

    def draw(self, passes: ScenePasses, view: View, into: moderngl.Texture, time_ns: int) -> None:
        drawn = self.over(into.size, COLOUR)
        passes.draw(view, drawn, time_ns)
        self.mean(drawn, into)

    def mean(self, drawn: moderngl.Framebuffer, into: moderngl.Texture) -> None:
        """Write the mean of each pixel's samples; llvmpipe's own takes twice the time."""
        drawn.color_attachments[0].use(0)  # type: ignore[union-attr]  # a texture: it is made of these alone
        into.bind_to_image(0, read=False, write=True)
        self._resolve.uniforms.set(samples=0, resolved=0, count=self.count)
        self._gpu.barrier()
        self._resolve.run(*into.size)
        self._gpu.barrier()

    def trim(self) -> None:
        def bytes_of(_: object, one: moderngl.Framebuffer) -> int:
            textures = (each for each in one.color_attachments if isinstance(each, moderngl.Texture))
            return self.count * (sum(map(texture_bytes, textures)) + _DEPTH_BYTES * one.width * one.height)

        for _, framebuffer in self._made.trimmed(bytes_of):
            _free(framebuffer)

    def close(self) -> None:
        for framebuffer in self._made.values():
            _free(framebuffer)
        self._made.clear()


def _free(framebuffer: moderngl.Framebuffer) -> None:
    release_all(*framebuffer.color_attachments, framebuffer.depth_attachment, framebuffer)


BYTES_BINDING = 2  # as in shaders/lib/display_bytes.glsl


def display_bytes(gl: moderngl.Context) -> moderngl.Buffer:
    """Return the buffer of lib/display_bytes.glsl: the sRGB byte of each of the 65536 halves."""
    halves = np.arange(65536, dtype=np.uint16).view(np.float16)
    return gl.buffer(srgb8_from_linear(halves).tobytes())
