"""Content of frames besides plain surfaces, by families: in the picture, or as layers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, ClassVar

import attrs
import moderngl

from ....frames import EyeImage, Needs
from ....frames.layers import layers
from ....geometry import View
from ....gpu.context import Gpu
from ....gpu.textures import COLOUR, SCALAR, allocate
from ....registry import Registry
from ....scenes import Scene
from ..passes import ScenePasses
from ..targets import Framebuffers, LastUsed, Renderer, Target
from ..upload import SceneTextures

parts: Registry[type[Part]] = Registry(
    "part",
    __name__,
    modules={
        **dict.fromkeys(("cube", "foveated", "views", "wide"), "views"),
        **dict.fromkeys(("cutouts", "light", "overlay", "panels", "peeled", "transparency"), "blended"),
        **dict.fromkeys(("difference", "scene_update"), "scene_update"),
    },
)


@attrs.frozen(eq=False)
class Drawing:
    """One picture to draw."""

    # The view as the eye has it, without guard band, and (w, h) pixels of it.
    view: View
    size: tuple[int, int]
    time_ns: int = 0  # the scene's clock
    needs: Needs = Needs()  # the layers to draw
    shown_size: tuple[int, int] | None = None  # (w, h) of the display's picture, where this one has another resolution
    marched: bool = False  # whether plane mirrors show only what the picture itself shows, see Server
    age_ns: int = 0  # how old the frame will be when it is seen
    client: Hashable = None  # for whom it is drawn, where that matters; None for the one that there is

    def of_light(self, view: View, size: tuple[int, int]) -> Drawing:
        """Return another picture at this instant, lit alike, without layers or overlays."""
        kept = {name for name in self.needs if layers.get(name).lights or layers.get(name).laid_over}
        needs = Needs(**{name: amount for name, amount in self.needs.items() if name in kept})
        return Drawing(view, size, self.time_ns, needs)


@attrs.frozen(eq=False)
class DrawContext:
    """The resources that parts draw with."""

    gpu: Gpu
    scene: Scene
    textures: SceneTextures  # the scene's, on the GPU
    framebuffers: Framebuffers
    colour: ScenePasses  # the passes of the plain surfaces
    # acquire(size, kind, depth=): a target that is freed with the frame; kind as in gpu.textures,
    # depth: with an r32f texture too.
    acquire: Callable[..., Target]
    # draw(view, size, drawing): draws a whole picture of another view.
    draw: Callable[[View, tuple[int, int], Drawing], EyeImage]
    # passes_for(drawing): the passes of the plain surfaces, lit as its layers say.
    passes_for: Callable[[Drawing], ScenePasses]
    # draw_colour(passes, view, into, time_ns): with as many samples a pixel as the picture has.
    draw_colour: Callable[[ScenePasses, View, moderngl.Texture, int], None]
    renderer: Callable[[Scene], Renderer]  # renderer(scene): a server of another scene; who makes it closes it


class Part(ABC):
    """One kind of content, added to the picture after the parts of a lower `order`.

    A part is made when a scene has any of its content, or when frames need a layer whose file names
    it in `drawn_by`: then the layer is always there, if only empty.
    """

    name: ClassVar[str]
    order: ClassVar[int]
    # Whether what it draws depends on the frames before: each client has its own then.
    of_client: ClassVar[bool] = False

    def __init__(self, context: DrawContext) -> None:
        self.context = context
        self._kept: LastUsed[tuple[str, tuple[int, int]], Target] = LastUsed()

    def kept(self, use: str, size: tuple[int, int], kind: tuple[int, str] = COLOUR, *, depth: bool = True) -> Target:
        """Return a target that belongs to the part, one for each use and size."""
        gl = self.context.gpu.gl
        return self._kept.made(
            (use, size), lambda: Target(allocate(gl, size, kind), allocate(gl, size, SCALAR) if depth else None)
        )

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        """Return whether the scene has any of it in the picture itself."""
        return False

    def passes_for(self, drawing: Drawing) -> ScenePasses | None:
        """Return what draws the plain surfaces in place of the server's passes, or None."""
        return None

    @abstractmethod
    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        """Draw what is not a needed layer into the eye; return the eye with its layers."""

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:  # noqa: B027 (most have none)
        """Draw content that has a depth into the inverse depth of the plain surfaces."""

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        """Return the layers that all eyes share, once a frame. views: with guard band."""
        return {}

    def heard(self, carried: Mapping[str, Any], arrived: bool, heard_ns: int) -> None:  # noqa: B027 (most do not)
        """Take note of whether a frame with these layers arrived, heard of at that instant."""

    def has_more(self, now_ns: int) -> bool:
        """Return whether it has something to send even if nothing has moved."""
        return False

    def trim(self) -> None:
        """Free kept targets as Renderer.trim() frees its own."""
        for _, target in self._kept.trimmed(lambda _, target: target.bytes):
            target.release(self.context.framebuffers.forget)

    def close(self) -> None:
        """Free its resources; the shader library owns programs, the server acquired targets."""
        for target in self._kept.values():
            target.release()
