"""What every part of a picture is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import attrs

from ...frames.frame import Needs

if TYPE_CHECKING:
    import moderngl

    from ...frames.frame import EyeImage
    from ...geometry import View
    from ...gpu.context import Gpu
    from ...scenes import Scene
    from ..passes import ScenePasses
    from ..targets import Framebuffers, Target
    from ..upload import SceneTextures


@attrs.frozen(eq=False)
class DrawContext:
    """What parts draw with: the scene, its textures on the GPU, the plain surfaces' own passes (`colour`), framebuffers, and targets
    that are freed with the frame. acquire(size, kind, depth): kind as in gpu.textures, depth: with an r32f texture beside it."""

    gpu: Gpu
    scene: Scene
    textures: SceneTextures
    framebuffers: Framebuffers
    colour: ScenePasses
    acquire: Callable[..., Target]


@attrs.frozen(eq=False)
class Drawing:
    """What is asked for: the view as the eye has it, without guard band, (w, h) pixels of it, the layers wanted, the scene's clock.

    marched: plane mirrors show only what the picture itself shows, see Server.
    """

    view: View
    size: tuple[int, int]
    time_ns: int = 0
    needs: Needs = Needs()
    marched: bool = False


class Part(ABC):
    """One kind of content. Parts are added in the order of `order`, each to the picture that those before it have left."""

    name: ClassVar[str]
    order: ClassVar[int]

    def __init__(self, context: DrawContext) -> None:
        self.context = context

    @classmethod
    @abstractmethod
    def in_scene(cls, scene: Scene) -> bool:
        """Whether the scene has any of it."""

    @classmethod
    @abstractmethod
    def wanted(cls, needs: Needs) -> bool:
        """Whether any of it is asked for as a layer: then it is there, empty at worst, whatever the scene has."""

    @abstractmethod
    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        """Draw into the eye's colour and inverse depth what is not wanted as a layer; the eye with the layers that are."""

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:  # noqa: B027 (most have none)
        """Draw into an inverse depth, of all plain surfaces so far, what has a depth of its own in the picture."""

    @abstractmethod
    def close(self) -> None:
        """Free what it holds; programs belong to the shader library, acquired targets to the server."""
